"""A window's best explanation: by the model alone, by jumps, or by process noise.

The model alone is fitted first, and jumps are sought. Where that leaves more than noise, walks of
the states are found, and jumps sought beside them. A window that follows one with process noise
begins with that noise, and is searched only if it does not explain this one.
"""

from dataclasses import dataclass, replace

import numpy as np

from obs_ros.core.deadline import Deadline
from obs_ros.core.typing import Array
from obs_ros.horizon.arrival_cost import contradicts_prior
from obs_ros.horizon.disturbance import (
    DisturbedWindow,
    continue_process_noise,
    criterion_at,
    explain_by_process_noise,
    fit_of,
    untried,
    with_noise_of_others,
)
from obs_ros.horizon.solver import Solver, rescaled_to_residuals
from obs_ros.horizon.stages import Explanation, continued_jumps, explain, fit
from obs_ros.inference.jumps.hypothesis import Hypothesis, hypothesis_at
from obs_ros.inference.jumps.mixture import Mixture
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.prior import Prior
from obs_ros.inference.process_noise import ProcessNoise
from obs_ros.inference.window_state import WindowState
from obs_ros.optimization.acceptance import Acceptance
from obs_ros.optimization.levenberg_marquardt import levenberg_marquardt
from obs_ros.optimization.memetic import MemeticSettings
from obs_ros.optimization.result import Effort, Found


@dataclass(frozen=True)
class SolutionSettings:
    """Limits in explaining a window.

    - `vain`: share of the residual, in units of the noise, that jumps must not leave where it is
      more than noise;
    - `unsearched`: windows in a row that may go without a search although process noise explains
      them but roughly, as long as -2 log likelihood per value is above that of the window searched
      last by `worse` at most.
    """

    vain: float = 0.7
    unsearched: int = 4
    worse: float = 0.2


SOLUTION = SolutionSettings()


@dataclass(frozen=True)
class Earlier:
    """Knowledge of earlier windows: a start (d,), the jumps, the process noise; None where none.

    `settled`: enough windows tell the process noise to set a jump apart from it; `level` is the
    criterion per value of the window searched last, None if that is too long ago; `known` is what
    is known without any window, None: the boxes; `plain` (d,) is the last optimum without process
    noise.
    """

    warm: Array | None
    explained: Hypothesis | None
    noise: ProcessNoise | None
    settled: bool = False
    level: float | None = None
    known: Prior | None = None
    plain: Array | None = None

    def starts_without(self, z: Array, n: int) -> Array:
        """Return starts (P, d) of a fit without process noise: that with it, z (d,), and the last.

        Of the last one only the parameters, from place n on, are those of this window.
        """
        if self.plain is None or self.warm is None:
            return z[None]
        return np.array([z, np.concatenate([self.warm[:n], self.plain[n:]])])

    @property
    def alone(self) -> 'Earlier':
        """Return this without jumps found beside process noise, which alone mean nothing."""
        explained = self.explained
        if explained is None or explained.problem.objective.grid.injection is None:
            return self
        return replace(self, explained=None)


@dataclass(frozen=True)
class Solution:
    """The hypotheses on a window with their probabilities; whether there was time to look.

    `plain` is the best one without process noise, `disturbed` that with it, if it is published;
    `said` tells in words what else was decided, `learned` is the process noise first found.
    """

    window: WindowState
    found: Found
    mixture: Mixture
    finished: bool
    plain: Hypothesis
    disturbed: DisturbedWindow | None = None
    said: str = ''
    searched: bool = True
    learned: ProcessNoise | None = None

    @property
    def hypothesis(self) -> Hypothesis:
        """The best one."""
        return self.mixture.best

    def by(self, disturbed: DisturbedWindow) -> 'Solution':
        """Return the solution with process noise."""
        best = disturbed.hypothesis
        return replace(
            self,
            window=disturbed.window,
            found=disturbed.found,
            mixture=self.mixture if best is self.hypothesis else Mixture.only(best),
            disturbed=disturbed,
            learned=self.learned or disturbed.noise,
        )


def solved(
    window: WindowState,
    solver: Solver,
    earlier: Earlier,
    given: Array,
    rng: np.random.Generator,
    deadline: Deadline,
) -> Solution | None:
    """Return the best explanation of a window; None if every candidate diverged.

    `given` (r,) are the outputs' known deviations, NaN where they are not.
    """
    solution = _continued(window, solver, earlier, given, deadline) or _searched(
        window, solver, earlier, given, rng, deadline
    )
    return solution and _jumps_beside(window, solution, earlier, deadline)


def _searched(
    window: WindowState,
    solver: Solver,
    earlier: Earlier,
    given: Array,
    rng: np.random.Generator,
    deadline: Deadline,
) -> Solution | None:
    """Search the window, and explain by jumps or process noise what the model alone does not."""
    known = window.noise_known
    alone = earlier.alone
    continued = _earlier_jumps(window, alone, deadline) if known else None
    window, found = fit(window, solver, earlier.warm, continued, rng, deadline)
    if not np.isfinite(found.cost):
        return None
    if not known:  # only now the squares are in units of the noise
        continued = _earlier_jumps(window, alone, deadline)
    window, explanation = explain(window, found, continued, deadline)
    mode, best = solver.settings.process_noise, explanation.hypothesis
    if mode == 'auto' and _in_vain(window, found, best):
        best = hypothesis_at(PiecewiseProblem(window.objective, window.prior), found.z)
        explanation = Explanation(Mixture.only(best), explanation.finished)
    solution = Solution(window, found, explanation.mixture, explanation.finished, plain=best)
    for _ in range(2):
        other = explain_by_process_noise(
            window, found, best, given, deadline, mode=mode, previous=earlier.noise
        )
        if other is None:
            tried = solution.disturbed is not None or not found.accepted
            late = not tried and untried(window, best, mode, deadline)
            return replace(solution, finished=solution.finished and not late)
        solution = solution.by(other)
        if not contradicts_prior(other.hypothesis, earlier.known):
            return solution
        window = replace(window, prior=earlier.known or Prior.box(solver.unknowns))
        solution = replace(solution, said=DROPPED)
    return solution


def _continued(
    window: WindowState, solver: Solver, earlier: Earlier, given: Array, deadline: Deadline
) -> Solution | None:
    """Return the window explained by process noise as earlier ones were, without a search.

    None where its innovations are no noise, or the model alone does as well.
    """
    if earlier.noise is None or earlier.warm is None:
        return None
    mode = solver.settings.process_noise
    start = Found(
        z=earlier.warm, cost=np.inf, converged=True, accepted=None, effort=Effort(1, 'round')
    )
    said = ''
    other = continue_process_noise(
        window, start, given, deadline, mode=mode, previous=earlier.noise
    )
    if other is not None and contradicts_prior(other.hypothesis, earlier.known):
        window = replace(window, prior=earlier.known or Prior.box(solver.unknowns))
        said = DROPPED
        other = continue_process_noise(
            window, other.found, given, deadline, mode=mode, previous=earlier.noise
        )
    if other is None or not (other.is_noise or _as_before(window, other, earlier)):
        return None
    starts = earlier.starts_without(other.found.z, solver.unknowns.n_states)
    plain_window, plain = _plain(window, other.found, starts, deadline)
    if plain is None:
        return None
    if mode == 'auto' and not other.criterion < criterion_at(plain_window, plain):
        return None
    if not other.is_noise:
        found = replace(other.found, accepted=Acceptance.AS_BEFORE)
        other = replace(other, found=found)
    mixture, finished = Mixture.only(plain), not deadline.passed
    return Solution(
        plain_window, other.found, mixture, finished, plain=plain, said=said, searched=False
    ).by(other)


def _as_before(window: WindowState, other: DisturbedWindow, earlier: Earlier) -> bool:
    """Whether process noise explains a window as well as one that was searched."""
    if earlier.level is None:
        return False
    return level_of(window, other) <= earlier.level + SOLUTION.worse


def level_of(window: WindowState, other: DisturbedWindow) -> float:
    """Return the criterion of a window with process noise, per measured value."""
    return other.criterion / window.objective.count(window.objective.nodes)


def _plain(
    window: WindowState, found: Found, starts: Array, deadline: Deadline
) -> tuple[WindowState, Hypothesis | None]:
    """Return the best optimum without process noise near some starts (P, d), in its own scales."""
    posterior = window.posterior
    solved = levenberg_marquardt(
        posterior, starts, posterior.nodes, MemeticSettings.full_iterations, deadline
    )
    if deadline.passed or not np.isfinite(solved.squares[0]):
        return window, None
    found = replace(found, z=solved.z[0], cost=float(solved.squares[0]))
    if not window.noise_known:
        window, found = rescaled_to_residuals(window, found)
    return window, hypothesis_at(PiecewiseProblem(window.objective, window.prior), found.z)


def _jumps_beside(
    window: WindowState, solution: Solution, earlier: Earlier, deadline: Deadline
) -> Solution:
    """Return the solution with jumps beside process noise, where these explain the window better.

    Earlier windows say how much the states walk: this one's own walks would stand for the jump.
    """
    own = solution.disturbed
    if own is None or earlier.noise is None or not earlier.settled:
        return solution
    window = replace(window, prior=own.hypothesis.problem.prior)
    frozen = with_noise_of_others(window, own, earlier.noise, deadline) or own
    known = _earlier_jumps(frozen.window, earlier, deadline)
    found = replace(frozen.found, accepted=Acceptance.PROCESS_NOISE)
    _, explanation = explain(frozen.window, found, known, deadline)
    best = explanation.hypothesis
    solution = replace(solution, finished=solution.finished and explanation.finished)
    if not best.jumps or len(best.problem.events) > 1:
        return solution
    if not criterion_at(frozen.window, best) < own.criterion:
        return solution
    jumped = frozen.jumped(best)
    return replace(solution.by(jumped), mixture=explanation.mixture.about(jumped.hypothesis))


def _in_vain(window: WindowState, found: Found, best: Hypothesis) -> bool:
    """Whether jumps leave a residual nearly as far above the noise as there is without them.

    Then the noise was given too small, or the model is wrong: jumps stand for neither.
    """
    fit = fit_of(window, best)
    if not best.jumps or not fit.too_large:
        return False
    before = np.sqrt(found.cost / fit.freedom)
    return bool(fit.ratio > SOLUTION.vain * before)


def _earlier_jumps(window: WindowState, earlier: Earlier, deadline: Deadline) -> Hypothesis | None:
    """Return the hypothesis that the previous window's jumps are as it explained them."""
    if earlier.explained is None or earlier.warm is None:
        return None
    return continued_jumps(window, earlier.explained, earlier.warm, deadline)


DROPPED = 'earlier windows contradict this one, which is explained without them'


def plain_fits(solution: Solution) -> bool:
    """Whether noise alone explains what the model leaves."""
    return solution.disturbed is None and fit_of(solution.window, solution.hypothesis).is_noise
