"""A model with its settings: poses windows, fits them, and solves them one by one."""

import time
from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from obs_ros.core import linear_algebra, residual_tests
from obs_ros.core.deadline import Deadline
from obs_ros.core.estimate import Estimate, Outcome
from obs_ros.core.jit import at_once
from obs_ros.core.model import Model, checked_noise, names
from obs_ros.core.periods import continuous, periods
from obs_ros.core.prior_knowledge import with_knowledge
from obs_ros.core.record import Record
from obs_ros.core.saturation import unsaturated
from obs_ros.core.typing import Array
from obs_ros.horizon.alone import best_alone, explained_alone
from obs_ros.horizon.fitting import fitted, reweighted
from obs_ros.horizon.integration_error import Answer
from obs_ros.horizon.search import searched
from obs_ros.horizon.settings import (
    POSING,
    EstimationSettings,
    check_misfit,
    with_process_noise,
    with_starts,
)
from obs_ros.horizon.stepping import Integration
from obs_ros.horizon.unsolvable import TooFewSamples, Unsolvable, check_steps
from obs_ros.horizon.warm_start import propagated
from obs_ros.inference import objective
from obs_ros.inference.assessment import informed_subspace, profile_steps
from obs_ros.inference.assessment.assemble import empty
from obs_ros.inference.disturbed import process_noise_rehearsed
from obs_ros.inference.jumps import linearisation, schedule, screening
from obs_ros.inference.jumps.sensitivities import jumps_rehearsed
from obs_ros.inference.noise import noise_guess
from obs_ros.inference.objective import Objective
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.inference.prior import Posterior, Prior
from obs_ros.inference.window_state import WindowState
from obs_ros.integration import window_steps
from obs_ros.integration.backends import Kernels, check_backend, kernels_for, rollouts_rehearsed
from obs_ros.integration.grid import Grid
from obs_ros.integration.live_steps import IMPLICIT
from obs_ros.integration.time_scales import may_be_stiff
from obs_ros.integration.window_steps import by_method
from obs_ros.optimization.methods import Method, method_for
from obs_ros.optimization.result import Found
from obs_ros.samples.range_check import without_absurd

# Modules with loops that every window needs.
LOOPS = (residual_tests, linear_algebra, objective, linearisation, profile_steps, window_steps)


@dataclass(frozen=True)
class Solver:
    """A model with its checked settings: solves windows by themselves, poses and fits the others.

    `noise` is what the settings give, `method_settings` are of the method's own type.
    """

    unknowns: Unknowns
    method: Method
    method_settings: Any
    noise: Mapping[str, float]
    settings: EstimationSettings

    @classmethod
    def of(cls, model: Model, settings: EstimationSettings | None = None) -> 'Solver':
        """Check the settings; raises ValueError with the name and the value that is wrong."""
        settings = settings or EstimationSettings()
        model = with_knowledge(model, settings.walks, settings.priors)
        unknowns = Unknowns.of(
            model, settings.parameters, settings.states, settings.fixed, settings.bounds
        )
        method, method_settings = method_for(settings.search, settings.search_options)
        check_misfit(settings, method)
        noise = checked_noise(model, settings.noise)
        check_backend(settings.backend)
        settings = with_process_noise(settings, model, method)
        settings = with_starts(settings, unknowns)
        return cls(unknowns, method, method_settings, noise, settings)

    @property
    def model(self) -> Model:
        """The plant."""
        return self.unknowns.model

    @cached_property
    def integration(self) -> Integration:
        """The choice of method and steps."""
        return Integration.of(self.unknowns, self.settings.backend)

    @property
    def given_noise(self) -> Array:
        """Standard deviations (r,) of the outputs that are given, NaN for the others."""
        return np.array([self.noise.get(name, np.nan) for name in names(self.model.outputs)])

    @cached_property
    def kernels(self) -> Kernels:
        """The model's rollouts, each compiled at its first call, which may take a second."""
        return kernels_for(self.model, self.settings.backend)

    @cached_property
    def likely_kernels(self) -> list[Kernels]:
        """The rollouts by all methods that a window is likely to need."""
        if self.model.integrator != 'auto' or not may_be_stiff(self.model):
            return [self.kernels]
        implicit = by_method(self.model, IMPLICIT)
        return [self.kernels, kernels_for(implicit, self.settings.backend)]

    @np.errstate(all='ignore')
    def prepare(self, *, process_noise: bool = True) -> float:
        """Compile what every window needs, and what `process_noise` does; return the seconds.

        What is not compiled here is at its first call, the time of which no deadline counts.
        """
        begin = time.perf_counter()
        with at_once():
            deque(self.needed(), maxlen=0)
            if process_noise:
                deque(self.rehearsed(), maxlen=0)
        return time.perf_counter() - begin

    def needed(self) -> Iterator[None]:
        """Compile, one thing at a time, what every window needs."""
        for kernels in self.likely_kernels:
            yield from rollouts_rehearsed(kernels)
        self.unknowns.prepare()
        for module in (*LOOPS, informed_subspace):
            module.prepare()
        yield

    def rehearsed(self) -> Iterator[None]:
        """Compile, one thing at a time, what only some windows need."""
        for module in (screening, schedule):
            module.prepare()
            yield
        for kernels in self.likely_kernels:
            yield from jumps_rehearsed(kernels)
        if (mode := self.settings.process_noise) != 'off':
            for kernels in self.likely_kernels:
                yield from process_noise_rehearsed(kernels, self.unknowns, ramps=mode == 'auto')

    @np.errstate(all='ignore')  # data or model may overflow: what is not finite says so itself
    def solve(
        self,
        record: Record,
        rng: np.random.Generator,
        deadline: Deadline,
        previous: Estimate | None = None,
        *,
        first: bool = True,
    ) -> Estimate:
        """Estimate one window, the `first` one or another; see `solve_window`."""
        record, absurd = without_absurd(record)
        try:
            estimate = self._solve(record, rng, deadline, previous, first)
        except Unsolvable as error:
            estimate = empty(self.model, record, error.outcome, str(error))
        if not absurd:
            return estimate
        said = f'{absurd} values beyond any signal of this window count as not measured'
        return replace(estimate, message=f'{estimate.message}; {said}')

    def _solve(
        self,
        record: Record,
        rng: np.random.Generator,
        deadline: Deadline,
        previous: Estimate | None,
        first: bool,
    ) -> Estimate:
        begun = Deadline()
        known = self.method.needs_squares and len(self.noise) == len(self.model.outputs)
        window = self.pose(record, prior=Prior.known(self.unknowns, start=first), noise_known=known)
        warm = self.warm_start(record, previous)
        window = self.integration.begun(window, warm, None)
        estimate, answer = self._explained(window, rng, deadline, warm)
        for _ in range(self.integration.attempts):
            if answer.fine or deadline.passed:
                break
            finer = self.integration.finer(window, answer)
            if finer is window:
                break
            window = finer
            estimate, answer = self._explained(window, rng, deadline, answer.z)
        estimate = replace(estimate, solve_time=begun.elapsed)
        return answer.told(estimate)

    def _explained(
        self, window: WindowState, rng: np.random.Generator, deadline: Deadline, warm: Array | None
    ) -> tuple[Estimate, Answer]:
        """Return the estimate of a window in given steps, and how exact these are."""
        window, found = self.fit(window, window.with_given_priors, rng, deadline, warm)
        if not np.isfinite(found.cost):
            return self.diverged(window), Answer(window.objective, None)
        if not self.method.needs_squares:
            return best_alone(window, found, deadline)
        mode = self.settings.process_noise
        return explained_alone(window, found, self.given_noise, mode, deadline)

    def pose(
        self,
        record: Record,
        scale: Array | None = None,
        prior: Prior | None = None,
        *,
        noise_known: bool,
        correlation: float = 0.0,
    ) -> WindowState:
        """Return a window's objective and prior, outputs in units of `scale` (r,).

        `scale` None means the noise, given or guessed; 1 for fitnesses other than squares. `prior`
        None means the given ones, of a first window. Raises Unsolvable.
        """
        if (turns := periods(self.model.outputs)).any():
            record = record.with_outputs(continuous(record.t, record.y, turns))
        check_steps(self.model, record)
        grid = Grid.of(self.model, record, self._scale(record) if scale is None else scale)
        objective = Objective(self.kernels, grid, self.unknowns, self.settings.fitness)
        values, dimension = objective.count(objective.nodes), objective.dimension
        needed = dimension if noise_known else POSING.values_per_unknown * dimension
        if values < needed:
            raise TooFewSamples(
                'take a longer window, estimate less, or give the noise: '
                f'{values} measured values for {dimension} unknowns, at least {needed} are needed'
            )
        prior = prior or Prior.known(self.unknowns, start=True)
        robust = self.settings.loss == 'robust'
        return WindowState(record, objective, prior, noise_known, correlation, robust=robust)

    def warm_start(
        self, record: Record, previous: Estimate | None, kernels: Kernels | None = None
    ) -> Array | None:
        """Return the point (d,) that the previous estimate expects, or else the initial values.

        None where there is neither. `kernels` go on from there, if not those of the model.
        """
        if previous is None or not previous.usable:
            initial = self.settings.initial
            given = dict.fromkeys(self.unknowns.names, np.nan) | dict(initial)
            return self.unknowns.point(given) if initial else None
        if tuple(previous.state) != names(self.model.states):
            raise ValueError(
                f'the previous estimate is not of model {self.model.name!r}: '
                f'its states are {", ".join(previous.state)}'
            )
        start = propagated(kernels or self.kernels, previous, record)
        return self.unknowns.point({**previous.parameters, **start})

    def fit(
        self,
        window: WindowState,
        problem: Objective | Posterior,
        rng: np.random.Generator,
        deadline: Deadline,
        warm: Array | None,
    ) -> tuple[WindowState, Found]:
        """Search the optimum of the window's objective or posterior, the `problem`.

        Where the noise is guessed, outputs are weighted by their residuals: the window that is
        returned has other scales.
        """
        known, squares = window.noise_known, self.method.needs_squares

        def search(costs: Objective | Posterior, start: Array | None) -> Found:
            return searched(self.method, self.method_settings, costs, rng, deadline, start, known)

        window, found = fitted(
            window, problem, search, self.integration, deadline, warm, squares=squares
        )
        if squares and not known and np.isfinite(found.cost):
            guessed = np.array([name not in self.noise for name in names(self.model.outputs)])
            return reweighted(window, found, guessed, deadline)
        return window, found

    def diverged(self, window: WindowState) -> Estimate:
        """Return the estimate of a window in which every candidate diverged."""
        return empty(
            self.model,
            window.record,
            Outcome.DIVERGED,
            f'narrow the bounds: all {window.objective.evaluations} candidates diverged',
        )

    def _scale(self, record: Record) -> Array:
        """Return scales (r,) of the outputs: noise, given or guessed; 1 for other fitnesses."""
        if self.settings.fitness != 'least_squares':
            return np.ones(len(self.model.outputs))
        outputs = self.model.outputs
        values = zip(outputs, unsaturated(outputs, record.y).T, strict=False)
        return np.array([
            self.noise.get(v.name) or noise_guess(y, rounding=v.rounding) for v, y in values
        ])  # fmt: skip
