"""Candidates through a window by several methods and steps, judged by the outputs measured."""

import functools
from dataclasses import dataclass, field, replace

import numpy as np

from obs_ros.core.jit import unhurried
from obs_ros.core.linear_algebra import poles
from obs_ros.core.model import Integrator, Model
from obs_ros.core.periods import shortest, shortest_way
from obs_ros.core.typing import Array, IntArray
from obs_ros.integration.backends import Backend, Kernels, kernels_for
from obs_ros.integration.grid import Grid
from obs_ros.integration.step_trials import (
    LARGEST,
    STEPPING,
    StepSettings,
    Verdict,
    common,
    counted_together,
    doubling_error,
    own_error,
)
from obs_ros.integration.time_scales import STIFF, fastest_decay, jacobians

STILL = 1e-6  # of a state's size: what moves less counts as if it moved so much
LOST = 1e-3  # of a state's range by which an interval errs as much as a candidate is allowed


@dataclass(frozen=True, eq=False)
class Methods:
    """The kernels of a model by method."""

    model: Model
    backend: Backend | None = None

    def kernels(self, method: str) -> Kernels:
        """Return the kernels that integrate by a method."""
        return kernels_for(by_method(self.model, method), self.backend)


@dataclass(frozen=True, eq=False)
class WindowTrial:
    """Candidates x0 (n, B), p (q, B) through a window, in units of the noise; see `Trial`.

    The grid's weights are one over the outputs' noise. Candidates may err by `aimed` deviations
    or a share of what they are off, root mean square: the first one at any output, the others, of a
    search, root mean square too.
    """

    methods: Methods
    grid: Grid
    x0: Array
    p: Array
    settings: StepSettings = field(default=STEPPING)

    @functools.cached_property
    def _verdicts(self) -> dict[tuple[str, bytes], Verdict]:
        """The verdicts so far, by method and steps: those who choose ask for some again."""
        return {}

    def judge(self, method: str, steps: IntArray) -> Verdict:
        """See `Trial.judge`."""
        key = method, steps.tobytes()
        if key not in self._verdicts:
            grids = (self.grid.stepped(n * steps) for n in (1, 2))
            self._verdicts[key] = self._judged(method, *grids)
        return self._verdicts[key]

    def takes_own(self, method: str) -> bool:
        """See `Trial.takes_own`."""
        return method == 'rosenbrock' and self.methods.kernels(method).own_steps

    def judge_own(self, method: str, tolerance: float) -> tuple[Verdict, IntArray]:
        """See `Trial.judge_own`."""
        budget = self.settings.own + 10 * int(self.grid.steps.sum())
        grid = replace(self.grid, tolerance=tolerance, budget=budget)
        counts = self.methods.kernels(method).counts(grid, self.x0, self.p)
        return self._judged(method, grid, grid.finer()), counts

    def _judged(self, method: str, coarse_grid: Grid, fine_grid: Grid) -> Verdict:
        """Return how far the candidates are apart on two grids."""
        kernels, grid, own = self.methods.kernels(method), self.grid, coarse_grid.tolerance > 0.0
        coarse, fine = (
            np.ascontiguousarray(grid.shown(kernels.trajectories(each, self.x0, self.p)[1]))
            for each in (coarse_grid, fine_grid)
        )
        with np.errstate(all='ignore'):
            worst, sizes, off = differences(coarse, fine, grid.y, grid.weight, grid.period)
            sizes, worst = (
                own_error(each) if own else doubling_error(each, method) for each in (sizes, worst)
            )
            together = float(np.sqrt(np.count_nonzero(grid.weight)) * sizes[0])
            sizes[0] = worst[0] = counted_together(float(worst[0]), together, self.settings)
            share = np.full(len(off), self.settings.share)
            share[0] = self.settings.reference
            excess = sizes / np.maximum(self.settings.aimed, share * off)
        excess[~(np.isfinite(excess) & np.isfinite(off))] = np.inf
        error, largest = (float(e) if np.isfinite(e) else np.inf for e in (worst[0], sizes.max()))
        return Verdict(error, excess, largest)

    def decays(self) -> bool:
        """See `Trial.decays`; candidates are looked at where they start.

        An implicit method leads across the pole of a solution, to where no plant can be: it has
        to be needed.
        """
        grid, model = self.grid, self.methods.model
        longest = float(np.diff(grid.t).max())
        every = jacobians(model, grid.clock[0], self.x0, grid.u[0], self.p)
        return any(fastest_decay(poles(J)) * longest > STIFF.dies for J in every)

    def shares(self, method: str, steps: IntArray, verdict: Verdict) -> Array:
        """See `Trial.shares`.

        An interval errs by what one candidate's states differ at its end, by steps and by twice as
        many, from where they are at its begin; in units of the states' ranges. Of candidates that
        leave the measurements altogether, it is in units of the states there: where such a one
        ends says nothing of the steps that it needed from the begin.
        """
        grid, kernels = self.grid, self.methods.kernels(method)
        fine = grid.stepped(2 * steps)
        states = kernels.trajectories(fine, self.x0, self.p)[0]
        with np.errstate(all='ignore'):
            ends = [kernels.restarted(each, states, self.p) for each in (grid.stepped(steps), fine)]
            size = np.maximum(np.ptp(states, axis=0), STILL * np.abs(states).max(axis=0))
            lost = ~(verdict.excess < LARGEST)
            here = np.maximum(np.abs(states[:-1]), np.abs(states[1:]))
            size = np.where(lost, here, size)
            local = np.abs(ends[0] - ends[1]) / np.where(size > 0.0, size, 1.0)
            local = local.max(axis=1)
            total = local.sum(axis=0)
            each = np.where(np.isfinite(local), local / LOST, LARGEST)
            sound = ~lost & np.isfinite(total) & (total > 0.0)
            each = np.where(sound, local / total * verdict.excess, each)
        asked = verdict.excess <= common(verdict.excess[1:], self.settings.most)
        asked[0] = True
        return np.asarray(each[:, asked].max(axis=1))


def by_method(model: Model, method: str, longest: float | None = None) -> Model:
    """Return the model integrated by a method, in steps of `longest` s at most, if given."""
    changes: dict[str, object] = {} if method == model.method else {'integrator': method}
    if longest is not None and longest < model.max_step:
        changes['max_step'] = longest
    return _changed(model, tuple(changes.items())) if changes else model


@functools.lru_cache(maxsize=64)
def _changed(model: Model, changes: tuple[tuple[str, object], ...]) -> Model:
    """Return the model with some fields changed, the same one at each call."""
    return replace(model, **dict(changes))  # type: ignore[arg-type]


def methods_of(integrator: Integrator) -> tuple[str, ...]:
    """Return the methods among which to choose for a model: the one given, or RK4 first."""
    return ('rk4', 'rosenbrock') if integrator == 'auto' else (integrator,)


def differences_on_arrays(
    coarse: Array, fine: Array, y: Array, weight: Array, period: Array
) -> tuple[Array, Array, Array]:
    """Return the same on whole arrays."""
    known = weight > 0.0
    factor = weight[known][:, None]
    turns = np.broadcast_to(period, known.shape)[known][:, None]
    errors = factor * np.abs(shortest(coarse[known] - fine[known], turns))
    off = factor * shortest(fine[known] - y[known][:, None], turns)
    if not known.any():
        return np.zeros((3, coarse.shape[2]))  # type: ignore[return-value]
    worst = np.where(np.isfinite(errors), errors, np.inf).max(axis=0)
    share = 1.0 / len(errors)
    sums = (np.add.accumulate(each * each)[-1] for each in (errors, off))
    return worst, *(np.sqrt(share * each) for each in sums)


def _differences(
    coarse: Array, fine: Array, y: Array, weight: Array, period: Array
) -> tuple[Array, Array, Array]:
    """Return how far outputs (K, r, B) differ, in units of one over weights (K, r).

    Of each candidate, over what was measured: the largest difference of coarse steps from fine
    ones, its root mean square, and that of the difference of fine ones from the measurements
    y (K, r), all by the shortest way round the periods (r,).
    """
    nodes, outputs, lanes = coarse.shape
    worst, sizes, off = np.zeros(lanes), np.zeros(lanes), np.zeros(lanes)
    count = 0
    for k in range(nodes):
        for i in range(outputs):
            factor, turn = weight[k, i], period[i]
            if factor > 0.0:
                count += 1
                rough, exact, measured = coarse[k, i], fine[k, i], y[k, i]
                for lane in range(lanes):
                    there = exact[lane]
                    error, away = rough[lane] - there, there - measured
                    if turn > 0.0:
                        error, away = shortest_way(error, turn), shortest_way(away, turn)
                    error, away = factor * abs(error), factor * away
                    worst[lane] = max(worst[lane], error) if error < np.inf else np.inf
                    sizes[lane] += error * error
                    off[lane] += away * away
    share = 1.0 / max(1, count)
    for lane in range(lanes):
        sizes[lane], off[lane] = np.sqrt(share * sizes[lane]), np.sqrt(share * off[lane])
    return worst, sizes, off


differences = unhurried(_differences, differences_on_arrays, exact=True)


@functools.cache
def prepare() -> None:
    """Compile what is above, or load it compiled."""
    a, one = np.ones(1), np.ones((1, 1))
    differences(one[None], one[None], one, one, a)
