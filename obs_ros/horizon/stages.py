"""The stages between the prior of a window and its report: fit, jumps, uncertainty.

Each is a function of frozen data that returns new data; the deadline is all that they share.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from obs_ros.core.changes import replace
from obs_ros.core.deadline import Deadline
from obs_ros.core.linear_algebra import scaled_inverse
from obs_ros.core.residual_tests import independent_share, inflation
from obs_ros.core.typing import Array, BoolArray
from obs_ros.horizon.cleaning import cleaned, in_own_scale, polished
from obs_ros.horizon.found_jumps import Explained
from obs_ros.horizon.solver import Solver
from obs_ros.inference.assessment.contradiction import contradictions
from obs_ros.inference.assessment.identifiability import undetermined
from obs_ros.inference.assessment.informed_subspace import informed_information
from obs_ros.inference.assessment.interval import determined
from obs_ros.inference.assessment.uncertainty import Uncertainty
from obs_ros.inference.jumps.hypothesis import Hypothesis, hypothesis_at
from obs_ros.inference.jumps.jump_search import JumpSearch
from obs_ros.inference.jumps.mixture import Mixture
from obs_ros.inference.jumps.outlying import without_outliers
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.noise import variances_left
from obs_ros.inference.prior import Prior
from obs_ros.inference.window_state import WindowState
from obs_ros.optimization.acceptance import Acceptance
from obs_ros.optimization.levenberg_marquardt import levenberg_marquardt
from obs_ros.optimization.memetic import MemeticSettings
from obs_ros.optimization.refinement import refined
from obs_ros.optimization.result import Effort, Found


@dataclass(frozen=True)
class StageSettings:
    """Limits of the stages.

    - `excess`: standard deviations of the squares above which a warm start alone is not believed;
    - `price_of_recall`: squares that a fit may lose under the prior of another window; a larger
      loss shows that it is far from linear there;
    - `nothing_new`: share of its prior variance that every parameter keeps in an uninformative
      window.
    """

    excess: float = 5.0
    price_of_recall: float = 20.0
    nothing_new: float = 0.95


STAGES = StageSettings()


@dataclass(frozen=True)
class Explanation:
    """Hypotheses on a window with their probabilities, and whether there was time to look.

    `tried` are all that were solved, in the scales of the window that was explained.
    """

    mixture: Mixture
    finished: bool
    tried: Sequence[Hypothesis] = ()

    @property
    def hypothesis(self) -> Hypothesis:
        """The best one."""
        return self.mixture.best


class Fitted(NamedTuple):
    """A window without outliers, its optimum without jumps inside, and the hypothesis there.

    That is None where every candidate diverged.
    """

    window: WindowState
    found: Found
    still: Hypothesis | None


def fit(
    window: WindowState,
    solver: Solver,
    warm: Array | None,
    continued: Hypothesis | None,
    rng: np.random.Generator,
    deadline: Deadline,
    *,
    alone: bool = True,
) -> Fitted:
    """Return the optimum without jumps inside, and the window without outliers.

    Its scales are the noise afterwards. `warm` (d,) is a start, which may do `alone` unless it
    comes of a window that nothing explained; `continued` is the hypothesis that earlier jumps are
    as they were.
    """
    found = None
    if window.noise_known and warm is not None and alone:
        window, found = _from_warm(window, warm, continued, deadline)
    if found is None:
        window, found = solver.fit(window, window.posterior, rng, deadline, warm)
    if not np.isfinite(found.cost):
        return Fitted(window, found, None)
    if not window.noise_known:
        window, found = in_own_scale(window, found, deadline)
    found = refined(window.posterior, found, deadline)
    still = still_at(window, found)
    clean, other = cleaned(window, found, deadline, residuals=still.residuals)
    if clean is window:
        return Fitted(window, found, still)
    found = refined(clean.posterior, other, deadline)
    return Fitted(clean, found, still_at(clean, found))


def still_at(window: WindowState, found: Found) -> Hypothesis:
    """Return the hypothesis that nothing jumps, at the optimum found."""
    problem = PiecewiseProblem(window.objective, window.prior)
    return hypothesis_at(problem, found.z, curvature=found.curvature)


def explain(
    window: WindowState,
    found: Found,
    continued: Hypothesis | None,
    deadline: Deadline,
    still: Hypothesis | None = None,
) -> tuple[WindowState, Explanation]:
    """Return the hypothesis that explains the window: parameters that jumped, or none.

    `still` is the one without jumps, if it has been made. A given prior that is contradicted counts
    for nothing in the search: no jump right after the start must stand for it.
    """
    still = still or still_at(window, found)
    wrong = [contradiction.place for contradiction in contradictions(still)]
    first, known = still, continued
    if wrong:
        loose = window.prior.without_given(np.array(wrong))
        first = under(loose, still, deadline)
        known = None if continued is None else under(loose, continued, deadline)
    search = JumpSearch(first, deadline, known=known, correlation=window.correlation)
    best = search.run() if found.accepted else still
    mixture = search.mixture() if found.accepted else Mixture.only(still)
    if wrong:
        best = under(window.prior, best, deadline) if best.problem.events else still
        mixture = mixture.about(best) if best.problem.events else Mixture.only(still)
    if best.jumps and not window.noise_known:
        window, best = _in_own_noise(window, mixture.best, deadline)
        mixture = mixture.about(best)
    return window, Explanation(mixture, search.finished, search.tried)


def uncertainty_of(best: Hypothesis) -> Uncertainty:
    """Return the hypothesis with its covariance and the information about its parameters."""
    if not best.problem.events:
        return Uncertainty(best, best.covariance, informed_information(best))
    final = best.final_parameters
    return Uncertainty(best, best.covariance, scaled_inverse(best.covariance[np.ix_(final, final)]))


def recall(uncertainty: Uncertainty, prior: Prior | None, deadline: Deadline) -> Uncertainty:
    """Return an uninformative window under a more informative prior, if that fits as well."""
    best = uncertainty.hypothesis
    if prior is None:
        return uncertainty
    problem = PiecewiseProblem(best.problem.objective, prior, best.problem.events)
    other = hypothesis_at(problem, polished(problem, best.point, deadline)[0])
    if other.cost < best.cost + STAGES.price_of_recall:
        return uncertainty_of(other)
    return uncertainty


def is_uninformative(uncertainty: Uncertainty) -> bool:
    """Whether a window without any jump has hardly narrowed the prior of any parameter."""
    if uncertainty.hypothesis.jumps:
        return False
    problem = uncertainty.hypothesis.problem
    steady = problem.objective.unknowns.may_jump
    before = np.diagonal(scaled_inverse(problem.prior.precision))[steady]
    return bool((np.diagonal(uncertainty.covariance)[steady] > STAGES.nothing_new * before).all())


def determined_alone(uncertainty: Uncertainty, known: BoolArray, deadline: Deadline) -> BoolArray:
    """Return which parameters (q,) a window determines without any that came before.

    A window with a jump inside says so of none. Where profiles were needed, the parabola tells
    nothing of its own: unless all that it tells is `known` (q,), profiles are followed anew.
    """
    best, interval = uncertainty.hypothesis, uncertainty.interval
    unknowns = best.problem.objective.unknowns
    n, limit = unknowns.n_states, undetermined(unknowns)[unknowns.n_states :]
    if best.problem.events:
        return np.zeros(limit.size, dtype=np.bool_)
    box = Prior.box(unknowns)
    variances = np.diagonal(scaled_inverse(uncertainty.information + box.precision[n:, n:]))
    told = np.asarray(np.sqrt(variances) < limit)
    if interval is None:
        return told
    told &= interval.told(unknowns)
    unaided = np.array_equal(best.problem.prior.precision, box.precision)
    if unaided or not (told & ~known).any():
        return told
    own = determined(under(box, best, deadline), uncertainty.fit.enlargement, deadline)
    if own.interval is None:
        return told & (np.sqrt(np.diagonal(own.covariance)[n:]) < limit)
    return told & own.interval.told(unknowns)


def continued_jumps(
    window: WindowState, explained: Explained, warm: Array, deadline: Deadline
) -> Hypothesis | None:
    """Return the hypothesis that the jumps of an earlier window are as it `explained` them.

    None if none of them lies in this one. `warm` (d,) is where this window is expected to begin.
    """
    events, point = _moved(explained, window, warm)
    if not events:
        return None
    problem = PiecewiseProblem(window.objective, window.prior, events)
    z, squares = polished(problem, np.clip(point, *problem.limits), deadline)
    return hypothesis_at(problem, z) if np.isfinite(squares) else None


def under(prior: Prior, best: Hypothesis, deadline: Deadline) -> Hypothesis:
    """Return the hypothesis of the same jumps under another prior."""
    problem = replace(best.problem, prior=prior)
    return hypothesis_at(problem, polished(problem, best.point, deadline)[0], best.earlier)


def _from_warm(
    window: WindowState, warm: Array, continued: Hypothesis | None, deadline: Deadline
) -> tuple[WindowState, Found | None]:
    """Return the fit from a warm start alone, where it or the known jumps explain the window.

    Outliers are left out where the window is explained without them.
    """
    posterior = window.posterior
    solved = levenberg_marquardt(
        posterior, warm[None], posterior.nodes, MemeticSettings.full_iterations, deadline
    )
    z, squares = solved.z[0], float(solved.squares[0])
    limit, rule = _believed(window), Acceptance.LIKE_NOISE
    if not squares <= limit:
        clean = without_outliers(window, [warm, z], deadline) if np.isfinite(squares) else None
        if clean is not None and clean.squares <= _believed(clean.window):
            window, z, squares = clean.window, clean.z, clean.squares
        elif continued is None or continued.squares > limit:
            return window, None
        else:
            rule = Acceptance.KNOWN_JUMP
    converged = bool(solved.converged[0])
    return window, Found(z, squares, converged, accepted=rule, effort=Effort(1, 'round'))


def _believed(window: WindowState) -> float:
    """Return the squares up to which a fit from a warm start alone is believed."""
    count, correlation = window.posterior.count(window.objective.nodes), window.correlation
    spread = np.sqrt(2.0 * count / independent_share(correlation))
    return float((count + STAGES.excess * spread) / inflation(correlation))


def _moved(
    explained: Explained, window: WindowState, warm: Array
) -> tuple[tuple[tuple[int, ...], ...], Array]:
    """Return the events and the point of an earlier window's jumps that lie in this one too.

    `warm` (d,) is where this window is expected to begin, but for what has not jumped yet.
    """
    objective, new = window.objective, window.objective.grid.t
    z, events, tail = warm.copy(), [], []
    layout, point = explained.layout, explained.point
    n = objective.unknowns.n_states
    z[n:] = point[n : layout.dimension]
    jumped = layout.jumped(point)
    for event in dict.fromkeys(jump.event for jump in jumped):
        moment = explained.start + point[layout.times[event]] * (explained.end - explained.start)
        values = [(jump.parameter, point[jump.after]) for jump in jumped if jump.event == event]
        if moment <= new[0]:
            for i, value in values:
                z[i] = value
        elif moment < new[-1]:
            events.append(tuple(i for i, _ in values))
            tail += [(moment - new[0]) / (new[-1] - new[0]), *(value for _, value in values)]
    return tuple(events), np.concatenate([z, tail])


def _in_own_noise(
    window: WindowState, best: Hypothesis, deadline: Deadline
) -> tuple[WindowState, Hypothesis]:
    """Return window and hypothesis in units of the noise that the hypothesis leaves."""
    grid = window.objective.grid
    left = variances_left(best.trajectory[1], grid, best.point.size)
    window = window.rescaled(np.sqrt(left) / grid.scale)
    problem = PiecewiseProblem(window.objective, best.problem.prior, best.problem.events)
    return window, hypothesis_at(problem, polished(problem, best.point, deadline)[0], best.earlier)
