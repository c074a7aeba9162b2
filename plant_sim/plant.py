"""The true plant: one model run on floats, accurately integrated or from node to node."""

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import odeint

from obs_ros.core.model import Model
from obs_ros.integration.filter_pass import sizes
from obs_ros.integration.steps import rk4
from plant_sim.signals import Signal

State = tuple[float, ...]
SAME_NODE = 1e-6  # of a period: times are sums of floats


@dataclass(frozen=True)
class PlantSettings:
    """The accuracy of the truth, far beyond what any noise shows, and where its method changes.

    - `tolerance`, `share`: of a state's error in one interval, in its unit, and as a share of ten
      times its size (see `sizes`), its bounds' distance; the smaller one counts.
    - `rounding`: smallest error asked for, as a share of a state's value.
    - `halvings`: of an interval, at most: so short are steps where flows change sign.
    - `most_pairs`: of intervals that are compared with their halves, beyond those of `max_step` in
      one advance; stiff plants take more. At the kink of the three tanks they are 47.
    - `retried`: advances by the implicit method before RK4 is tried again.
    - `relative`, `absolute`: tolerances of the implicit method, for a state's value and for its
      size.
    - `most_steps`: of the implicit method in one advance; a second or so.
    """

    tolerance: float = 1e-8
    share: float = 1e-7
    rounding: float = 1e-13
    halvings: int = 24
    most_pairs: int = 200
    retried: int = 100
    relative: float = 1e-10
    absolute: float = 1e-12
    most_steps: int = 100_000


DEFAULT = PlantSettings()


class Plant:
    """Integrates `model` from state `x` at the time `start` (s).

    Each interval is done once in one and once in two RK4 steps, and halved until both agree. So a
    coarse sampling costs little where the plant is smooth, and its kinks are still hit. Where that
    takes too many intervals, as of a stiff plant, LSODA goes on (Petzold 1983): backward
    differentiation of orders 1 to 5.

    A discrete model goes from node to node, at whole periods, by the inputs and parameters at a
    node, and stays in between. `following` is the state that it has at the next node.
    """

    def __init__(
        self,
        model: Model,
        x: Sequence[float],
        *,
        start: float = 0.0,
        following: State | None = None,
        stiff: bool = False,
        settings: PlantSettings = DEFAULT,
    ) -> None:
        if len(x) != len(model.states):
            raise ValueError(
                f'model {model.name!r} has {len(model.states)} states, not {len(x)}: {tuple(x)}'
            )
        self.model = model
        self.t = start
        self.x: State = tuple(float(value) for value in x)
        self.following = following  # None: not known before the node's inputs are
        self._settings = settings
        size = 10.0 * sizes(model)[0, : len(self.x)]
        self._tolerance = np.minimum(settings.tolerance, settings.share * size).tolist()
        self._absolute = settings.absolute * size
        self._implicit = settings.retried if stiff else 0  # advances left
        self._pairs = 0  # that are left to RK4

    @property
    def stiff(self) -> bool:
        """Whether the implicit method is in use."""
        return self._implicit > 0

    def advance(self, to: float, u: Signal, p: Sequence[float]) -> None:
        """Move to time `to` (s) under the inputs `u`, the parameters `p` held."""
        if to < self.t:
            raise ValueError(f'the plant is at {self.t} s and cannot go back to {to} s')
        if self.model.period is not None:
            self._go(to, u, p, self.model.period)
            return
        if to == self.t:
            return
        x = None
        with np.errstate(all='ignore'):
            if self._implicit:
                self._implicit -= 1
                x = self._by_lsoda(to, u, p)
            if x is None:
                x = self._by_rk4(to, u, p)
            if x is None:
                x = self._by_lsoda(to, u, p)
                self._implicit = 0 if x is None else self._settings.retried
        self.x = (math.nan,) * len(self.x) if x is None else x
        self.t = to

    def _go(self, to: float, u: Signal, p: Sequence[float], period: float) -> None:
        """Move a discrete model to time `to`."""
        while self.t < to:
            node = math.floor(self.t / period + SAME_NODE)
            if self.following is None:
                t, f = node * period, self.model.dynamics
                self.following = tuple(float(value) for value in f(t, self.x, u(t), p))
            end = (node + 1) * period
            if end > to + SAME_NODE * period:
                self.t = to
                return
            self.x, self.following, self.t = self.following, None, max(end, self.t)
        self.t = to

    def output(self, u: Sequence[float], p: Sequence[float]) -> State:
        """Return the noise-free outputs now."""
        return tuple(float(y) for y in self.model.output(self.t, self.x, u, p))

    def _by_rk4(self, to: float, u: Signal, p: Sequence[float]) -> State | None:
        """Return the state at `to`; None if that takes too many intervals, or none is reached."""
        longest = min(self.model.max_step, to - self.t)
        steps = max(1, round((to - self.t) / longest))
        self._pairs = steps + self._settings.most_pairs
        dt, x = (to - self.t) / steps, self.x
        with suppress(ArithmeticError):  # where steps too long lead, floats overflow
            for k in range(steps):
                found = self._halved(self.t + k * dt, x, dt, u, p, self._settings.halvings)
                if found is None:
                    return None
                x = found
            return x
        return None

    def _halved(
        self, t: float, x: State, dt: float, u: Signal, p: Sequence[float], depth: int
    ) -> State | None:
        self._pairs -= 1
        if self._pairs < 0:
            return None
        half = 0.5 * dt
        f = self.model.dynamics
        first, second, middle, fourth, last = (u(t + part * dt) for part in (0, 0.25, 0.5, 0.75, 1))
        once = rk4(f, t, dt, x, first, middle, last, p)
        twice = rk4(f, t, half, x, first, second, middle, p)
        twice = rk4(f, t + half, half, twice, middle, fourth, last, p)
        if depth == 0 or self._agree(once, twice):
            return tuple(float(value) for value in twice)
        between = self._halved(t, x, half, u, p, depth - 1)
        return between and self._halved(t + half, between, half, u, p, depth - 1)

    def _agree(self, once: State, twice: State) -> bool:
        """Whether the error of `twice`, a fifteenth of the difference, is tolerated."""
        least = 15.0 * self._settings.rounding
        return all(
            abs(a - b) <= max(15.0 * tolerance, least * abs(b))
            for a, b, tolerance in zip(once, twice, self._tolerance, strict=True)
        )

    def _by_lsoda(self, to: float, u: Signal, p: Sequence[float]) -> State | None:
        """Return the state at `to`; None if LSODA does not reach it."""
        f, s = self.model.dynamics, self._settings
        absolute: Any = self._absolute  # SciPy's stubs know one for all only

        def rates(t: float, x: Any) -> Any:
            return f(t, tuple(x.tolist()), u(t), p)

        path, told = odeint(
            rates, self.x, np.array([self.t, to]), tfirst=True, rtol=s.relative,
            atol=absolute, mxstep=s.most_steps, full_output=True,
        )  # fmt: skip
        good = 'successful' in told['message'] and bool(np.isfinite(path[-1]).all())
        return tuple(path[-1].tolist()) if good else None
