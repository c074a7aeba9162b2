"""The true plant: one model run on floats, accurately integrated or from node to node."""

import math
from collections.abc import Sequence

from obs_ros.core.model import Model
from obs_ros.integration.steps import rk4
from plant_sim.signals import Signal

State = tuple[float, ...]
SAME_NODE = 1e-6  # of a period: times are sums of floats


class Plant:
    """Integrates `model` from state `x` at the time `start` (s).

    Each interval is done once in one and once in two RK4 steps, and halved until both agree within
    `tolerance` (in the states' units, per interval), `halvings` times at most: so short are steps
    where flows change sign (square roots). So a coarse sampling costs little where the plant is
    smooth, and its kinks are still hit.

    A discrete model goes from node to node, at whole periods, by the inputs and parameters at a
    node, and stays in between. `following` is the state that it has at the next node.
    """

    def __init__(
        self,
        model: Model,
        x: Sequence[float],
        tolerance: float = 1e-8,
        halvings: int = 24,
        start: float = 0.0,
        following: State | None = None,
    ) -> None:
        if len(x) != len(model.states):
            raise ValueError(
                f'model {model.name!r} has {len(model.states)} states, not {len(x)}: {tuple(x)}'
            )
        self.model = model
        self.t = start
        self.x: State = tuple(float(value) for value in x)
        self._tolerance = tolerance
        self._halvings = halvings
        self.following = following  # None: not known before the node's inputs are

    def advance(self, to: float, u: Signal, p: Sequence[float]) -> None:
        """Move to time `to` (s) under the inputs `u`, the parameters `p` held."""
        if to < self.t:
            raise ValueError(f'the plant is at {self.t} s and cannot go back to {to} s')
        if self.model.period is not None:
            self._go(to, u, p, self.model.period)
            return
        longest = min(self.model.max_step, to - self.t)
        if longest <= 0.0:
            return
        start, steps = self.t, max(1, round((to - self.t) / longest))
        dt = (to - start) / steps
        for k in range(steps):
            self.x = self._integrate(start + k * dt, self.x, dt, u, p, self._halvings)
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

    def _integrate(
        self, t: float, x: State, dt: float, u: Signal, p: Sequence[float], depth: int
    ) -> State:
        half = 0.5 * dt
        f = self.model.dynamics
        first, second, middle, fourth, last = (u(t + part * dt) for part in (0, 0.25, 0.5, 0.75, 1))
        once = rk4(f, t, dt, x, first, middle, last, p)
        twice = rk4(f, t, half, x, first, second, middle, p)
        twice = rk4(f, t + half, half, twice, middle, fourth, last, p)
        error = max(abs(a - b) for a, b in zip(once, twice, strict=True))
        # Not "error > tolerance": a NaN is handed on, not halved 2**24 times.
        if not error > 15.0 * self._tolerance or depth == 0:
            return tuple(float(value) for value in twice)
        x = self._integrate(t, x, half, u, p, depth - 1)
        return self._integrate(t + half, x, half, u, p, depth - 1)
