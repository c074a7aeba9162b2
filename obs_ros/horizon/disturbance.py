"""The stage that explains a window by process noise, where the model alone does not."""

from dataclasses import dataclass

import numpy as np

from obs_ros.core.changes import replace
from obs_ros.core.deadline import Deadline
from obs_ros.core.residual_tests import changes_slowly
from obs_ros.core.typing import Array
from obs_ros.inference.assessment.contradiction import contradictions
from obs_ros.inference.assessment.fit import Fit, fit_at
from obs_ros.inference.assessment.skill import forecast_skill
from obs_ros.inference.assessment.structure import structure_of
from obs_ros.inference.assessment.uncertainty import AtEnd, Uncertainty
from obs_ros.inference.coloured_noise import likeliest_noise
from obs_ros.inference.disturbed import (
    Disturbed,
    disturbed,
    with_given_walks,
    with_known_noise,
)
from obs_ros.inference.jumps.hypothesis import Hypothesis, hypothesis_at
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.outliers import first_far, left_out, outliers_in
from obs_ros.inference.process_noise import ProcessNoise, ProcessNoiseMode
from obs_ros.inference.window_state import WindowState, criterion_of
from obs_ros.integration.smoother import smoothed
from obs_ros.optimization.acceptance import Acceptance
from obs_ros.optimization.result import Found


@dataclass(frozen=True)
class DisturbanceSettings:
    """Limits in explaining a window by process noise.

    - `realised`: share of the squares of innovations far out that the window's -2 log likelihood
      must fall by without them: by all for outliers, by half for pushes of a state that the outputs
      show at once;
    - `rounds`: in which outliers are sought; in each, those of the one before are left out.
    """

    realised: float = 0.8
    rounds: int = 3


DISTURBANCE = DisturbanceSettings()


@dataclass(frozen=True)
class DisturbedWindow:
    """A window explained by process noise, its hypothesis, and the noise.

    `end` is what process noise makes of the end; `covariance` (d, d) is that of an output-error
    estimate, where one is published.
    """

    window: WindowState
    found: Found
    hypothesis: Hypothesis
    noise: ProcessNoise
    end: AtEnd
    criterion: float
    covariance: Array | None = None

    @classmethod
    def of(cls, window: WindowState, found: Found, other: Disturbed) -> 'DisturbedWindow':
        """Return the window of a fit with the process noise that explains it, without jumps."""
        hypothesis = hypothesis_at(PiecewiseProblem(other.window.objective, window.prior), other.z)
        accepted = found.accepted
        if fit_of(other.window, hypothesis).is_noise:
            accepted = Acceptance.PROCESS_NOISE
        fitted = replace(found, z=other.z, cost=hypothesis.squares, accepted=accepted)
        end = AtEnd(other.covariance, path=smoothed(other.along).states)
        if other.parameters is not None:
            jacobian = other.parameter_jacobian()
            end = replace(end, parameters=other.parameters, jacobian=jacobian)
        return cls(other.window, fitted, hypothesis, other.noise, end, other.criterion)

    def jumped(self, best: Hypothesis) -> 'DisturbedWindow':
        """Return the window with jumps, all noise as large as the innovations then say."""
        count = best.problem.objective.count(best.problem.objective.nodes)
        ratio = np.sqrt(best.squares / max(1, count - best.point.size))
        window = self.window.rescaled(np.full(self.noise.noise.size, ratio))
        problem = replace(best.problem, objective=window.objective)
        hypothesis = hypothesis_at(problem, best.point, best.earlier)
        noise = self.noise.scaled(ratio)
        found = replace(self.found, cost=hypothesis.squares, accepted=Acceptance.PROCESS_NOISE)
        return replace(
            self, window=window, found=found, hypothesis=hypothesis, noise=noise,
            end=AtEnd(ratio**2 * self.end.covariance),
        )  # fmt: skip

    @property
    def price(self) -> float:
        """Of its walks, log N for each (BIC); states of one unit share one."""
        objective = self.window.objective
        walks = np.unique(self.noise.walks[self.noise.walks > 0.0]).size
        return float(walks * np.log(objective.count(objective.nodes)))

    @property
    def is_noise(self) -> bool:
        """Whether the innovations are those of the noise, in size and colour."""
        return fit_of(self.window, self.hypothesis).is_noise

    def added_to(self, uncertainty: Uncertainty) -> Uncertainty:
        """Return the uncertainty with what process noise adds to it."""
        covariance = uncertainty.covariance if self.covariance is None else self.covariance
        return replace(uncertainty, covariance=covariance, end=self.end, process_noise=self.noise)


def explain_by_process_noise(
    window: WindowState,
    found: Found,
    best: Hypothesis,
    given: Array,
    deadline: Deadline,
    *,
    mode: ProcessNoiseMode,
    previous: ProcessNoise | None = None,
) -> DisturbedWindow | None:
    """Return the window explained by process noise if that is more likely than `best`, else None.

    `given` (r,) are the outputs' known deviations, NaN where they are not. With mode `auto` it is
    tried only where `best` leaves a residual that is no noise, or one that changes slowly.
    """
    if mode == 'off' or deadline.passed or (mode == 'auto' and is_exact(window, best)):
        return None
    other = _disturbed(window, found.z, given, deadline, mode, previous, afresh=True)
    if other is None or (mode == 'auto' and other.criterion >= criterion_at(window, best)):
        return None
    return DisturbedWindow.of(window, found, other)


def untried(
    window: WindowState, best: Hypothesis, mode: ProcessNoiseMode, deadline: Deadline
) -> bool:
    """Whether process noise would have been tried, had there been time."""
    return mode != 'off' and deadline.passed and not is_exact(window, best)


def is_exact(window: WindowState, best: Hypothesis) -> bool:
    """Whether a hypothesis leaves nothing to be explained by process noise."""
    fit = fit_of(window, best)
    if len(best.problem.events) > 1 or not fit.is_noise:
        return False
    # Slow changes may be those of a given prior that is wrong: no walk must stand for it.
    slow = not fit.negligible and changes_slowly(best.trajectory[1])
    return not slow or bool(contradictions(best))


def continue_process_noise(
    window: WindowState,
    found: Found,
    given: Array,
    deadline: Deadline,
    *,
    mode: ProcessNoiseMode,
    previous: ProcessNoise,
) -> DisturbedWindow | None:
    """Return the window explained by process noise like that of earlier windows.

    `found` is a warm start.
    """
    other = _disturbed(window, found.z, given, deadline, mode, previous, afresh=False)
    return None if other is None else DisturbedWindow.of(window, found, other)


def steadied(
    window: WindowState,
    other: DisturbedWindow,
    given: Array,
    deadline: Deadline,
    *,
    mode: ProcessNoiseMode,
) -> tuple[WindowState, DisturbedWindow]:
    """Return a window, and it explained by process noise, without outliers among innovations.

    A push that the states had is none: the innovations that follow would be as far out.
    """
    for _ in range(DISTURBANCE.rounds):
        again = _without_far(window, other, given, deadline, mode)
        if again is None:
            break
        window, other = again
    return window, other


def _without_far(
    window: WindowState,
    other: DisturbedWindow,
    given: Array,
    deadline: Deadline,
    mode: ProcessNoiseMode,
) -> tuple[WindowState, DisturbedWindow] | None:
    """Return a window, and it explained, without the innovations far out; None if these are sound.

    Where none of them comes and goes at once, the filter may have answered the first of a run.
    """
    innovations, known = other.hypothesis.residuals, bool(np.isfinite(given).all())
    far = outliers_in(window, innovations, noise_known=known)  # else they enlarge it themselves
    if not far.any():
        far = first_far(window, innovations, noise_known=known)
    if not far.any():
        return None
    clean = left_out(window, far, innovations)
    again = continue_process_noise(
        clean, other.found, given, deadline, mode=mode, previous=other.noise
    )
    if again is None:
        return None
    size = -2.0 * float(np.log(other.window.objective.grid.weight[far]).sum())
    gained = other.criterion - size - again.criterion
    if gained < DISTURBANCE.realised * float(np.sum(innovations[far] ** 2)):
        return None
    return clean, again


def _disturbed(
    window: WindowState,
    z: Array,
    given: Array,
    deadline: Deadline,
    mode: ProcessNoiseMode,
    previous: ProcessNoise | None,
    *,
    afresh: bool,
) -> Disturbed | None:
    """Return the window near z (d,) with the model's walks or, with mode `auto`, its own."""
    if mode == 'given':
        return with_given_walks(window, z, given, deadline)
    return disturbed(window, z, given, previous, deadline, afresh=afresh)


def with_noise_of_others(
    window: WindowState, other: DisturbedWindow, noise: ProcessNoise, deadline: Deadline
) -> DisturbedWindow | None:
    """Return the window with the process noise of other windows instead of its own."""
    found = with_known_noise(window, other.found.z, noise, deadline)
    return None if found is None else DisturbedWindow.of(window, other.found, found)


def assessed(uncertainty: Uncertainty, mode: ProcessNoiseMode) -> Uncertainty:
    """Return the uncertainty with the skill of its forecasts, where noise alone is no explanation.

    Nothing is assessed with process noise switched off.
    """
    if mode == 'off':
        return uncertainty
    if uncertainty.process_noise is None and uncertainty.fit.is_noise:
        return uncertainty
    best = uncertainty.hypothesis
    tested = uncertainty.process_noise is not None and not best.problem.events
    return replace(
        uncertainty,
        skill=forecast_skill(best),
        structure=structure_of(best) if tested and uncertainty.fit.is_noise else None,
    )


def criterion_at(window: WindowState, best: Hypothesis) -> float:
    """Return -2 log p(y, z) of a hypothesis but for a constant, with its penalties.

    Without process noise, noise may also be as large as the residual, or correlated from sample to
    sample, at log N for each output and each of both: walks must stand neither for noise that was
    given too small nor for that of a sensor that filters.
    """
    objective = best.problem.objective
    if not np.isfinite(best.cost):
        return np.inf
    plain = criterion_of(replace(window, objective=objective), best.cost)
    if objective.grid.injection is not None:
        return plain
    return plain - best.squares + likeliest_noise(best.trajectory[1])


def fit_of(window: WindowState, best: Hypothesis) -> Fit:
    """Return the residual of a hypothesis beside the noise of its window."""
    return fit_at(
        best, noise_known=window.noise_known, correlation=window.correlation,
        noise_given=window.noise_given,
    )  # fmt: skip
