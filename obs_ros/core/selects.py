"""NumPy functions of one candidate, as selects: neither branches nor allocations.

Numba compiles `np.where` of scalars by way of arrays in memory, which keeps the lanes from being
vectorised and costs a hundred times the step itself; `np.clip` and others it does not compile. LLVM
turns the conditional expressions below into selects. NaN goes where NumPy lets it go. Of two values
the second, or the bound, is tested for NaN: where it is constant, that costs nothing.
"""

import math
import sys
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from obs_ros.core.elementary import ELEMENTARY
from obs_ros.core.float_bits import ONE, SIGN, bits, number


def where(condition: Any, x: Any, y: Any) -> Any:
    """Compute np.where(condition, x, y)."""
    return x if condition else y


def minimum(x1: Any, x2: Any) -> Any:
    """Compute np.minimum(x1, x2): NaN if one of them is."""
    return x2 if (x2 < x1) | (x2 != x2) else x1


def maximum(x1: Any, x2: Any) -> Any:
    """Compute np.maximum(x1, x2): NaN if one of them is."""
    return x2 if (x2 > x1) | (x2 != x2) else x1


def fmin(x1: Any, x2: Any) -> Any:
    """Compute np.fmin(x1, x2): the other one where one is NaN."""
    return x2 if (x2 < x1) | (x1 != x1) else x1


def fmax(x1: Any, x2: Any) -> Any:
    """Compute np.fmax(x1, x2): the other one where one is NaN."""
    return x2 if (x2 > x1) | (x1 != x1) else x1


def clip(a: Any, a_min: Any = None, a_max: Any = None, min: Any = None, max: Any = None) -> Any:
    """Compute np.clip(a, a_min, a_max), by whatever names; None is no bound."""
    return lowered(lowered(raised(raised(a, a_min), min), a_max), max)


def raised(a: Any, low: Any) -> Any:
    """Return a, or the bound where a is below it; None is no bound."""
    if low is None:
        return a
    return maximum(a, low)


def lowered(a: Any, high: Any) -> Any:
    """Return a, or the bound where a is above it; None is no bound."""
    if high is None:
        return a
    return minimum(a, high)


def sign(x: Any) -> Any:
    """Compute np.sign(x): -1, 0, 1 or NaN."""
    one = number((bits(x) & SIGN) | ONE)
    return one if (x > 0) | (x < 0) else x


def heaviside(x1: Any, x2: Any) -> Any:
    """Compute np.heaviside(x1, x2): x2 where x1 is 0, and NaN where it is NaN."""
    return 1.0 if x1 > 0 else (0.0 if x1 < 0 else (x2 if x1 == 0 else x1))


def erf(x: Any) -> Any:
    """Compute scipy.special.erf(x)."""
    return math.erf(x)


def erfc(x: Any) -> Any:
    """Compute scipy.special.erfc(x)."""
    return math.erfc(x)


def gamma(x: Any) -> Any:
    """Compute scipy.special.gamma(x)."""
    return math.gamma(x)


def gammaln(x: Any) -> Any:
    """Compute scipy.special.gammaln(x)."""
    return math.lgamma(x)


def psi(x: Any) -> Any:
    """Compute scipy.special.psi(x): recurrence to 8 and above, and the asymptotic series there.

    Below 0 by reflection. Abramowitz & Stegun 1964, 6.3.5, 6.3.7 and 6.3.18.
    """
    z = 1.0 - x if x < 0.0 else x
    s, total = z, 0.0
    for _ in range(8):
        total -= 1.0 / s
        s += 1.0
    q = 1.0 / (s * s)
    total += (
        math.log(s)
        - 0.5 / s
        - q
        * (1 / 12 - q * (1 / 120 - q * (1 / 252 - q * (1 / 240 - q * (1 / 132 - q * 691 / 32760)))))
    )
    return total - math.pi / math.tan(math.pi * x) if x < 0.0 else total


SELECTS: dict[Callable[..., Any], Callable[..., Any]] = {
    **{getattr(np, name): own for name, own in ELEMENTARY.items()},
    np.where: where,
    np.minimum: minimum,
    np.maximum: maximum,
    np.fmin: fmin,
    np.fmax: fmax,
    np.clip: clip,
    np.sign: sign,
    np.heaviside: heaviside,
}
SPECIAL = {each.__name__: each for each in (erf, erfc, gamma, gammaln, psi)}  # of scipy.special

# Functions that are no ufuncs, and yet compile to arithmetic.
ARITHMETIC = {np.round, np.around, np.nan_to_num, np.sinc, np.angle, np.real, np.imag}


def selects() -> Mapping[Callable[..., Any], Callable[..., Any]]:
    """Return the twins of NumPy's functions, and of SciPy's.

    Whoever uses those has imported scipy.special, which takes a sixth of a second: nobody else
    has to wait for it.
    """
    special = sys.modules.get('scipy.special')
    there = {getattr(special, name): own for name, own in SPECIAL.items() if hasattr(special, name)}
    return {**SELECTS, **there}


def makes_arrays(value: Any) -> bool:
    """Whether this is a function of NumPy's that takes memory each time it is called."""
    return (
        callable(value)
        and (getattr(value, '__module__', None) or '').partition('.')[0] == 'numpy'
        and not isinstance(value, (np.ufunc, type))
        and value not in SELECTS
        and value not in ARITHMETIC
    )
