"""A window's best explanation: by the model alone, by jumps, or by process noise.

The model alone is fitted first, and jumps are sought. Where that leaves more than noise, walks of
the states are found, and jumps sought beside them. A window that follows one with process noise
begins with that noise, and is searched only if it does not explain this one.
"""

from dataclasses import dataclass

import numpy as np

from obs_ros.core.changes import replace
from obs_ros.core.deadline import Deadline
from obs_ros.core.typing import Array
from obs_ros.horizon.cleaning import cleaned, plain_fit, without_the_same
from obs_ros.horizon.disturbance import (
    DisturbedWindow,
    continue_process_noise,
    criterion_at,
    explain_by_process_noise,
    fit_of,
    is_exact,
    steadied,
    untried,
    with_noise_of_others,
)
from obs_ros.horizon.earlier import (
    Earlier,
    beside_known_jumps,
    contradicts_prior,
    earlier_jumps,
    explained,
)
from obs_ros.horizon.ramps import walked
from obs_ros.horizon.solver import Solver
from obs_ros.horizon.stages import Explanation, explain, fit, still_at
from obs_ros.inference.jumps.hypothesis import Hypothesis, hypothesis_at
from obs_ros.inference.jumps.mixture import Mixture
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.prior import Prior
from obs_ros.inference.process_noise import ProcessNoise
from obs_ros.inference.window_state import WindowState
from obs_ros.optimization.acceptance import Acceptance
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
class Solution:
    """The hypotheses on a window with their probabilities; whether there was time to look.

    `posed` is the window as it was posed, without outliers. `plain` is the best hypothesis without
    process noise; `still`, where process noise is more likely than its jumps, the one without
    either: they are no reason then to doubt the optimum of output error. `disturbed` is the
    hypothesis with process noise, if it is published; `said` tells in words what else was decided,
    `learned` is the process noise first found.
    """

    posed: WindowState
    window: WindowState
    found: Found
    mixture: Mixture
    finished: bool
    plain: Hypothesis
    still: Hypothesis | None = None
    disturbed: DisturbedWindow | None = None
    said: str = ''
    searched: bool = True
    learned: ProcessNoise | None = None

    @property
    def hypothesis(self) -> Hypothesis:
        """The best one."""
        return self.mixture.best

    @property
    def dropped(self) -> bool:
        """Whether the window was explained without earlier ones, which contradict it."""
        return self.said == DROPPED

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
    if solution is None:
        return None
    solution = _jumps_beside(solution.posed, solution, earlier, deadline)
    auto = solver.settings.process_noise == 'auto'
    return _ramps_beside(solution, deadline) if auto else solution


def _ramps_beside(solution: Solution, deadline: Deadline) -> Solution:
    """Return the solution with a parameter that walks, where that is better than its jumps.

    Where the states walk instead, it must be better than that too.
    """
    own, window = solution.disturbed, solution.window
    if own is not None:
        if own.hypothesis.jumps or not (solution.searched and solution.posed.noise_known):
            return solution
        window = solution.posed
    if not solution.plain.jumps:
        return solution
    ramp = walked(window, solution.found, solution.plain, deadline, own)
    return solution if ramp is None else replace(solution, still=None).by(ramp)


def _searched(
    window: WindowState,
    solver: Solver,
    earlier: Earlier,
    given: Array,
    rng: np.random.Generator,
    deadline: Deadline,
) -> Solution | None:
    """Search the window, and explain by jumps or process noise what the model alone does not."""
    posed = window
    alone, continued = earlier.alone, None
    if window.noise_known:
        window, continued = beside_known_jumps(window, alone, deadline)
    known = window.noise_known
    window, found, still = fit(
        window, solver, earlier.warm, continued, rng, deadline, alone=earlier.explained is not None
    )
    if not np.isfinite(found.cost):
        return None
    if not known or window.outliers:  # only now the squares are in units of the noise
        continued = earlier_jumps(window, alone, deadline)
    window, found, explanation = explained(window, found, continued, alone, deadline, still)
    mode, best = solver.settings.process_noise, explanation.hypothesis
    if mode == 'auto' and _in_vain(window, found, best):
        best = still_at(window, found)
        explanation = Explanation(Mixture.only(best), explanation.finished)
    posed = without_the_same(posed, window)
    mixture, finished = explanation.mixture, explanation.finished
    solution = Solution(posed, window, found, mixture, finished, plain=best)
    for _ in range(2):
        other = explain_by_process_noise(
            window, found, best, given, deadline, mode=mode, previous=earlier.noise
        )
        if other is None:
            tried = solution.disturbed is not None or not found.accepted
            late = not tried and untried(window, best, mode, deadline)
            return replace(solution, finished=solution.finished and not late)
        if best.problem.events and solution.still is None:
            solution = replace(solution, still=still_at(window, found))
        window, other = steadied(window, other, given, deadline, mode=mode)
        solution = replace(solution, posed=without_the_same(solution.posed, window)).by(other)
        if not contradicts_prior(other.hypothesis, earlier.known):
            return solution
        window = replace(window, prior=earlier.known or Prior.box(solver.unknowns))
        solution = replace(solution, said=DROPPED)
    return solution


def _continued(
    window: WindowState, solver: Solver, earlier: Earlier, given: Array, deadline: Deadline
) -> Solution | None:
    """Return the window explained by process noise as the one before was, without a search.

    None where its innovations are no noise, or the model alone does as well; and after a window
    without process noise: what moves the states anew may be a parameter that jumped.
    """
    if earlier.noise is None or earlier.warm is None or not earlier.pushed:
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
    if other is None:
        return None
    window, other = steadied(window, other, given, deadline, mode=mode)
    if not (other.is_noise or _as_before(window, other, earlier)):
        return None
    starts = earlier.starts_without(other.found.z, solver.unknowns.n_states)
    plain_window, plain = plain_fit(window, other.found, starts, deadline)
    if plain is None or (mode == 'auto' and _does_as_well(plain_window, plain, other, deadline)):
        return None
    if not other.is_noise:
        found = replace(other.found, accepted=Acceptance.AS_BEFORE)
        other = replace(other, found=found)
    only, finished = Mixture.only(plain), not deadline.passed
    solution = Solution(window, plain_window, other.found, only, finished, plain=plain, said=said)
    return replace(solution, searched=False).by(other)


def _does_as_well(
    window: WindowState, plain: Hypothesis, other: DisturbedWindow, deadline: Deadline
) -> bool:
    """Whether the model alone explains a window as well as process noise, or but for outliers.

    A burst of a sensor, too, may look like a push of a state and one back.
    """
    if not other.criterion < criterion_at(window, plain):
        return True
    found = replace(other.found, z=plain.point, cost=plain.squares)
    clean, found = cleaned(window, found, deadline)
    if len(clean.outliers) == len(window.outliers):
        return False
    return is_exact(clean, hypothesis_at(PiecewiseProblem(clean.objective, clean.prior), found.z))


def _as_before(window: WindowState, other: DisturbedWindow, earlier: Earlier) -> bool:
    """Whether process noise explains a window as well as one that was searched."""
    if earlier.level is None:
        return False
    return level_of(window, other) <= earlier.level + SOLUTION.worse


def level_of(window: WindowState, other: DisturbedWindow) -> float:
    """Return the criterion of a window with process noise, per measured value."""
    return other.criterion / window.objective.count(window.objective.nodes)


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
    known = earlier_jumps(frozen.window, earlier, deadline)
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


DROPPED = 'earlier windows contradict this one, which is explained without them'


def plain_fits(solution: Solution) -> bool:
    """Whether noise alone explains what the model leaves."""
    return solution.disturbed is None and fit_of(solution.window, solution.hypothesis).is_noise
