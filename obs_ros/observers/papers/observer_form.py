"""Plants of order n in observer form, one input and one output, and the base of their observers.

x' = [-a | I; 0] x + b u, y = x1, with a = (a_{n-1}, ..., a_0) and b = (b_{n-1}, ..., b_0) unknown
(Gremling & Passino 2000, eqs. 12-13). Filtered by 1 / Lambda(s), Lambda monic and Hurwitz, the
plant is the linear regression z = theta' phi (eq. 16) with

    theta = (b, a),   phi = (alpha(s) / Lambda(s) u, -alpha(s) / Lambda(s) y),
    z = s^n / Lambda(s) y,   alpha(s) = (s^{n-1}, ..., s, 1).
"""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from obs_ros.core.jit import accelerated
from obs_ros.core.model import Model
from obs_ros.core.typing import Array, IntArray
from obs_ros.integration.path import Path
from obs_ros.observers import settings as table
from obs_ros.observers.output_intake import Instant
from obs_ros.observers.recursive import RecursiveObserver
from obs_ros.observers.settings import setting


@dataclass(frozen=True)
class ObserverFormSettings(table.Settings):
    """The paper's choices for order 3; a plant of order n takes n entries in each."""

    observer: tuple[float, ...] = setting(
        (12.0, 47.0, 60.0), "coefficients a* of the observer's polynomial, s^(n-1) first",
        lower=-1e9, upper=1e9,
    )  # fmt: skip
    filter: tuple[float, ...] = setting(
        (3.0, 3.0, 1.0), 'coefficients of the filter Lambda(s), s^(n-1) first', lower=-1e9,
        upper=1e9,
    )  # fmt: skip
    a: tuple[float, ...] = setting(
        (3.0, 3.0, 1.0), 'a at the start, where no initial value is given', lower=-1e9, upper=1e9
    )
    b: tuple[float, ...] = setting(
        (1.0, 0.0, 0.0), 'b at the start, where no initial value is given', lower=-1e9, upper=1e9
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ('observer', 'filter'):
            roots = np.roots([1.0, *getattr(self, name)])
            if not np.all(roots.real < 0.0):
                raise ValueError(
                    f'{name} {getattr(self, name)} is not stable: '
                    f'a root has the real part {max(roots.real):g}'
                )


class ObserverFormObserver(RecursiveObserver):
    """Adapts theta from the filtered signals, and with it an adaptive Luenberger observer (eq. 14).

    xhat' = [-ahat | I; 0] xhat + bhat u + (a* - ahat) (y - xhat1).

    The equations are integrated by RK4 from output to output, the output taken as a straight line,
    in steps that resolve the observer's polynomial and the filter.
    Parameters that are not estimated keep their value. Bounds are not heeded: the law that the
    papers prove to converge does not know them.
    """

    Settings: ClassVar[type[table.Settings]] = ObserverFormSettings
    needs_outputs: ClassVar[bool] = True
    compared: ClassVar[int] = 8  # random points at which a model must be like the form
    step: ClassVar[float] = 0.25  # of the shortest time constant: the longest RK4 step, to 1e-5

    def __init__(self, model: Model | str, **arguments: Any) -> None:
        super().__init__(model, **arguments)
        n = self.x.size
        for name in ('observer', 'filter', 'a', 'b'):
            entries = getattr(self.settings, name)
            if len(entries) != n:
                raise ValueError(
                    f'{name} {entries} has {len(entries)} entries, but model {self.model.name!r} '
                    f'is of order {n}'
                )
        free = np.zeros(2 * n)
        free[self.unknowns.index[self.unknowns.index >= n] - n] = 1.0
        given = arguments.get('initial') or {}
        for i, variable in enumerate(self.model.parameters):
            if free[i] and variable.name not in given:
                self.initial[n + i] = (*self.settings.a, *self.settings.b)[i]
        self._free = np.concatenate([free[n:], free[:n]])  # in the order of theta = (b, a)
        self._observer = np.array(self.settings.observer)
        self._filter = np.array(self.settings.filter)
        # xhat, the filtered u and y, theta
        self._s = np.empty(5 * n)
        self._normalised = True
        self._gain = np.zeros(2 * n)
        roots = [np.roots([1.0, *each]) for each in (self._observer, self._filter)]
        inputs = self._samples.inputs
        inputs.longest = min(inputs.longest, self.step / float(np.abs(roots).max()))
        self._set_out()

    @classmethod
    def suits(cls, model: Model) -> None:
        """Raise ValueError unless the model is in observer form."""
        n = len(model.states)
        counts = len(model.inputs), len(model.outputs), len(model.parameters)
        if counts != (1, 1, 2 * n):
            raise ValueError(
                f'model {model.name!r} has {counts[0]} inputs, {counts[1]} outputs and {counts[2]} '
                f'parameters: {cls.__name__} is for plants in observer form, with one, one and '
                f'twice the {n} states, a then b'
            )
        rng = np.random.default_rng(0)
        for _ in range(cls.compared):
            x, u, a, b = rng.normal(size=n), rng.normal(), rng.normal(size=n), rng.normal(size=n)
            rates = model.dynamics(0.0, tuple(x), (u,), (*a, *b))
            if not (
                np.allclose(rates, np.append(x[1:], 0.0) - a * x[0] + b * u)
                and np.allclose(model.output(0.0, tuple(x), (u,), (*a, *b)), x[:1])
            ):
                raise ValueError(
                    f'model {model.name!r} is not in observer form, x1 measured and '
                    "xi' = x(i+1) - a(n-i) x1 + b(n-i) u"
                )

    def _start(self, now: Instant) -> None:
        n = self.x.size
        self._s[:] = 0.0
        self._s[:n] = self.x
        self._s[3 * n : 4 * n], self._s[4 * n :] = self.p[n:], self.p[:n]
        self.innovation[:] = now.y - self.x[:1]

    def _step(self, before: Instant, now: Instant, path: Path) -> None:
        n, interval = self.x.size, (now.stamp - before.stamp) / 1e9
        # Where the model stands in for a silent sensor, theta would learn from itself.
        silent = self._intake.silent
        gain = np.zeros_like(self._gain) if silent else self._gain
        advance(
            self._s, path.pieces, path.dt, path.steps, path.u, path.slope, before.y, now.y,
            interval, self._observer, self._filter, gain, self._normalised,
        )  # fmt: skip
        if not silent:
            self._adapt(now, interval)
        self.x[:] = self._s[:n]
        self.p[:n], self.p[n:] = self._s[4 * n :], self._s[3 * n : 4 * n]
        self.innovation[:] = now.y - self.x[:1]

    def _adapt(self, now: Instant, interval: float) -> None:
        """Change theta at a sample; the gradient law does it on the way."""


@accelerated
def rates(
    s: Array, u: float, y: float, observer: Array, filtr: Array, gain: Array, normalised: bool,
    d: Array,
) -> None:  # fmt: skip
    """Write the time derivatives of s = (xhat, filtered u, filtered y, theta) into d (5 n,)."""
    n = observer.size
    eps, norm = regression_error(s, y, filtr)
    if normalised:
        eps /= norm
    error = y - s[0]
    for i in range(n):
        a = s[4 * n + i]
        d[i] = -a * s[0] + s[3 * n + i] * u + (observer[i] - a) * error
        if i + 1 < n:
            d[i] += s[i + 1]
        d[3 * n + i] = gain[i] * eps * s[n + i]
        d[4 * n + i] = -gain[n + i] * eps * s[2 * n + i]
    for first, fed in ((n, u), (2 * n, y)):
        d[first] = fed
        for i in range(n):
            d[first] -= filtr[i] * s[first + i]
        for i in range(1, n):
            d[first + i] = s[first + i - 1]


@accelerated
def regression_error(s: Array, y: float, filtr: Array) -> tuple[float, float]:
    """Return z - theta' phi, and 1 + phi' phi."""
    n = filtr.size
    eps, norm = y, 1.0
    for i in range(n):
        u_i, y_i = s[n + i], s[2 * n + i]
        # z = y - Lambda's lower coefficients on the filtered y.
        eps -= filtr[i] * y_i + s[3 * n + i] * u_i - s[4 * n + i] * y_i
        norm += u_i * u_i + y_i * y_i
    return eps, norm


@accelerated
def advance(
    s: Array, pieces: int, dt: Array, steps: IntArray, u: Array, slope: Array, y0: Array, y1: Array,
    interval: float, observer: Array, filtr: Array, gain: Array, normalised: bool,
) -> None:  # fmt: skip
    """Integrate s over a path by RK4, with y a straight line from y0 to y1."""
    k1, k2, k3, k4 = np.empty(s.size), np.empty(s.size), np.empty(s.size), np.empty(s.size)
    since, rise = 0.0, (y1[0] - y0[0]) / interval
    for k in range(pieces):
        h = dt[k] / steps[k]
        for j in range(steps[k]):
            at = j * h
            u0, y = u[k, 0] + at * slope[k, 0], y0[0] + (since + at) * rise
            half, full = 0.5 * h * slope[k, 0], h * slope[k, 0]
            rates(s, u0, y, observer, filtr, gain, normalised, k1)
            y += 0.5 * h * rise
            rates(s + 0.5 * h * k1, u0 + half, y, observer, filtr, gain, normalised, k2)
            rates(s + 0.5 * h * k2, u0 + half, y, observer, filtr, gain, normalised, k3)
            y += 0.5 * h * rise
            rates(s + h * k3, u0 + full, y, observer, filtr, gain, normalised, k4)
            for i in range(s.size):
                s[i] += h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i])
        since += dt[k]
