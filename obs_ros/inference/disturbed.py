"""Windows explained by process noise: gains and candidate renewed by turns."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from obs_ros.core.deadline import Deadline
from obs_ros.core.linear_algebra import scaled_inverse
from obs_ros.core.typing import Array, IntArray
from obs_ros.inference import process_noise
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.inference.process_noise import (
    SETTINGS,
    ProcessNoise,
    estimated_parameters,
    first_guess,
    groups_of,
    least_noise,
    most_likely,
)
from obs_ros.inference.window_state import WindowState
from obs_ros.integration.backends import Kernels, correction_rehearsed
from obs_ros.integration.filter_pass import FilterPass
from obs_ros.integration.linear_path import LinearPath
from obs_ros.optimization.levenberg_marquardt import (
    LM_DEFAULTS,
    LMSettings,
    levenberg_marquardt,
)
from obs_ros.optimization.refinement import REFINED

STEP = 1e-4  # of a box, for differences


@dataclass(frozen=True)
class Disturbed:
    """A window explained by process noise: corrected rollouts, candidate z (d,), and noise.

    `criterion` is -2 log p(y, z) but for a constant, with the prior of z and log N for every walk
    (BIC; Schwarz 1978); `along` is the filter's pass along the candidate.
    """

    window: WindowState
    z: Array
    noise: ProcessNoise
    criterion: float
    along: FilterPass = field(repr=False)

    @property
    def last(self) -> int:
        """The node of the newest output."""
        return int(np.flatnonzero(self.along.measured.any(axis=1))[-1])

    @property
    def covariance(self) -> Array:
        """Covariance (n + q, n + q) of state and parameters there, the candidate given."""
        size = self.along.gain.shape[2]
        joint = np.zeros((size, size))
        joint[np.ix_(self.along.index, self.along.index)] = self.along.covariances[self.last]
        return joint

    @property
    def parameters(self) -> Array | None:
        """Parameters (q,) there; None if none walks."""
        return self.along.parameters[self.last] if self.along.moving.size else None

    def parameter_jacobian(self) -> Array:
        """Return the derivatives (q, d) of these by the unknowns, in boxes."""
        objective, z = self.window.objective, self.z[None]
        step = np.where(z > 0.5, -STEP, STEP)
        x0, p, steps = objective.unknowns.perturbed(z, step)
        objective.counter.candidates += x0.shape[1]
        moved = objective.kernels.paths(objective.grid, x0, p)[1][self.last]
        return np.asarray((moved[:, 1:] - moved[:, :1]) / steps)


def with_given_walks(
    window: WindowState, z: Array, given: Array, deadline: Deadline
) -> Disturbed | None:
    """Return the window explained by the walks that the model's states have, near z (d,)."""
    model = window.objective.unknowns.model
    guess = first_guess(window, z, given, ())
    walks = guess.walks.copy()
    walks[: len(model.states)] = [v.walk or 0.0 for v in model.states]
    found = _alternated(window, z, replace(guess, walks=walks), (), given, deadline)
    return None if found is None else _refined(window, found, deadline)


def with_walk_of(
    window: WindowState,
    z: Array,
    start: ProcessNoise,
    walking: IntArray,
    deadline: Deadline,
    hopeless: Callable[[Disturbed], bool],
) -> Disturbed | None:
    """Return the window in which one of the n + q variables walks, near z (d,) and a start.

    The noise is that of the start. None where some round's is `hopeless`.
    """
    return _alternated(window, z, start, (walking,), start.noise, deadline, hopeless=hopeless)


def with_known_noise(
    window: WindowState, z: Array, noise: ProcessNoise, deadline: Deadline
) -> Disturbed | None:
    """Return the optimum near z (d,) under process noise that is taken as it is."""
    found = filtered(window, z, noise)
    return _renewed(window, found, z, noise, deadline)


def disturbed(
    window: WindowState,
    z: Array,
    given: Array,
    previous: ProcessNoise | None,
    deadline: Deadline,
    *,
    afresh: bool = True,
) -> Disturbed | None:
    """Return the most likely explanation of a window by process noise, near a candidate z (d,).

    `given` (r,) are the outputs' known deviations, NaN where they are to be found; `previous` is
    the process noise of earlier windows, a start beside the default ones: walks of all groups of
    states, small and large, and of each alone. These are left out unless `afresh`. None if time is
    over, or nothing finite is found.
    """
    groups = groups_of(window.objective.unknowns.model)
    starts: list[tuple[ProcessNoise, Sequence[IntArray]]] = []
    if previous is not None:
        known = [group for group in groups if previous.walks[group[0]] > 0.0]
        noise = np.where(np.isfinite(given), given, previous.noise)
        starts.append((replace(previous, noise=noise), known))
    if afresh:
        guess = first_guess(window, z, given, groups)
        loose = guess.walks.copy()
        loose[: len(window.objective.unknowns.model.states)] *= SETTINGS.loose
        starts += [(guess, groups), (replace(guess, walks=loose), groups)]
        for group in groups if len(groups) > 1 else ():
            walks = guess.walks.copy()
            walks[: len(window.objective.unknowns.model.states)] = 0.0
            walks[group] = guess.walks[group]
            starts.append((replace(guess, walks=walks), [group]))
    best: tuple[Disturbed, Sequence[IntArray]] | None = None
    rounds = SETTINGS.rounds if len(starts) == 1 else 1
    for start, walking in starts:
        if deadline.passed:
            return None
        other = _alternated(window, z, start, walking, given, deadline, rounds)
        if other is not None and (best is None or other.criterion < best[0].criterion):
            best = other, walking
    if best is None:
        return None
    found, chosen = best
    if len(starts) > 1:  # only the most promising one is followed to its end
        rest = _alternated(window, found.z, found.noise, chosen, given, deadline)
        if rest is not None and rest.criterion < found.criterion:
            found = rest
    return _restricted(window, found, chosen, given, deadline)


def disturbed_at(window: WindowState, z: Array, noise: ProcessNoise) -> Disturbed:
    """Return the window at a candidate z (d,) with the gains that it has, and its criterion."""
    found = filtered(window, z, noise)
    states = noise.walks[: found.transition.shape[1]]
    walks = np.unique(states[states > 0.0]).size
    penalty = walks * np.log(window.objective.count(window.objective.nodes))
    squares = float(window.prior.squares(z[None])[0])
    criterion = found.neg2_log_likelihood + squares + penalty
    return Disturbed(corrected(window, found), z, noise, criterion, found)


def _alternated(
    window: WindowState,
    z: Array,
    noise: ProcessNoise,
    groups: Sequence[IntArray],
    given: Array,
    deadline: Deadline,
    rounds: int = SETTINGS.rounds,
    hopeless: Callable[[Disturbed], bool] | None = None,
) -> Disturbed | None:
    """Renew noise and candidate by turns until the likelihood stays; None where it is hopeless."""
    best: Disturbed | None = None
    found = filtered(window, z, noise)
    for _ in range(rounds):
        if not np.isfinite(found.neg2_log_likelihood):
            break
        noise = most_likely(LinearPath.of(found), noise, groups, given, least_noise(window))
        found = filtered(window, z, noise)
        now = _renewed(window, found, z, noise, deadline)
        if now is None:
            break
        if hopeless is not None and hopeless(now):
            return None
        if best is not None and now.criterion > best.criterion - SETTINGS.gain:
            return now if now.criterion < best.criterion else best
        best, z, found = now, now.z, now.along
    return best


def _renewed(
    window: WindowState,
    found: FilterPass,
    z: Array,
    noise: ProcessNoise,
    deadline: Deadline,
    local: LMSettings = LM_DEFAULTS,
) -> Disturbed | None:
    """Return the optimum near z (d,) under the gains of a pass, with gains of its own."""
    if is_lost(window, found, noise):
        return None
    problem, nodes = corrected(window, found).posterior, window.objective.nodes
    solved = levenberg_marquardt(problem, z[None], nodes, SETTINGS.polish, deadline, settings=local)
    if deadline.passed or not np.isfinite(solved.squares[0]):
        return None
    renewed = disturbed_at(window, solved.z[0], noise)
    return None if is_lost(window, renewed.along, noise) else renewed


def _refined(window: WindowState, best: Disturbed, deadline: Deadline) -> Disturbed:
    """Return the optimum to a small share of the deviations, see `optimization/refinement`."""
    found = _renewed(window, best.along, best.z, best.noise, deadline, REFINED)
    return best if found is None else found


def _restricted(
    window: WindowState,
    best: Disturbed,
    groups: Sequence[IntArray],
    given: Array,
    deadline: Deadline,
) -> Disturbed:
    """Renew the noise by the likelihood with the candidate integrated out (REML).

    The candidate fits part of the noise, so that the likelihood along it finds walks too small
    (Patterson & Thompson 1971). With its unknowns as states whose covariance at the start is that
    of the prior, the filter integrates them out, to first order.
    """
    unknowns = window.objective.unknowns
    found = filtered(window, best.z, best.noise, estimated_parameters(unknowns))
    slopes = unknowns.scale.slopes(best.z)
    prior = np.zeros((found.index.size, found.index.size))
    places = np.searchsorted(found.index, unknowns.index)
    prior[np.ix_(places, places)] = scaled_inverse(window.prior.precision) * np.outer(
        slopes, slopes
    )
    path = LinearPath.of(replace(found, prior=prior))
    noise = most_likely(path, best.noise, groups, given, least_noise(window))
    found = filtered(window, best.z, noise)
    renewed = _renewed(window, found, best.z, noise, deadline, REFINED)
    # What integrating out changes is little: a larger change has lost the optimum.
    worse = SETTINGS.restricted * window.objective.dimension
    if renewed is None or renewed.criterion > best.criterion + worse:
        return best
    return renewed


def filtered(
    window: WindowState, z: Array, noise: ProcessNoise, moving: IntArray | None = None
) -> FilterPass:
    """Return the filter's pass along a candidate z (d,), linearised by parameters `moving` too."""
    objective = window.objective
    x0, p = objective.unknowns.values(z[None])
    objective.counter.candidates += 1
    return objective.kernels.filter(
        objective.grid, x0[:, 0], p[:, 0], noise.walks, noise.noise, None, moving
    )


def is_lost(window: WindowState, found: FilterPass, noise: ProcessNoise) -> bool:
    """Whether a pass tells nothing: it diverged, or its deviations exceed all that was measured.

    Where a plant relaxes, derivatives along its jumps say that a small push moves it beyond any
    bound; no gain from such a covariance is right.
    """
    grid = window.objective.grid
    known = grid.weight > 0.0
    highest = np.max(grid.y, axis=0, where=known, initial=-np.inf)
    lowest = np.min(grid.y, axis=0, where=known, initial=np.inf)
    with np.errstate(invalid='ignore'):
        limit = highest - lowest + SETTINGS.apart * noise.noise
        beyond = np.sqrt(found.S) > limit
    return bool(beyond.any()) or not np.isfinite(found.neg2_log_likelihood)


def corrected(window: WindowState, found: FilterPass) -> WindowState:
    """Return the window whose rollouts are corrected with the gains of a filter's pass."""
    grid = window.objective.grid.injected(found.injection, found.S)
    objective = replace(window.objective, grid=grid)
    return replace(window, objective=objective, noise_known=True, correlation=0.0)


def process_noise_rehearsed(kernels: Kernels, unknowns: Unknowns, *, ramps: bool) -> Iterator[None]:
    """Compile, one kernel at a time, all that process noise needs beside the plain rollouts.

    With `ramps`, one parameter may walk that the model says does not.
    """
    process_noise.prepare()
    yield
    estimated = estimated_parameters(unknowns)
    # None, all (REML) and those that walk: the filter is compiled for each number of them.
    numbers = [0, estimated.size, int(np.isfinite(unknowns.walks).sum())]
    for number in dict.fromkeys([*numbers, min(1, estimated.size)] if ramps else numbers):
        yield from correction_rehearsed(kernels, estimated[:number])
