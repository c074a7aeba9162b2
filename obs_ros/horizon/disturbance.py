"""The stage that explains a window by process noise, where the model alone does not."""

from dataclasses import dataclass, replace

import numpy as np

from obs_ros.core.deadline import Deadline
from obs_ros.core.typing import Array
from obs_ros.inference.assessment.fit import Fit
from obs_ros.inference.assessment.uncertainty import Uncertainty
from obs_ros.inference.disturbed import disturbed, plain_criterion, with_given_walks
from obs_ros.inference.jumps.hypothesis import Hypothesis, hypothesis_at
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.process_noise import ProcessNoise, ProcessNoiseMode
from obs_ros.inference.window_state import WindowState
from obs_ros.optimization.acceptance import Acceptance
from obs_ros.optimization.result import Found


@dataclass(frozen=True)
class DisturbedWindow:
    """A window explained by process noise, its hypothesis without jumps, and the noise."""

    window: WindowState
    found: Found
    hypothesis: Hypothesis
    noise: ProcessNoise
    end: Array  # (n, n) covariance of the state at the end, the unknowns given

    def added_to(self, uncertainty: Uncertainty) -> Uncertainty:
        """Return the uncertainty with what process noise adds to it."""
        return replace(uncertainty, end=self.end, process_noise=self.noise)


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
    tried only where `best` leaves a residual that is no noise.
    """
    drifting = len(best.problem.events) > 1
    if mode == 'off' or deadline.passed:
        return None
    if mode == 'auto' and not drifting and _fit(window, best).is_noise:
        return None
    if mode == 'given':
        other = with_given_walks(window, found.z, given, deadline)
    else:
        other = disturbed(window, found.z, given, previous, deadline)
    if other is None or (mode == 'auto' and other.criterion >= _criterion(window, best)):
        return None
    hypothesis = hypothesis_at(PiecewiseProblem(other.window.objective, window.prior), other.z)
    explained = _fit(other.window, hypothesis).is_noise
    return DisturbedWindow(
        other.window,
        replace(
            found,
            z=other.z,
            cost=hypothesis.squares,
            accepted=Acceptance.PROCESS_NOISE if explained else found.accepted,
        ),
        hypothesis,
        other.noise,
        other.covariance,
    )


def _criterion(window: WindowState, best: Hypothesis) -> float:
    if not np.isfinite(best.cost):
        return np.inf
    return plain_criterion(replace(window, objective=best.problem.objective), best.cost)


def _fit(window: WindowState, best: Hypothesis) -> Fit:
    return Fit.of(
        best.problem.objective,
        best.squares,
        best.trajectory[1],
        noise_known=window.noise_known,
        correlation=window.correlation,
    )
