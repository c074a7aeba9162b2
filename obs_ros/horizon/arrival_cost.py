"""The arrival cost: the parameters' distribution by earlier windows, and the jumps since.

A window hands on mean and covariance of its parameters, not of its state: the state at the start of
the next one is free. Between windows a parameter walks, p_k+1 = p_k + w, with a variance that grows
with the time between; a jump adds the variance of its box.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri

from obs_ros.core.estimate import Jump
from obs_ros.core.linear_algebra import scaled_inverse
from obs_ros.core.typing import Array
from obs_ros.inference.assessment.informed_subspace import marginal_information
from obs_ros.inference.jumps.hypothesis import Hypothesis
from obs_ros.inference.jumps.settings import JUMP_SETTINGS, JumpSettings
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.inference.prior import Prior, box_variances

KEPT = 1000  # windows at most, a bound on memory; overlapping ones end close to each other
FORGOTTEN = 1e6  # times the box's variance: a walk of infinite speed


@dataclass(frozen=True)
class ArrivalSettings:
    """Limits of what earlier windows say.

    - `contradiction`: probability of a prior as far off as this one, were it right, below which it
      is dropped.
    """

    contradiction: float = 1e-4


ARRIVAL = ArrivalSettings()


@dataclass(frozen=True)
class WindowPosterior:
    """Parameters at the end (s) of a window: mean (q,) and covariance (q, q), in boxes.

    `walked`: those that walk have done so up to there; else they are means over the window.
    """

    end: float
    mean: Array
    covariance: Array
    walked: bool = False


@dataclass(frozen=True)
class KnownJump:
    """A jump found: its time (s), and the places of what jumped."""

    time: float
    parameters: frozenset[int]

    def is_like(self, other: 'KnownJump', near: float) -> bool:
        """Whether both are of the same parameters, at most `near` (s) apart."""
        return self.parameters == other.parameters and abs(self.time - other.time) <= near


class ArrivalCost:
    """Accepted windows, and the jumps between them.

    A window takes its prior from the newest one that ended before it began, so that no sample is
    used twice: with overlapping windows information arrives late, but it is true.
    """

    def __init__(self, unknowns: Unknowns, jumps: JumpSettings = JUMP_SETTINGS) -> None:
        self._unknowns, self._jumps = unknowns, jumps
        self._entries: list[WindowPosterior] = []
        self.jumps: list[KnownJump] = []

    def add(self, entry: WindowPosterior) -> None:
        """Remember an accepted window."""
        self._entries.append(entry)
        del self._entries[:-KEPT]

    def update_jumps(self, jumps: Iterable[Jump], start: float, end: float, near: float) -> None:
        """Take over the jumps that the window from `start` to `end` (s) found.

        They replace those known inside it. A jump is new unless one of the same parameters was
        known within `near` (s): then the windows that ended after it, and did not know of it, are
        forgotten. So are jumps and windows that no later window needs.
        """
        places = {name: i for i, name in enumerate(self._unknowns.names)}
        earlier = self.jumps
        self.jumps = [known for known in earlier if known.time < start]
        for jump in jumps:
            found = KnownJump(jump.time, frozenset(places[name] for name in jump.sizes))
            if not any(found.is_like(known, near) for known in earlier):
                self._entries = [entry for entry in self._entries if entry.end <= found.time]
            self.jumps.append(found)
        self.prune(start, end - start)

    def last_before(self, start: float) -> WindowPosterior | None:
        """Return the newest window that ended by `start` (s)."""
        return next((e for e in reversed(self._entries) if e.end <= start), None)

    def prior(self, start: float, duration: float) -> Prior | None:
        """Return what is known of the parameters at `start` (s); None if no window ended by then.

        The parameters walk at random, so far in one `duration` (s) as one jump in as many windows
        as a jump is rare; disturbances as far as they say, counted between the windows' means.
        """
        newest = self.last_before(start)
        return None if newest is None else self._since(newest, start, duration, newest.end)

    def given_prior(self, start: float, *, first: bool) -> Prior:
        """Return what is known at `start` (s) where no window ended by then: the given priors.

        Those of states count in the `first` window, those of parameters until they jump.
        """
        jumped = [place for jump in self.jumps if jump.time <= start for place in jump.parameters]
        return Prior.known(self._unknowns, start=first, jumped=np.array(jumped, dtype=np.int64))

    def most_informative_prior(self, start: float, duration: float) -> Prior | None:
        """Return the prior by the most informative window of the last `duration` (s).

        Such windows have seen mostly the same samples, cut elsewhere. None if it is the newest.
        """
        newest = self.last_before(start)
        if newest is None:
            return None
        n = self._unknowns.n_states
        latest = [e for e in self._entries if newest.end - duration < e.end <= start]
        priors = [self._since(entry, start, duration, newest.end) for entry in reversed(latest)]
        informed = [float(np.linalg.slogdet(prior.precision[n:, n:])[1]) for prior in priors]
        best = int(np.argmax(informed))
        return priors[best] if best else None

    def _since(self, entry: WindowPosterior, start: float, duration: float, known: float) -> Prior:
        """Return the prior at `start` by what one of the latest windows knew.

        Since then parameters have walked as far as through windows that abut as the newest one,
        that ended at `known` (s), does on this: age alone must not make a window more informative.
        """
        variances = box_variances(self._unknowns)
        gap = (start - known) / duration * (1.0 + (known - entry.end) / duration)
        walked = self._jumps.prior_probability * gap * variances
        for jump in self.jumps:
            if entry.end < jump.time <= start:
                jumped = [place - self._unknowns.n_states for place in jump.parameters]
                walked[jumped] += variances[jumped]
        walks = self._unknowns.walks
        wandering = np.isfinite(walks)
        apart = start - entry.end + (0.0 if entry.walked else 2.0 / 3.0 * duration)
        walked[wandering] += walks[wandering] ** 2 * apart
        new = np.isinf(walks)
        walked = np.where(new, FORGOTTEN * variances, np.minimum(walked, FORGOTTEN * variances))
        covariance = entry.covariance + np.diag(walked)
        prior = Prior.of(self._unknowns, entry.mean, covariance, gap)
        return prior.with_given(self._unknowns, self._unknowns.n_states + np.flatnonzero(new))

    def prune(self, start: float, duration: float) -> None:
        """Forget what no window that starts at or after `start` (s) can need."""
        newest = self.last_before(start)
        if newest is not None:
            oldest = newest.end - duration
            self._entries = [entry for entry in self._entries if entry.end > oldest]
            self.jumps = [jump for jump in self.jumps if jump.time > oldest]


def contradicts_prior(
    best: Hypothesis, known: Prior | None = None, settings: ArrivalSettings = ARRIVAL
) -> bool:
    """Whether a window's own optimum is better than a right prior would let it be.

    Without the prior of the parameters, of mean m and precision P, -2 log p falls by o' P o +
    o' P (I + B)^-1 P o with o = p - m, I the window's information and B that of the boxes: for a
    right prior a chi-square of as many degrees of freedom as there are parameters. A prior that is
    `known` without any window is the user's, and stays.
    """
    problem = best.problem
    n, q = problem.objective.unknowns.n_states, best.layout.dimension
    given = problem.prior
    B = (known or Prior.box(problem.objective.unknowns)).precision[n:, n:]
    P = given.precision[n:, n:]
    if problem.events or q == n or np.allclose(P, B):
        return False
    off = best.point[n:q] - given.mean[n:]
    own = scaled_inverse(marginal_information(best, n) - given.information(q - n) + B)
    gain = off @ P @ off + off @ P @ own @ P @ off
    return bool(gain > chdtri(q - n, settings.contradiction))
