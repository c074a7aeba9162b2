"""Method and steps of a window's integration: chosen before its search, judged at its optimum.

Only the noise says how exact a rollout must be: see `integration/step_choice`. Before a search the
reference is where it is expected to end, by the window before or the nominal values, beside a
spread of candidates over the box; after it, the optimum that it found.
"""

import functools
from dataclasses import dataclass

import numpy as np

from obs_ros.core.changes import replace
from obs_ros.core.model import Model
from obs_ros.core.rng import random_generator
from obs_ros.core.typing import Array, IntArray
from obs_ros.horizon.integration_error import Answer, error_at, noise_of
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.inference.window_state import WindowState
from obs_ros.integration.backends import Backend
from obs_ros.integration.grid import TIGHTER, Grid, steps_within
from obs_ros.integration.path import LANES
from obs_ros.integration.step_choice import by_own_steps, chosen
from obs_ros.integration.step_cost import cost_of_step
from obs_ros.integration.step_trials import ORDERS, STEPPING, Choice
from obs_ros.integration.window_steps import (
    Methods,
    WindowTrial,
    by_method,
    methods_of,
)

SAME = 0.01  # of a step: stamps jitter by some share of the interval


@dataclass(frozen=True)
class SteppingMemory:
    """Method and steps of a window, without its model; see `Stepping`."""

    method: str
    t: Array
    h: Array
    plain: bool
    error: float
    tolerance: float
    budget: int


@dataclass(frozen=True, eq=False)
class Stepping:
    """Method and steps of one window: h (K - 1,) s in the intervals between t (K,) s.

    `plain` are the steps that the model's `max_step` asks for; `error` is what those of its answer
    count for, in deviations of the noise. Of candidates with steps of their own by a `tolerance`
    and within a `budget`, h are those of the optimum.
    """

    model: Model
    method: str
    t: Array
    h: Array
    plain: bool
    error: float
    tolerance: float = 0.0
    budget: int = 0

    @classmethod
    def of(cls, answer: Answer) -> 'Stepping':
        """Return the method and steps with which a window was answered."""
        objective = answer.objective
        model, grid = objective.unknowns.model, objective.grid
        plain = np.array_equal(grid.steps, steps_within(model, np.diff(grid.t)))
        plain = plain and not grid.tolerance
        h = np.diff(grid.t) / grid.steps
        own = grid.tolerance, grid.budget
        return cls(model, objective.kernels.model.method, grid.t, h, plain, answer.counted, *own)

    @property
    def memory(self) -> SteppingMemory:
        """All of it but the model."""
        own = self.tolerance, self.budget
        return SteppingMemory(self.method, self.t, self.h, self.plain, self.error, *own)

    @property
    def usual(self) -> float:
        """The step (s) of most intervals."""
        return float(np.median(self.h))

    @property
    def between(self) -> Model:
        """The model for what lies between windows; its step is one of a few, as it is compiled."""
        if self.plain:
            return by_method(self.model, self.method)
        step = 2.0 ** (np.floor(4.0 * np.log2(self.usual)) / 4.0)
        return by_method(self.model, self.method, float(step))

    def steps(self, grid: Grid) -> IntArray:
        """Return the steps (K - 1,) for another window: as before where that was, else as usual."""
        if self.plain:
            return grid.steps
        middle = 0.5 * (grid.t[1:] + grid.t[:-1])
        place = np.searchsorted(self.t, middle) - 1
        inside = (place >= 0) & (place < self.h.size)
        h = np.where(inside, self.h[np.clip(place, 0, self.h.size - 1)], self.usual)
        return np.maximum(grid.steps, np.ceil(np.diff(grid.t) / h - SAME).astype(np.int64))


@dataclass(frozen=True, eq=False)
class Integration:
    """The choice of method and steps for windows of one model."""

    methods: Methods
    unknowns: Unknowns

    @classmethod
    def of(cls, unknowns: Unknowns, backend: Backend | None) -> 'Integration':
        """Return the choice for the unknowns' model."""
        return cls(Methods(unknowns.model, backend), unknowns)

    @property
    def attempts(self) -> int:
        """Times that an answer is found anew in finer steps, at most."""
        return STEPPING.attempts

    def begun(
        self, window: WindowState, warm: Array | None, before: Stepping | None
    ) -> WindowState:
        """Return the window in the steps that its search needs, those `before` if they do.

        `warm` (d,) is where the search is expected to end. Steps that were exact where the window
        before ended are not tried again at a start: the answer of this one tells.
        """
        if self.unknowns.model.period is not None:
            return replace(window, exact=True)  # a discrete model integrates nothing
        if before is not None and (choice := self._again(window, warm, before)) is not None:
            return self._with(window, choice)
        return self._with(
            window, self._chosen(self._spread(window, warm), window.objective.grid.steps)
        )

    def _again(self, window: WindowState, warm: Array | None, before: Stepping) -> Choice | None:
        """Return the choice of the window before, None if it does not suffice."""
        own = before.tolerance, before.budget
        base = window.objective.grid.steps
        steps = base if before.tolerance > 0.0 else before.steps(window.objective.grid)
        if warm is not None and before.error <= STEPPING.safety * STEPPING.aimed:
            return Choice(before.method, steps, before.error, np.inf, np.inf, *own)
        trial = self._spread(window, warm)
        if before.tolerance > 0.0:
            choice = by_own_steps(trial, before.method, base, before.tolerance)
        else:
            verdict = trial.judge(before.method, steps)
            error, worst = verdict.error, verdict.worst()
            choice = Choice(before.method, steps, error, worst, verdict.largest)
        return choice if choice.fine else None

    def refined(self, window: WindowState, z: Array) -> WindowState:
        """Return the window in finer steps where it errs too much at its optimum z (d,)."""
        objective = window.objective
        rolled = objective.trajectory(z)
        noise = noise_of(window, rolled[1])
        method, grid = objective.kernels.model.method, objective.grid
        trial = self._trial(window, z[None], noise)
        if method == 'rosenbrock' or grid.injection is not None:
            error = error_at(objective, z, noise, rolled)
        else:  # which the choice of steps asks for too
            error = trial.judge(method, grid.steps).error
        if error <= STEPPING.aimed:
            return window
        if grid.tolerance > 0.0:
            tolerance = TIGHTER * grid.tolerance
            if tolerance < STEPPING.tightest:
                return window
            base = steps_within(self.unknowns.model, np.diff(grid.t))
            return self._with(window, by_own_steps(trial, method, base, tolerance))
        methods = methods_of(self.unknowns.model.integrator)
        methods = methods[methods.index(method) :]
        base = grid.steps
        if len(methods) == 1:
            return self._with(window, self._chosen(trial, base, methods))
        base = steps_within(self.unknowns.model, np.diff(grid.t))
        return self._with(window, self._chosen(trial, base, methods))

    def finer(self, window: WindowState, answer: Answer) -> WindowState:
        """Return the window in finer steps than those that erred too much at its answer.

        Where it errs by its jumps or its process noise alone, steps are finer everywhere.
        """
        if answer.z is None:
            return window
        refined = self.refined(window, answer.z)
        if refined is not window:
            return refined
        method, grid = window.objective.kernels.model.method, window.objective.grid
        factor = (answer.counted / (STEPPING.safety * STEPPING.aimed)) ** (1.0 / ORDERS[method])
        factor = np.clip(np.ceil(factor), 2.0, STEPPING.growth)
        if not np.isfinite(factor) or factor * grid.steps.sum() > STEPPING.steps + grid.steps.sum():
            return window
        finer = grid.finer()
        return self._with(window, Choice(
            method, grid.steps * int(factor), answer.counted, np.inf, np.inf, finer.tolerance,
            finer.budget,
        ))  # fmt: skip

    def tighter(self, window: WindowState) -> WindowState:
        """Return a window of candidates' own steps in much finer ones; itself if it has none."""
        grid = window.objective.grid
        tolerance = min(STEPPING.smooth, TIGHTER * grid.tolerance)
        if not tolerance >= STEPPING.tightest:
            return window
        finer = replace(grid, tolerance=tolerance, budget=4 * grid.budget)
        return replace(window, objective=replace(window.objective, grid=finer))

    def counted(self, window: WindowState, z: Array) -> WindowState:
        """Return the window with the own steps of its optimum z (d,), for all that takes a grid's.

        Filters, and rollouts that measurements correct, go by these.
        """
        objective = window.objective
        grid = objective.grid
        if not grid.tolerance > 0.0:
            return window
        counts = objective.kernels.counts(grid, *self.unknowns.values(z[None]))[:, 0]
        steps = np.maximum(steps_within(self.unknowns.model, np.diff(grid.t)), counts)
        return replace(window, objective=replace(objective, grid=grid.stepped(steps)))

    def otherwise(self, window: WindowState) -> WindowState | None:
        """Return the window by the next method, in its fewest steps; None if there is no other.

        Where candidates with steps of their own are lost, as among endless switches, they share
        those of the grid.
        """
        grid = window.objective.grid
        if grid.tolerance > 0.0:
            method = window.objective.kernels.model.method
            return self._with(window, Choice(method, grid.steps, np.inf, np.inf))
        methods = methods_of(self.unknowns.model.integrator)
        left = methods[methods.index(window.objective.kernels.model.method) + 1 :]
        if not left:
            return None
        trial = self._trial(window, spread_over_box(self.unknowns.dimension), None)
        if not trial.decays():
            return None
        steps = steps_within(self.unknowns.model, np.diff(window.objective.grid.t))
        if trial.takes_own(left[0]):
            return self._with(window, by_own_steps(trial, left[0], steps, STEPPING.loosest))
        return self._with(window, Choice(left[0], steps, np.inf, np.inf))

    def _chosen(
        self, trial: WindowTrial, base: IntArray, methods: tuple[str, ...] | None = None
    ) -> Choice:
        model = self.unknowns.model
        methods = methods or methods_of(model.integrator)
        return chosen(trial, methods, base, functools.partial(cost_of_step, model))

    def _spread(self, window: WindowState, warm: Array | None) -> WindowTrial:
        """Return where a search is expected to end, and a spread over the box, to roll out."""
        reference = self.unknowns.point(nominal(self.unknowns)) if warm is None else warm
        spread = spread_over_box(self.unknowns.dimension)
        return self._trial(window, np.vstack([reference, spread]), None)

    def _trial(self, window: WindowState, points: Array, noise: Array | None) -> WindowTrial:
        """Return points (B, d) to roll out through a window, errors in units of noise (r,)."""
        grid = window.objective.grid.uncorrected
        noise = noise_of(window) if noise is None else noise
        weight = np.where(grid.weight > 0.0, 1.0 / noise, 0.0)
        grid = replace(grid, weight=weight, tolerance=0.0)
        return WindowTrial(self.methods, grid, *self.unknowns.values(points))

    def _with(self, window: WindowState, choice: Choice) -> WindowState:
        """Return the window in the method and the steps chosen."""
        objective = window.objective
        if choice.method != objective.kernels.model.method:
            objective = replace(objective, kernels=self.methods.kernels(choice.method))
        if not np.array_equal(choice.steps, objective.grid.steps):
            objective = replace(objective, grid=objective.grid.stepped(choice.steps))
        own = choice.tolerance, choice.budget
        if own != (objective.grid.tolerance, objective.grid.budget):
            grid = replace(objective.grid, tolerance=own[0], budget=own[1])
            objective = replace(objective, grid=grid)
        exact = choice.fine and choice.largest < STEPPING.safety * STEPPING.aimed
        if objective is window.objective and exact == window.exact:
            return window
        return replace(window, objective=objective, exact=exact)


def nominal(unknowns: Unknowns) -> dict[str, float]:
    """Return the nominal values of the unknowns by name; NaN where there is none."""
    values = {v.name: v.nominal for v in unknowns.model.variables}
    return {name: np.nan if values[name] is None else values[name] for name in unknowns.names}  # type: ignore[misc]


@functools.lru_cache(maxsize=64)
def spread_over_box(dimension: int, count: int = LANES - 1) -> Array:
    """Return points (count, d) of the unit box, the same ones always: a Latin hypercube."""
    order = np.argsort(random_generator(0).random((dimension, count)), axis=1)
    points = np.asarray((order.T + 0.5) / count)
    points.flags.writeable = False
    return points
