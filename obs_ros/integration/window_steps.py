"""Candidates through a window by several methods and steps, judged by the outputs measured."""

import functools
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from obs_ros.core.model import Integrator, Model
from obs_ros.core.periods import shortest
from obs_ros.core.typing import Array, IntArray
from obs_ros.integration.backends import Backend, Kernels, kernels_for, tiny_window
from obs_ros.integration.grid import Grid
from obs_ros.integration.step_choice import (
    LARGEST,
    STEPPING,
    StepSettings,
    Verdict,
    common,
    doubling_error,
)

STILL = 1e-6  # of a state's size: what moves less counts as if it moved so much
LOST = 1e-3  # of a state's range by which an interval errs as much as a candidate is allowed


@dataclass(eq=False)
class Methods:
    """The kernels of a model by method, and the time that they took to compile, in s."""

    model: Model
    backend: Backend | None = None
    seconds: float = 0.0

    def kernels(self, method: str) -> Kernels:
        """Return the kernels that integrate by a method."""
        begin = time.perf_counter()
        kernels = kernels_for(by_method(self.model, method), self.backend)
        self.seconds += time.perf_counter() - begin
        return kernels

    def restarted(self, method: str) -> Callable[[Grid, Array, Array], Array]:
        """Return `Kernels.restarted` of a method."""
        kernels = self.kernels(method)
        begin = time.perf_counter()
        run_restarted_once(kernels.model, self.backend)
        self.seconds += time.perf_counter() - begin
        return kernels.restarted


@dataclass(frozen=True, eq=False)
class WindowTrial:
    """Candidates x0 (n, B), p (q, B) through a window, in units of the noise; see `Trial`.

    The grid's weights are one over the outputs' noise. The first candidate may err by `aimed`
    deviations at any output; the others, of a search, by that or a share of what they are off, root
    mean square.
    """

    methods: Methods
    grid: Grid
    x0: Array
    p: Array
    settings: StepSettings = field(default=STEPPING)

    def judge(self, method: str, steps: IntArray) -> Verdict:
        """See `Trial.judge`."""
        kernels, grid, known = self.methods.kernels(method), self.grid, self.grid.weight > 0.0
        weight = grid.weight[known][:, None]
        coarse, fine = (
            grid.shown(kernels.trajectories(grid.stepped(n * steps), self.x0, self.p)[1])[known]
            for n in (1, 2)
        )
        turns = np.broadcast_to(grid.period, known.shape)[known][:, None]
        with np.errstate(all='ignore'):
            off = weight * shortest(fine - grid.y[known][:, None], turns)
            errors = weight * doubling_error(shortest(coarse - fine, turns), method)
            allowed = np.maximum(self.settings.aimed, self.settings.share * _size(off))
            excess = _size(errors) / allowed
            excess[0] = (error := errors[:, 0].max(initial=0.0)) / self.settings.aimed
        excess = np.where(np.isfinite(excess), excess, np.inf)
        return Verdict(float(error) if np.isfinite(error) else np.inf, excess)

    def shares(self, method: str, steps: IntArray, verdict: Verdict) -> Array:
        """See `Trial.shares`.

        An interval errs by what one candidate's states differ at its end, by steps and by twice as
        many, from where they are at its begin; in units of the states' ranges.
        """
        grid, restarted = self.grid, self.methods.restarted(method)
        fine = grid.stepped(2 * steps)
        states = self.methods.kernels(method).trajectories(fine, self.x0, self.p)[0]
        with np.errstate(all='ignore'):
            ends = [restarted(each, states, self.p) for each in (grid.stepped(steps), fine)]
            size = np.maximum(np.ptp(states, axis=0), STILL * np.abs(states).max(axis=0))
            local = np.abs(ends[0] - ends[1]) / np.where(size > 0.0, size, 1.0)
            local = local.max(axis=1)
            total = local.sum(axis=0)
            each = np.where(np.isfinite(local), local / LOST, LARGEST)
            sound = np.isfinite(verdict.excess) & np.isfinite(total) & (total > 0.0)
            each = np.where(sound, local / total * verdict.excess, each)
        first, others = each[:, 0], common(each[:, 1:], self.settings.most)
        wanted = common(verdict.excess[1:], self.settings.most)
        if np.isfinite(wanted) and others.sum() > 0.0:
            others = others * (wanted / others.sum())
        return np.maximum(first, others)


@functools.lru_cache(maxsize=64)
def by_method(model: Model, method: str, longest: float | None = None) -> Model:
    """Return the model integrated by a method, in steps of `longest` s at most, if given."""
    changes: dict[str, object] = {} if method == model.method else {'integrator': method}
    if longest is not None and longest < model.max_step:
        changes['max_step'] = longest
    return replace(model, **changes) if changes else model  # type: ignore[arg-type]


@functools.lru_cache(maxsize=64)
def run_restarted_once(model: Model, backend: Backend | None) -> None:
    """Run once, which compiles it, what only the choice of steps needs."""
    grid, x0, p = tiny_window(model)
    kernels_for(model, backend).restarted(grid, np.repeat(x0[None], 2, axis=0), p)


def cost_of_step(model: Model, method: str) -> float:
    """Return the cost of one step, in evaluations of the model's dynamics."""
    if method == 'euler':
        return 1.0
    n = len(model.states)
    return 4.0 if method == 'rk4' else 4.0 + 0.5 * n + n * n / 10.0


def methods_of(integrator: Integrator) -> tuple[str, ...]:
    """Return the methods among which to choose for a model: the one given, or RK4 first."""
    return ('rk4', 'rosenbrock') if integrator == 'auto' else (integrator,)


def _size(values: Array) -> Array:
    """Return the root mean square (B,) of values (M, B)."""
    return np.sqrt(np.mean(values**2, axis=0)) if len(values) else np.zeros(values.shape[1])
