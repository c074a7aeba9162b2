"""Shares of published intervals that hold the truth, and how they lie beside true profiles."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from benchmarks.coverage.reference import Profile
from benchmarks.coverage.run import Track
from benchmarks.intervals import clustered_interval
from obs_ros import Model
from obs_ros.core.model import Variable
from obs_ros.core.typing import Array, BoolArray

NARROW = 0.25  # of the box, on either side of the optimum
MISSED = 2.0  # excess of the squares, of an optimum that the search did not find


class Share(NamedTuple):
    """A share of `count` values with its 95 % interval; NaN of none."""

    value: float
    low: float
    high: float
    count: int

    @classmethod
    def of(cls, clusters: Sequence[BoolArray]) -> 'Share':
        """Return the share of true values, of clusters (any,) that hang together."""
        hits = np.array([np.sum(one) for one in clusters], dtype=float)
        counts = np.array([one.size for one in clusters], dtype=float)
        count = int(counts.sum())
        value = float(hits.sum()) / count if count else np.nan
        return cls(value, *clustered_interval(hits, counts), count)

    def meets(self, low: float, high: float) -> bool:
        """Tell whether the interval meets another one; that of no values does."""
        return self.low <= high and self.high >= low

    @property
    def brief(self) -> str:
        """The share and how many values."""
        return f'{self.value:.2f} of {self.count}' if self.count else '-'

    def __str__(self) -> str:
        """Tell share and interval."""
        return f'{self.value:.3f} ({self.low:.3f}-{self.high:.3f})' if self.count else '-'


def coverage(tracks: Sequence[Track], states: bool) -> Share:
    """Return the coverage of parameters, or of end states."""
    return Share.of([
        track.held[:, part][track.given[:, part]]
        for track in tracks for part in [track.part(states)]
    ])  # fmt: skip


def single(tracks: Sequence[Track], place: int) -> Share:
    """Return the coverage of one parameter."""
    return Share.of([track.held[:, place][track.given[:, place]] for track in tracks])


def far(tracks: Sequence[Track], states: bool) -> Share:
    """Return the share of errors beyond 5 sd, among values with a deviation."""
    return Share.of([
        track.far[:, part][np.isfinite(track.sd[:, part])]
        for track in tracks for part in [track.part(states)]
    ])  # fmt: skip


class Matched(NamedTuple):
    """The parameters (q,) of a window beside their true profile.

    `given`: with a published interval; `held`, `true_held`: published and true one hold the truth;
    `bounded`: the true one ends on both sides; `narrow`: by less than NARROW of the box; `widths`:
    published over true; `excess`: of the squares at the published point, over the least ones.
    """

    given: BoolArray
    held: BoolArray
    true_held: BoolArray
    bounded: BoolArray
    narrow: BoolArray
    widths: Array
    excess: float

    @property
    def both_given(self) -> BoolArray:
        """Parameters whose true profile is narrow and that have a published interval."""
        return np.asarray(self.narrow & self.given)


def matched(model: Model, track: Track, profile: Profile) -> Matched:
    """Return the parameters of a window alone beside their profile."""
    q = track.parameters
    lower, upper, truth = track.lower[0, :q], track.upper[0, :q], track.truth[0, :q]
    low, high = profile.ends.T
    best = in_box(model.parameters, profile.best)
    sides = np.stack([best - in_box(model.parameters, low), in_box(model.parameters, high) - best])
    bounded = np.isfinite(profile.ends).all(axis=1)
    return Matched(
        given=track.given[0, :q],
        held=track.held[0, :q],
        true_held=np.asarray((low <= truth) & (truth <= high)),
        bounded=bounded,
        narrow=bounded & (sides < NARROW).all(axis=0),
        widths=(upper - lower) / (high - low),
        excess=float(track.squares[0]) - profile.least,
    )


def in_box(variables: Sequence[Variable], values: Array) -> Array:
    """Return values (q,) in boxes, on the scales of the variables; infinite stays so."""
    found = []
    for variable, value in zip(variables, values, strict=True):
        ends = np.array([variable.lower, variable.upper, value])
        if variable.scale == 'log' and value > 0.0:
            ends = np.log(ends)
        found.append((ends[2] - ends[0]) / (ends[1] - ends[0]))
    return np.array(found)


def given_of_narrow(pairs: Sequence[Matched]) -> Share:
    """Return the share with a published interval, of parameters whose true profile is narrow."""
    return Share.of([pair.given[pair.narrow] for pair in pairs])


def median_width(pairs: Sequence[Matched]) -> float:
    """Return the median of published over true width; NaN of none."""
    widths = [pair.widths[pair.both_given] for pair in pairs]
    found = np.concatenate([np.empty(0), *widths])
    return float(np.median(found)) if found.size else np.nan
