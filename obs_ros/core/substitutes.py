"""Functions of NumPy, of math and of Python, as they are while a plant's function is recorded.

They accept symbols, and arrays of symbols, where the original ones want numbers; without a symbol
each is the original.
"""

import builtins
import functools
import math
import sys
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from obs_ros.core.recorder import LIMITS, Untraceable
from obs_ros.core.symbols import (
    NUMBERS,
    Symbol,
    arithmetic,
    elementwise,
    is_symbolic,
    select,
    spread,
)

_MATHS: dict[Callable[..., Any], Callable[..., Any]] = {
    math.sin: np.sin, math.cos: np.cos, math.tan: np.tan,
    math.asin: np.arcsin, math.acos: np.arccos, math.atan: np.arctan, math.atan2: np.arctan2,
    math.sinh: np.sinh, math.cosh: np.cosh, math.tanh: np.tanh,
    math.asinh: np.arcsinh, math.acosh: np.arccosh, math.atanh: np.arctanh,
    math.sqrt: np.sqrt, math.exp: np.exp, math.expm1: np.expm1,
    math.log10: np.log10, math.log2: np.log2, math.log1p: np.log1p,
    math.pow: np.power, math.fabs: np.abs, math.fmod: np.fmod, math.copysign: np.copysign,
    math.floor: np.floor, math.ceil: np.ceil, math.trunc: np.trunc,
    math.degrees: np.degrees, math.radians: np.radians,
    math.isnan: np.isnan, math.isinf: np.isinf, math.isfinite: np.isfinite,
}  # fmt: skip
_SPECIAL = {math.erf: 'erf', math.erfc: 'erfc', math.gamma: 'gamma', math.lgamma: 'gammaln'}


def _unless_plain(original: Callable[..., Any], own: Callable[..., Any]) -> Callable[..., Any]:
    """Return the original where no argument holds a symbol, else its substitute."""

    @functools.wraps(original, updated=())
    def chosen(*values: Any, **options: Any) -> Any:
        if is_symbolic(values) or is_symbolic(tuple(options.values())):
            return own(*values, **options)
        return original(*values, **options)

    return chosen


def _log(x: Any, base: Any = None) -> Any:
    found = elementwise(np.log, x)
    return found if base is None else found / elementwise(np.log, base)


def _hypot(*values: Any) -> Any:
    if len(values) == 2:
        return elementwise(np.hypot, *values)
    return elementwise(np.sqrt, sum(value * value for value in values))


def _single(template: str) -> Callable[..., Any]:
    """Return the substitute of a function of one argument that NumPy has no ufunc for."""

    def apply(value: Any, *options: Any, **more: Any) -> Any:
        if any(options) or any(more.values()):
            raise Untraceable(f'use {template.format("...")} without options')
        return spread(lambda v: arithmetic(template, v) if is_symbolic(v) else v, value)

    return apply


def _where(condition: Any, *both: Any) -> Any:
    if len(both) != 2:
        raise Untraceable('use np.where with three arguments')
    return spread(select, condition, *both)


def _clip(a: Any, a_min: Any = None, a_max: Any = None, min: Any = None, max: Any = None) -> Any:
    low, high = (a_min if min is None else min), (a_max if max is None else max)
    if low is None or high is None:
        found = a if low is None else elementwise(np.maximum, a, low)
        return found if high is None else elementwise(np.minimum, found, high)
    return spread(_clipped, a, low, high)


def _clipped(*values: Any) -> Any:
    if is_symbolic(values):
        return arithmetic('np.clip({}, {}, {})', *values)
    return float(np.clip(*values))


def _select(conditions: Sequence[Any], choices: Sequence[Any], default: Any = 0) -> Any:
    found = default
    for condition, choice in reversed(list(zip(conditions, choices, strict=True))):
        found = _where(condition, choice, found)
    return found


def _interp(x: Any, xp: Any, fp: Any) -> Any:
    """Return np.interp(x, xp, fp), which selects among the lines between the table's entries."""
    xs, ys = list(xp), list(fp)
    if len(xs) > LIMITS.table:
        raise Untraceable(f'use a formula in place of a table of more than {LIMITS.table} entries')

    def at(entry: Any) -> Any:
        found = ys[0]
        for k in range(len(xs) - 1):
            line = (ys[k + 1] - ys[k]) / (xs[k + 1] - xs[k]) * (entry - xs[k]) + ys[k]
            # NaN is on no side of the table.
            found = select(entry < xs[0], found, line) if k == 0 else select(
                entry >= xs[k], line, found
            )  # fmt: skip
        return select(entry >= xs[-1], ys[-1], found)

    return spread(at, x)


def _least_of(original: Callable[..., Any], ufunc: Any) -> Callable[..., Any]:
    """Return the substitute of min or max, of several values or one sequence, Python's or NumPy's.

    With options, or along an axis, it is the original that compares one by one.
    """

    def apply(*values: Any, **options: Any) -> Any:
        several = len(values) > 1
        if options or (several and not all(isinstance(v, (Symbol, *NUMBERS)) for v in values)):
            return original(*values, **options)
        entries = list(values) if several else np.asarray(values[0], dtype=object).ravel()
        return functools.reduce(lambda a, b: elementwise(ufunc, a, b), entries)

    return apply


def _array(value: Any, *_: Any, **__: Any) -> Any:
    return np.array(value, dtype=object)


def _open_to_symbols(original: Callable[..., Any]) -> Callable[..., Any]:
    """Return a maker of arrays of floats whose entries may become symbols."""

    @functools.wraps(original)
    def make(*values: Any, **options: Any) -> Any:
        kind = options.pop('dtype', None)
        made = original(*values, **options)
        if kind is not None and kind is not Float and np.dtype(kind).kind not in 'fO':
            return made.astype(kind)
        return made.astype(object)

    return make


def _solve(matrix: Any, right: Any) -> Any:
    """Return np.linalg.solve(matrix, right): elimination, the largest pivot chosen by selects."""
    A, b = np.array(matrix, dtype=object), np.array(right, dtype=object)
    n = len(A)
    if A.shape != (n, n) or n > LIMITS.order:
        raise Untraceable(f'use systems of {LIMITS.order} equations at most in np.linalg.solve')
    rows = np.column_stack([A, b])
    for k in range(n):
        for r in range(k + 1, n):
            swap = spread(abs, rows[r, k]) > spread(abs, rows[k, k])
            rows[k], rows[r] = _where(swap, rows[r], rows[k]), _where(swap, rows[k], rows[r])
        for r in range(k + 1, n):
            rows[r, k:] = rows[r, k:] - rows[r, k] / rows[k, k] * rows[k, k:]
    x = rows[:, n:]
    for k in reversed(range(n)):
        x[k] = (x[k] - sum(rows[k, j] * x[j] for j in range(k + 1, n))) / rows[k, k]
    return x if b.ndim == 2 else x[:, 0]


def _inverse(matrix: Any) -> Any:
    return _solve(matrix, np.eye(len(matrix)))


class _Floats(type):
    """The kind of `float` that lets symbols pass."""

    def __instancecheck__(cls, value: Any) -> bool:
        return isinstance(value, float | Symbol)

    def __call__(cls, value: Any = 0.0) -> Any:
        return value if isinstance(value, Symbol) else float(value)


class Float(metaclass=_Floats):
    """Python's float, and np.float64, while a function is recorded."""


def _special(original: Callable[..., Any], name: str) -> Callable[..., Any]:
    """Return the substitute of a function that scipy.special has by this name."""
    return _unless_plain(original, _single(f'special.{name}({{}})'))


def _substitutes() -> list[tuple[Any, Any]]:
    """Return every function that has a substitute, with that."""
    found = [
        (original, _unless_plain(original, functools.partial(elementwise, ufunc)))
        for original, ufunc in _MATHS.items()
    ]
    for original, name in _SPECIAL.items():
        found.append((original, _special(original, name)))
    own_ones: dict[Callable[..., Any], Callable[..., Any]] = {
        math.log: _log, math.hypot: _hypot, np.where: _where, np.clip: _clip, np.select: _select,
        np.interp: _interp, np.linalg.solve: _solve, np.linalg.inv: _inverse,
        np.round: _single('np.round({})'), np.sinc: _single('np.sinc({})'),
        np.nan_to_num: _single('np.nan_to_num({})'),
        builtins.min: _least_of(builtins.min, np.minimum),
        builtins.max: _least_of(builtins.max, np.maximum),
        np.min: _least_of(np.min, np.minimum), np.max: _least_of(np.max, np.maximum),
        np.amin: _least_of(np.amin, np.minimum), np.amax: _least_of(np.amax, np.maximum),
        np.around: _single('np.round({})'),
        np.array: _array, np.asarray: _array,
    }  # fmt: skip
    found += [(original, _unless_plain(original, own)) for original, own in own_ones.items()]
    makers = (np.zeros, np.ones, np.empty, np.full, np.zeros_like, np.ones_like, np.empty_like,
              np.full_like, np.eye, np.identity)  # fmt: skip
    found += [(original, _open_to_symbols(original)) for original in makers]
    return [*found, (float, Float), (np.float64, Float)]


SUBSTITUTES = {id(original): own for original, own in _substitutes()}
BUILTINS = {name: SUBSTITUTES[id(getattr(builtins, name))] for name in ('min', 'max', 'float')}


@functools.cache
def of_ufunc(ufunc: Any) -> Callable[..., Any]:
    """Return the substitute of a ufunc."""
    return _unless_plain(ufunc, functools.partial(elementwise, ufunc))


def _of_scipy(value: Any) -> Callable[..., Any] | None:
    """Return the substitute of a function of scipy.special; whoever uses that has imported it."""
    special: Any = sys.modules.get('scipy.special')
    names = (name for name in _SPECIAL.values() if getattr(special, name, None) is value)
    found = next(names, None)
    return None if value is None or found is None else _special(value, found)


def substitute(value: Any) -> Any:
    """Return what stands for a function while it is recorded; None where that is itself."""
    found = SUBSTITUTES.get(id(value)) or _of_scipy(value)
    if found is None and isinstance(value, np.ufunc) and value.signature is None:
        return of_ufunc(value)
    return found
