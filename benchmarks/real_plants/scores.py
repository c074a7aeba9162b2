"""Figures of windows of one recorded plant: shares, scatter of disjoint windows, forecasts."""

from collections.abc import Sequence

import numpy as np

from benchmarks.real_plants.run import Solved
from benchmarks.recordings import OVERLAP
from obs_ros.core.typing import Array

GOOD = ('converged', 'approximate')
CHECKED = 4  # disjoint windows before the sequence can compare them
ENOUGH = 3  # disjoint windows with deviations that have a scatter


def good_share(own: Sequence[Solved]) -> float:
    """Return the share of windows with a good outcome and all deviations."""
    good = [one.outcome in GOOD and bool(np.isfinite(one.sd).all()) for one in own]
    return float(np.mean(good))


def scatter_over_sd(own: Sequence[Solved]) -> Array:
    """Return the scatter of disjoint windows in units of their own deviations (q,).

    Root of the mean squared deviation from the weighted mean; the median over the four rows of
    disjoint windows; NaN with fewer than three.
    """
    if not own:
        return np.array([])
    values, deviations = np.array([one.values for one in own]), np.array([one.sd for one in own])
    return np.array([_scatter(v, s) for v, s in zip(values.T, deviations.T, strict=True)])


def _scatter(values: Array, sd: Array) -> float:
    ratios = []
    for first in range(OVERLAP):
        v, s = values[first::OVERLAP], sd[first::OVERLAP]
        given = np.isfinite(s)
        if given.sum() >= ENOUGH:
            weights = 1.0 / s[given] ** 2
            mean = np.average(v[given], weights=weights)
            ratios.append(np.sqrt(np.sum(weights * (v[given] - mean) ** 2) / (given.sum() - 1)))
    return float(np.median(ratios)) if ratios else np.nan


def checked(sequence: Sequence[Solved]) -> Sequence[Solved]:
    """Return the windows of a sequence from which on it can compare disjoint ones."""
    return sequence[CHECKED * OVERLAP :]


def factors(sequence: Sequence[Solved], alone: Sequence[Solved]) -> tuple[Array, Array]:
    """Return the factor on deviations (q,) that the first half shows, and that the second needs.

    The first is the sequence's own at the last window that begins in the first half, the second the
    scatter of windows alone that begin after that has ended; both are 1 at least.
    """
    last = len(sequence) // 2 + 1  # the recording ends a window's length after the last begins
    shown, later = np.maximum(sequence[last].factor, 1.0), alone[last + OVERLAP :]
    needed = np.maximum(scatter_over_sd(later), 1.0) if later else np.full_like(shown, np.nan)
    return shown, needed


def near_share(
    sequence: Sequence[Solved], alone: Sequence[Solved], sds: float, *, larger: bool = False
) -> float:
    """Return the share of values within so many deviations of the same window's alone.

    In published deviations, or in the `larger` of the two: a window alone may know much less.
    Values that either does not determine have no say.
    """
    off = np.array([s.values - a.values for s, a in zip(sequence, alone, strict=True)])
    sd, other = np.array([one.sd for one in sequence]), np.array([one.sd for one in alone])
    told = np.isfinite(sd) & np.isfinite(other)
    unit = np.fmax(sd, other) if larger else sd
    return float(np.mean(np.abs(off[told]) <= sds * unit[told])) if told.any() else np.nan


def forecast_error(own: Sequence[Solved], horizon: str, held: bool = False) -> Array:
    """Return root mean square errors (r,) over all windows of forecasts, or of the last value."""
    errors = [(one.hold if held else one.forecast)[horizon] for one in own]
    return np.asarray(np.sqrt(np.nanmean(np.square(errors), axis=0)))


def together(errors: Array) -> float:
    """Return the geometric mean of the outputs' errors (r,): outputs have different units."""
    return float(np.exp(np.mean(np.log(errors))))
