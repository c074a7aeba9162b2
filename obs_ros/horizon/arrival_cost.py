"""What earlier windows know of the parameters, and what has jumped since."""

from dataclasses import dataclass

import numpy as np

from obs_ros.core.typing import Array
from obs_ros.inference.jumps.settings import JUMP_SETTINGS, JumpSettings
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.inference.prior import Prior, box_variances

FORGOTTEN = 1e6  # times the box's variance
KEPT = 1000  # windows; overlapping ones end close to each other


@dataclass(frozen=True)
class WindowPosterior:
    """Parameters at the end (s) of a window: mean (q,) and covariance (q, q), in boxes."""

    end: float
    mean: Array
    covariance: Array


@dataclass(frozen=True)
class KnownJump:
    """A jump found: its time (s), and the places of what jumped."""

    time: float
    parameters: frozenset[int]


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

    def jumped(self, jump: KnownJump) -> None:
        """Forget the windows that did not know of a jump before their end."""
        self._entries = [entry for entry in self._entries if entry.end <= jump.time]

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

    def most_informative_prior(self, start: float, duration: float) -> Prior | None:
        """Return the same by the window that knew most, of those that ended in the last `duration`.

        They have seen mostly the same samples, cut elsewhere. None if it is the newest.
        """
        newest = self.last_before(start)
        if newest is None:
            return None
        n = self._unknowns.n_states
        latest = [e for e in self._entries if newest.end - duration < e.end <= start]
        priors = [self._since(entry, start, duration, newest.end) for entry in reversed(latest)]
        known = [float(np.linalg.slogdet(prior.precision[n:, n:])[1]) for prior in priors]
        surest = int(np.argmax(known))
        return priors[surest] if surest else None

    def _since(self, entry: WindowPosterior, start: float, duration: float, known: float) -> Prior:
        """Return the prior at `start` by what one of the latest windows knew.

        Since then parameters have walked as far as through windows that abut as the newest one,
        that ended at `known` (s), does on this: older ones must not seem surer for being older.
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
        apart = start - entry.end + 2.0 / 3.0 * duration
        walked[wandering] += walks[wandering] ** 2 * apart
        walked[np.isinf(walks)] = FORGOTTEN * variances[np.isinf(walks)]
        covariance = entry.covariance + np.diag(walked)
        return Prior.of(self._unknowns, entry.mean, covariance, gap)

    def prune(self, start: float, duration: float) -> None:
        """Forget what no window that starts at or after `start` (s) can need."""
        newest = self.last_before(start)
        if newest is not None:
            oldest = newest.end - duration
            self._entries = [entry for entry in self._entries if entry.end > oldest]
            self.jumps = [jump for jump in self.jumps if jump.time > oldest]
