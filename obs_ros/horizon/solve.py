"""The front door: the states and parameters that explain one window of measurements best."""

import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from obs_ros.core.deadline import Deadline
from obs_ros.core.estimate import Estimate, Outcome
from obs_ros.core.model import Model, checked_noise, names
from obs_ros.core.record import Record
from obs_ros.core.registry import suggest
from obs_ros.core.typing import Array
from obs_ros.horizon.warm_start import propagated
from obs_ros.inference.assessment.assemble import Uncertainty, empty, output_rms, report
from obs_ros.inference.assessment.informed_subspace import marginal_information
from obs_ros.inference.jumps.jump_search import hypothesis_at
from obs_ros.inference.jumps.piecewise import Layout, PiecewiseProblem
from obs_ros.inference.noise import variances_left
from obs_ros.inference.objective import FITNESSES, ROUNDING, Fitness, Objective
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.inference.prior import Posterior, Prior
from obs_ros.integration.backends import Backend, Kernels, check_backend, kernels_for
from obs_ros.integration.grid import Grid
from obs_ros.models import load_model
from obs_ros.optimization import lm_linalg
from obs_ros.optimization.levenberg_marquardt import LMSettings, Trail, levenberg_marquardt
from obs_ros.optimization.memetic import MemeticSettings
from obs_ros.optimization.methods import Method, method_for
from obs_ros.optimization.result import Found
from obs_ros.samples.range_check import without_absurd

# Outputs whose residuals turn out more unequal than this, against their scales, are weighted anew.
UNEQUAL = 1.2
REWEIGHTINGS = 3
FEWEST = 4  # measured values for each unknown, where the noise is not given
MEDIAN_BEND = 0.6745 * 6**0.5  # median of the second differences of unit white noise


def solve_window(
    model: Model | str,
    record: Record,
    search: str | Method = 'memetic',
    *,
    seed: int = 0,
    deadline: float | None = None,
    parameters: Iterable[str] | None = None,
    states: Iterable[str] | None = None,
    fixed: Mapping[str, float] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    noise: Mapping[str, float] | None = None,
    previous: Estimate | None = None,
    initial: Mapping[str, float] | None = None,
    fitness: Fitness = 'least_squares',
    search_options: Mapping[str, Any] | None = None,
    backend: Backend | None = None,
) -> Estimate:
    """Estimate initial states and parameters of a plant from one record.

    Parameters
    ----------
    model : a Model, a built-in model's name, or `module:ATTRIBUTE`.
    record : times (K,), inputs (K, m) and outputs (K, r); NaN = not measured.
    search : `memetic` (default), `chaotic_de`, or a Method of your own; `search_options` replaces
        some of its settings.
    seed : of everything random; without a deadline, the same seed gives the same bits.
    deadline : s until the best so far is returned, from when the model is compiled; None takes
        the time it needs.
    parameters, states : names to estimate; default all parameters and all initial states.
    fixed : values of names that are not estimated; their default is the nominal value.
    bounds : (lower, upper) by name, instead of the model's.
    noise : standard deviation by output, in its unit; those not given come from the residual.
    previous : the estimate of an earlier window, raced against fresh candidates.
    initial : values by name of a start to race instead, where there is no previous estimate; what
        is not given starts in the middle of its box.
    fitness : `least_squares`, `euclidean` or `correlation`; the last two only for `chaotic_de`.
    backend : `numba` or `numpy`; None takes Numba where it is installed.

    Raises ValueError for anything wrong with these, with the name and the value.
    """
    solver = Solver.of(
        load_model(model),
        search=search,
        search_options=search_options,
        parameters=parameters,
        states=states,
        fixed=fixed,
        bounds=bounds,
        noise=noise,
        initial=initial,
        fitness=fitness,
        backend=backend,
    )
    rng = random_generator(seed)
    solver.prepare()  # before the clock starts
    return solver.solve(record, rng, Deadline(deadline), previous)


@dataclass(frozen=True)
class Solver:
    """Everything about `solve_window` that stays the same from window to window, checked."""

    unknowns: Unknowns
    method: Method
    settings: Any  # of the method's own type
    noise: Mapping[str, float]
    fitness: Fitness
    backend: Backend | None
    initial: Mapping[str, float] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        model: Model,
        *,
        search: str | Method = 'memetic',
        search_options: Mapping[str, Any] | None = None,
        parameters: Iterable[str] | None = None,
        states: Iterable[str] | None = None,
        fixed: Mapping[str, float] | None = None,
        bounds: Mapping[str, tuple[float, float]] | None = None,
        noise: Mapping[str, float] | None = None,
        initial: Mapping[str, float] | None = None,
        fitness: Fitness = 'least_squares',
        backend: Backend | None = None,
    ) -> 'Solver':
        """Check the settings; see `solve_window`."""
        unknowns = Unknowns.of(model, parameters, states, fixed, bounds)
        method, settings = method_for(search, search_options)
        if fitness not in FITNESSES:
            raise ValueError(f'unknown fitness {fitness!r}: {suggest(fitness, FITNESSES)}')
        if method.needs_squares and fitness != 'least_squares':
            raise ValueError(
                f'search {search!r} minimises least squares, not {fitness!r}: '
                "use search='chaotic_de' for that"
            )
        noise = checked_noise(model, noise)
        check_backend(backend)
        unknowns.check_initial(initial or {})
        return cls(unknowns, method, settings, noise, fitness, backend, dict(initial or {}))

    @property
    def model(self) -> Model:
        """The plant."""
        return self.unknowns.model

    @property
    def kernels(self) -> Kernels:
        """The model's rollouts; compiled at the first call, which may take some seconds."""
        return kernels_for(self.model, self.backend)

    def prepare(self) -> float:
        """Compile whatever is not compiled yet; return the seconds that it took."""
        begin = time.perf_counter()
        _ = self.kernels
        self.unknowns.prepare()
        lm_linalg.prepare()
        return time.perf_counter() - begin

    @np.errstate(all='ignore')  # data or model may overflow: what is not finite says so itself
    def solve(
        self,
        record: Record,
        rng: np.random.Generator,
        deadline: Deadline,
        previous: Estimate | None = None,
    ) -> Estimate:
        """Estimate one window; see `solve_window`."""
        record, absurd = without_absurd(record)
        estimate = self._solve(record, rng, deadline, previous)
        if not absurd:
            return estimate
        told = f'{absurd} values beyond any signal of this window count as not measured'
        return replace(estimate, message=f'{estimate.message}; {told}')

    def _solve(
        self,
        record: Record,
        rng: np.random.Generator,
        deadline: Deadline,
        previous: Estimate | None,
    ) -> Estimate:
        begin = time.perf_counter()
        known = self.method.needs_squares and len(self.noise) == len(self.model.outputs)
        objective = self.pose(record, None, noise_known=known)
        if isinstance(objective, Estimate):
            return objective
        warm = self.warm_start(record, previous)
        found = self.search(objective, rng, deadline, warm, noise_known=known)
        if not np.isfinite(found.cost):
            return self.diverged(record, objective)
        uncertainty = None
        if self.method.needs_squares:
            if not known:
                found = rescaled_to_residuals(objective, found)
            prior = Prior.box(self.unknowns)
            problem = PiecewiseProblem(objective, prior, Layout(objective.dimension))
            best = hypothesis_at(problem, found.z)
            n = self.unknowns.n_states
            uncertainty = Uncertainty(best, best.covariance, marginal_information(best, n))
        return report(
            record,
            objective,
            found,
            uncertainty,
            noise_known=known,
            in_time=not deadline.passed,
            solve_time=time.perf_counter() - begin,
        )

    def pose(
        self, record: Record, scale: Array | None, *, noise_known: bool
    ) -> Objective | Estimate:
        """Return a window's objective, outputs in units of `scale` (r,), or why there is none.

        `scale` None means the noise, given or guessed; 1 for fitnesses other than squares.
        """
        grid = Grid.of(self.model, record, self._scale(record) if scale is None else scale)
        objective = Objective(self.kernels, grid, self.unknowns, self.fitness)
        values, dimension = objective.count(objective.nodes), objective.dimension
        # A residual of so few values could not tell noise from a wrong fit.
        needed = dimension if noise_known else FEWEST * dimension
        if values >= needed:
            return objective
        return empty(
            self.model,
            record,
            Outcome.TOO_FEW_SAMPLES,
            'take a longer window, estimate less, or give the noise: '
            f'{values} measured values for {dimension} unknowns, at least {needed} are needed',
        )

    def warm_start(self, record: Record, previous: Estimate | None) -> Array | None:
        """Return the point (d,) that the previous estimate expects, or else the initial values.

        None where there is neither.
        """
        if previous is None or not previous.usable:
            given = dict.fromkeys(self.unknowns.names, np.nan) | dict(self.initial)
            return self.unknowns.point(given) if self.initial else None
        if tuple(previous.state) != names(self.model.states):
            raise ValueError(
                f'the previous estimate is not of model {self.model.name!r}: '
                f'its states are {", ".join(previous.state)}'
            )
        start = propagated(self.kernels, previous, record)
        return self.unknowns.point({**previous.parameters, **start})

    def search(
        self,
        objective: Objective,
        rng: np.random.Generator,
        deadline: Deadline,
        warm: Array | None,
        *,
        noise_known: bool,
        prior: Prior | None = None,
    ) -> Found:
        """Search the optimum of a window, with a prior's squares added if there is one."""
        method, problem = self.method, objective if prior is None else Posterior(objective, prior)
        found = method.search(problem, rng, deadline, self.settings, warm, noise_known)
        if method.needs_squares and not noise_known and np.isfinite(found.cost):
            found = self._reweighted(objective, found, deadline)
        return found

    def diverged(self, record: Record, objective: Objective) -> Estimate:
        """Return the estimate of a window in which every candidate diverged."""
        return empty(
            self.model,
            record,
            Outcome.DIVERGED,
            "narrow the bounds, or shorten the model's max_step: "
            f'all {objective.evaluations} candidates diverged',
        )

    def _scale(self, record: Record) -> Array:
        """Return scales (r,) of the outputs: noise, given or guessed; 1 for other fitnesses."""
        if self.fitness != 'least_squares':
            return np.ones(len(self.model.outputs))
        outputs = zip(names(self.model.outputs), record.y.T, strict=False)
        return np.array([self.noise.get(name) or noise_guess(y) for name, y in outputs])

    def _reweighted(self, objective: Objective, found: Found, deadline: Deadline) -> Found:
        """Weight the outputs by their own residuals where the guess of their noise was off."""
        guessed = np.array([name not in self.noise for name in names(self.model.outputs)])
        values = objective.count(objective.nodes)
        for _ in range(REWEIGHTINGS if guessed.any() and guessed.size > 1 else 0):
            if deadline.passed:
                break
            rms = output_rms(objective.residuals(found.z))
            off = np.where(guessed & (rms > 0.0), rms, 1.0)
            if off.max() < UNEQUAL * off.min():
                break
            objective.grid = objective.grid.rescaled(off)
            share = LMSettings.same_optimum * objective.dimension / values
            polished = levenberg_marquardt(
                objective,
                found.z[None],
                objective.nodes,
                MemeticSettings.full_iterations,
                deadline,
                hopeless=partial(_hardly_fall, Trail(MemeticSettings.patience), share),
            )
            found = replace(found, z=polished.z[0], cost=float(polished.squares[0]))
        return found


def _hardly_fall(trail: Trail, share: float, squares: float) -> bool:
    """Whether squares have fallen by less than this share of them in the latest rollouts."""
    return trail.gain(squares) < share * squares


def rescaled_to_residuals(objective: Objective, found: Found) -> Found:
    """Scale the outputs by what the fit leaves of them; return the fit with its cost in that."""
    left = variances_left(objective.residuals(found.z), objective.grid, objective.dimension)
    objective.grid = objective.grid.rescaled(np.sqrt(left) / objective.grid.scale)
    return replace(found, cost=float(objective.costs(found.z[None])[0]))


def random_generator(*seeds: int) -> np.random.Generator:
    """Return the generator of these seeds; raises ValueError for a negative one."""
    for seed in seeds:
        if not isinstance(seed, int) or seed < 0:
            raise ValueError(f'seed must be an integer >= 0, not {seed!r}')
    return np.random.default_rng(seeds)


def noise_guess(y: Array) -> float:
    """Guess the noise of one output (K,) from its second differences, which a slow signal lacks."""
    y = y[np.isfinite(y)]
    if y.size < 3:
        return 1.0
    bends = np.sort(np.abs(np.diff(y, 2)))
    for guess in (bends[bends.size // 2], np.std(y)):
        if guess > ROUNDING * np.abs(y).max():
            return float(guess) / MEDIAN_BEND
    return 1.0
