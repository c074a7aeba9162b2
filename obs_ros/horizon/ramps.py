"""Parameters that walk through a window, as hypotheses beside those that jumped in it.

A ramp is no row of jumps. Where jumps are found, each parameter that jumped is let walk instead,

    dp = walk dW,

inside the window, by a walk of maximum likelihood; see `inference/disturbed`. The least
-2 log evidence decides, that of the innovations in place of the residuals' and with the same prior
odds: a walk costs what a jump does, and log N of its values for its size (Schwarz 1978).
"""

from dataclasses import dataclass, replace

import numpy as np

from obs_ros.core.deadline import Deadline
from obs_ros.core.typing import Array, IntArray
from obs_ros.horizon.disturbance import DisturbedWindow
from obs_ros.inference.assessment.uncertainty import Uncertainty
from obs_ros.inference.disturbed import Disturbed, with_walk_of
from obs_ros.inference.jumps.hypothesis import Hypothesis, hypothesis_at
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.process_noise import ProcessNoise
from obs_ros.inference.window_state import WindowState, criterion_of
from obs_ros.optimization.result import Found


@dataclass(frozen=True)
class RampSettings:
    """Limits of the search for parameters that walked.

    - `most`: parameters that are tried, those that jumped farthest: each costs as much as one start
      of process noise;
    - `hopeless`: -2 log evidence more than that of the jumps, above which a walk is given up as
      soon as it is solved once: what is left to gain is below .2 in windows with a jump.
    """

    most: int = 2
    hopeless: float = 10.0


RAMPS = RampSettings()


def walked(
    window: WindowState,
    found: Found,
    best: Hypothesis,
    deadline: Deadline,
    other: DisturbedWindow | None = None,
) -> DisturbedWindow | None:
    """Return the window explained by one parameter that walked, of those that jumped in `best`.

    None if the jumps, or walks of the states as in the `other`, explain it better.
    """
    limit = _evidence(window, best)
    if other is not None:
        limit = min(limit, _evidence(window, other.hypothesis) + other.price)
    least: tuple[float, DisturbedWindow] | None = None
    penalty = best.problem.settings.jump_penalty

    def hopeless(along: Disturbed) -> bool:
        walking = hypothesis_at(PiecewiseProblem(along.window.objective, window.prior), along.z)
        return _evidence(window, walking) + penalty > limit + RAMPS.hopeless

    for place, size in _moved(best)[: RAMPS.most]:
        if deadline.passed:
            return None
        start = _start(window, best, place, size)
        along = with_walk_of(window, *start, deadline, hopeless)
        if along is None:
            continue
        ramp = DisturbedWindow.of(window, found, along)
        evidence = _evidence(window, ramp.hypothesis) + ramp.price
        evidence += penalty
        # A filter that diverged has no innovations.
        measured = window.objective.grid.weight > 0.0
        whole = bool((ramp.window.objective.grid.weight[measured] > 0.0).all())
        sound = whole and np.isfinite(evidence) and ramp.is_noise
        if sound and (least is None or evidence < least[0]):
            least = evidence, ramp
    if least is None or not least[0] < limit:  # a limit that is no number means no ramp
        return None
    return least[1]


def drift_ahead(uncertainty: Uncertainty) -> Array:
    """Return the variances (q, q), in boxes, of a window's length more of what walks in it."""
    best, noise = uncertainty.hypothesis, uncertainty.process_noise
    unknowns, t = best.problem.objective.unknowns, best.problem.objective.grid.t
    variances = np.zeros(unknowns.dimension - unknowns.n_states)
    if noise is not None and uncertainty.walking:
        slopes = unknowns.scale.slopes(best.point[best.final])
        walks = noise.walks[unknowns.index] / slopes
        variances = walks[unknowns.n_states :] ** 2 * (t[-1] - t[0])
    return np.diag(variances)


def _evidence(window: WindowState, best: Hypothesis) -> float:
    """Return -2 log evidence of a hypothesis, whatever the scales of its residuals."""
    return criterion_of(replace(window, objective=best.problem.objective), best.neg2_log_evidence)


def _moved(best: Hypothesis) -> list[tuple[int, float]]:
    """Return the places of parameters that jumped, and how far (boxes), the farthest first."""
    far: dict[int, float] = {}
    for jump in best.layout.jumped(best.point):
        size = abs(float(best.point[jump.after] - best.point[jump.before]))
        far[jump.parameter] = max(far.get(jump.parameter, 0.0), size)
    for place in best.earlier:
        far.setdefault(place, abs(float(best.point[place] - best.problem.prior.mean[place])))
    return sorted(far.items(), key=lambda item: -item[1])


def _start(
    window: WindowState, best: Hypothesis, place: int, size: float
) -> tuple[Array, ProcessNoise, IntArray]:
    """Return the values (d,) before the jumps, and a walk as far as one went, of which variable."""
    unknowns = window.objective.unknowns
    z = best.point[: best.layout.dimension]
    index = unknowns.index[[place]]
    walks = np.zeros(len(unknowns.model.variables))
    walks[index] = size * unknowns.scale.slopes(z)[place] / np.sqrt(window.duration)
    return z, ProcessNoise(walks, window.objective.grid.scale), index
