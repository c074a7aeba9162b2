"""Shares counted over the windows of several runs."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from benchmarks.intervals import COVERED, covered
from benchmarks.report import rms as root_mean_square
from benchmarks.sequence.track import Track
from obs_ros.core.typing import BoolArray


class Share(NamedTuple):
    """A share with the half-width of its 95 % interval.

    That is the binomial one of as many draws as there are windows, or that of the spread between
    runs where it is larger: windows that overlap are not independent.
    """

    value: float
    margin: float

    def __str__(self) -> str:
        return f'{self.value:.3f} ± {self.margin:.3f}'


def share(tracks: Sequence[Track], of: Callable[[Track], tuple[BoolArray, BoolArray]]) -> Share:
    """Return the share of hits among those that count; `of` tells both (W, any) of a run."""
    pairs = [of(track) for track in tracks]
    hits = np.array([np.sum(hit & counts) for hit, counts in pairs], dtype=float)
    totals = np.array([np.sum(counts) for _, counts in pairs], dtype=float)
    if not totals.sum():
        return Share(np.nan, np.nan)
    value = float(hits.sum() / totals.sum())
    windows = sum(len(track.end) for track in tracks)
    margin = binomial(value, windows)
    if len(tracks) > 1:
        # Of a ratio of sums, to first order.
        spread = np.std(hits - value * totals, ddof=1) * np.sqrt(len(tracks)) / totals.sum()
        margin = max(margin, COVERED * float(spread))
    return Share(value, margin)


def binomial(value: float, count: int) -> float:
    """Return the half-width of the 95 % interval of a share of `count` draws."""
    return COVERED * float(np.sqrt(value * (1.0 - value) / max(count, 1)))


def coverage(tracks: Sequence[Track], what: str) -> Share:
    """Return how many of the intervals that were given hold the truth; of `p` or of end states."""

    def held(track: Track) -> tuple[BoolArray, BoolArray]:
        error, sd = getattr(track, f'{what}_error'), getattr(track, f'{what}_sd')
        return covered(error, sd), np.isfinite(sd)

    return share(tracks, held)


def confidently_wrong(tracks: Sequence[Track]) -> Share:
    """Return the share of windows in which any value is."""
    return share(tracks, lambda t: every(np.asarray(t.confidently_wrong.any(axis=1))))


def withheld(tracks: Sequence[Track], what: str) -> Share:
    """Return the share of standard deviations that were not given; of `p` or of end states."""
    return share(tracks, lambda t: every(np.isnan(getattr(t, f'{what}_sd'))))


def alarmed(tracks: Sequence[Track]) -> Share:
    """Return the share of windows that report a new jump."""
    return share(tracks, lambda t: every(t.alarms > 0))


def mismatched(tracks: Sequence[Track]) -> Share:
    """Return the share of windows that say the model is wrong."""
    return share(tracks, lambda t: every(t.mismatch))


def rms(tracks: Sequence[Track], what: str) -> float:
    """Return the errors' root mean square in % of the box; of `p` or of end states."""
    errors = [getattr(track, f'{what}_error') for track in tracks]
    return 100.0 * float(root_mean_square(np.concatenate(errors)))


def every(hit: BoolArray) -> tuple[BoolArray, BoolArray]:
    """Return hits of which all count."""
    return hit, np.ones(hit.shape, dtype=bool)


def windows(tracks: Sequence[Track]) -> int:
    """Return how many windows there are."""
    return sum(len(track.end) for track in tracks)


def before(track: Track) -> Track:
    """Return the windows that end before anything happens."""
    return track.only(track.end <= track.event)


def after(track: Track) -> Track:
    """Return the windows that end after something has happened."""
    return track.only(track.end > track.event)
