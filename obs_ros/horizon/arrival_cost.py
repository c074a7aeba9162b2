"""The arrival cost: the parameters' distribution by earlier windows, and the jumps since.

A window hands on mean and covariance of its parameters, not of its state: the state at the start of
the next one is free. Between windows a parameter walks, p_k+1 = p_k + w, with a variance that grows
with the time between; a jump adds the variance of its box. Where jumps are in doubt they are those
of a sum of normal distributions, see `gaussian_sum`.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np

from obs_ros.core.changes import replace
from obs_ros.core.linear_algebra import log_determinant
from obs_ros.core.typing import Array
from obs_ros.horizon.found_jumps import JumpFound
from obs_ros.horizon.gaussian_sum import SUM, Component, Lineage, normalised
from obs_ros.inference.jumps.settings import JUMP_SETTINGS, JumpSettings
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.inference.prior import Prior

KEPT = 1000  # windows at most, a bound on memory; overlapping ones end close to each other
FORGOTTEN = 1e6  # times the box's variance: a walk of infinite speed


@dataclass(frozen=True)
class WindowPosterior:
    """Parameters at the end (s) of a window: mean (q,) and covariance (q, q), in boxes.

    `walked`: those that walk have done so up to there; else they are means over the window.
    `components`: the sum that these are the moments of; empty where there is but one lineage
    without any jump.
    """

    end: float
    mean: Array
    covariance: Array
    walked: bool = False
    components: tuple[Component, ...] = ()

    @property
    def parts(self) -> tuple[Component, ...]:
        """The components, one at least."""
        return self.components or (Component(1.0, self.mean, self.covariance),)


@dataclass(frozen=True)
class KnownJump:
    """A jump found: its time (s), and the places of what jumped, by the best hypothesis.

    `chances`: what may have jumped then, with probabilities that add up to 1: places, and the jump
    itself, None for none. Empty stands for certainty.
    """

    time: float
    parameters: frozenset[int]
    chances: tuple[tuple[float, frozenset[int], JumpFound | None], ...] = ()

    @property
    def certain(self) -> tuple[tuple[float, frozenset[int], JumpFound | None], ...]:
        """The chances, one at least."""
        return self.chances or ((1.0, self.parameters, None),)

    def is_like(self, other: 'KnownJump', near: float) -> bool:
        """Whether the other one counted with these parameters, at most `near` (s) apart."""
        sets = {places for _, places, _ in other.certain}
        return self.parameters in sets and abs(self.time - other.time) <= near


@dataclass(frozen=True)
class ArrivalMemory:
    """The windows and jumps of an arrival cost, with the variances (q,) of what drifts."""

    entries: tuple[WindowPosterior, ...]
    jumps: tuple[KnownJump, ...]
    drifts: Array


@dataclass(frozen=True)
class Lineal:
    """One lineage: its probability, its jumps, and the function that tells its prior."""

    weight: float
    prior: Callable[[], Prior]
    jumps: Lineage = ()


class ArrivalCost:
    """Accepted windows, and the jumps between them.

    A window takes its prior from the newest one that ended before it began, so that no sample is
    used twice: with overlapping windows information arrives late, but it is true.
    """

    def __init__(self, unknowns: Unknowns, jumps: JumpSettings = JUMP_SETTINGS) -> None:
        self._unknowns, self._jumps = unknowns, jumps
        self._entries: list[WindowPosterior] = []
        self.jumps: list[KnownJump] = []
        # Variances (q,) per s of parameters that drift, in boxes.
        self.drifts = np.zeros(unknowns.dimension - unknowns.n_states)

    @property
    def memory(self) -> ArrivalMemory:
        """All that is known; nothing changes it later."""
        return ArrivalMemory(tuple(self._entries), tuple(self.jumps), self.drifts.copy())

    def recall(self, memory: ArrivalMemory) -> None:
        """Know what another one knew, of the same unknowns."""
        self._entries, self.jumps = list(memory.entries), list(memory.jumps)
        self.drifts = memory.drifts.copy()

    def add(self, entry: WindowPosterior) -> None:
        """Remember an accepted window, unless what it says is not finite."""
        if not (np.isfinite(entry.mean).all() and np.isfinite(entry.covariance).all()):
            return
        self._entries.append(entry)
        del self._entries[:-KEPT]

    def update_jumps(
        self, jumps: Iterable[KnownJump], start: float, end: float, near: float
    ) -> None:
        """Take over the jumps that the window from `start` to `end` (s) found.

        They replace those known inside it. A jump is new unless one that counted with the same
        parameters was known within `near` (s): then the windows that ended after it, and did not
        know of it, are forgotten. So are jumps and windows that no later window needs.
        """
        earlier = self.jumps
        self.jumps = [known for known in earlier if known.time < start]
        for found in jumps:
            if found.parameters and not any(found.is_like(known, near) for known in earlier):
                self._entries = [entry for entry in self._entries if entry.end <= found.time]
            self.jumps.append(found)
        self.prune(start, end - start)

    def forget_wrong(self, time: float, end: float) -> None:
        """Forget the windows that ended after a jump taken back, at `time`, and before `end` (s).

        They believe in it; what the window that took it back hands on does not.
        """
        self._entries = [entry for entry in self._entries if not time < entry.end < end]

    def note_drifts(self, rates: Mapping[str, float]) -> None:
        """Take over which parameters drift, with the variances of their walks per s, in boxes."""
        self.drifts[:] = 0.0
        for name, rate in rates.items():
            self.drifts[self._unknowns.names.index(name) - self._unknowns.n_states] = rate

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
        informed = [log_determinant(prior.precision[n:, n:]) for prior in priors]
        best = int(np.argmax(informed))
        return priors[best] if best else None

    def lineages(self, start: float, duration: float) -> tuple[Lineal, ...]:
        """Return the priors at `start` (s) of all lineages; none if no window ended by then."""
        newest = self.last_before(start)
        if newest is None:
            return ()
        parts = [(one, np.zeros_like(self.drifts)) for one in newest.parts]
        for jump in self._between(newest.end, start):
            parts = [
                (
                    replace(
                        one,
                        weight=one.weight * chance,
                        jumps=one.jumps if found is None else (*one.jumps, found),
                    ),
                    widened + self._boxes(places),
                )
                for one, widened in parts for chance, places, found in jump.certain
            ]  # fmt: skip
        parts = sorted(parts, key=lambda part: -part[0].weight)[: SUM.most]
        weights = [one.weight for one in normalised([one for one, _ in parts])]
        return tuple(
            Lineal(
                weight,
                partial(
                    self._prior,
                    newest,
                    one.mean,
                    one.covariance,
                    widened,
                    start,
                    duration,
                    newest.end,
                ),
                one.jumps,
            )
            for weight, (one, widened) in zip(weights, parts, strict=True)
        )

    def _since(self, entry: WindowPosterior, start: float, duration: float, known: float) -> Prior:
        """Return the prior at `start` by what one of the latest windows knew; see `_prior`."""
        widened = np.zeros_like(self.drifts)
        for jump in self._between(entry.end, start):
            for chance, places, _ in jump.certain:
                widened += chance * self._boxes(places)
        return self._prior(entry, entry.mean, entry.covariance, widened, start, duration, known)

    def _between(self, end: float, start: float) -> list[KnownJump]:
        """Return the jumps after the end of one window and up to the start of another (s)."""
        return [jump for jump in self.jumps if end < jump.time <= start]

    def _boxes(self, places: frozenset[int]) -> Array:
        """Return the variances (q,) of the boxes of parameters at `places`, 0 of all others."""
        jumped = [place - self._unknowns.n_states for place in places]
        variances = np.zeros_like(self.drifts)
        variances[jumped] = self._unknowns.box_variances[jumped]
        return variances

    def _prior(
        self,
        entry: WindowPosterior,
        mean: Array,
        covariance: Array,
        widened: Array,
        start: float,
        duration: float,
        known: float,
    ) -> Prior:
        """Return the prior at `start` by mean and covariance at the end of one window.

        Jumps since have added the variances `widened` (q,). Parameters have walked as far as
        through windows that abut as the newest one, that ended at `known` (s), does on this: age
        alone must not make a window more informative.
        """
        variances = self._unknowns.box_variances
        gap = (start - known) / duration * (1.0 + (known - entry.end) / duration)
        walked = self._jumps.prior_probability * gap * variances + widened
        walks = self._unknowns.walks
        wandering = np.isfinite(walks)
        apart = start - entry.end + (0.0 if entry.walked else 2.0 / 3.0 * duration)
        walked += self.drifts * apart
        walked[wandering] += walks[wandering] ** 2 * apart
        new = np.isinf(walks)
        walked = np.where(new, FORGOTTEN * variances, np.minimum(walked, FORGOTTEN * variances))
        prior = Prior.of(self._unknowns, mean, covariance + np.diag(walked), gap)
        return prior.with_given(self._unknowns, self._unknowns.n_states + np.flatnonzero(new))

    def prune(self, start: float, duration: float) -> None:
        """Forget what no window that starts at or after `start` (s) can need."""
        newest = self.last_before(start)
        if newest is not None:
            oldest = newest.end - duration
            self._entries = [entry for entry in self._entries if entry.end > oldest]
            self.jumps = [jump for jump in self.jumps if jump.time > oldest]
