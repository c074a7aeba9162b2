"""Outliers: samples far beyond the noise that are no measurements of the plant.

A single one, or a few side by side, is an outlier; more in a row are a burst, which is a fault of
the sensor. Both are taken as not measured: weights of 0 in a redescending loss (Hampel et al. 1986,
section 2.6), of 1 for all others. A step, the decay after a jump of a fast parameter, and what a
wrong model leaves are none: they do not come and go at once.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from obs_ros.core.typing import Array, BoolArray
from obs_ros.inference.window_state import Outlier, WindowState

NORMAL_MEDIAN = 0.6745  # of the size of unit normal noise


@dataclass(frozen=True)
class OutlierSettings:
    """Limits of what counts as an outlier; sizes are in standard deviations of the noise.

    - `limit`: least size; Gaussian noise reaches it in one of 1.7 million samples;
    - `beside`: most size of the samples before and after, or `echo` of the outlier's own, if that
      is more: a jump of a fast parameter decays, an outlier does not;
    - `few`: most consecutive samples of one output that are outliers; more are a burst;
    - `hidden`: samples in a row within a burst that may look sound by chance;
    - `abrupt`: share of its largest size by which a burst begins or ends from one sample to the
      next, and `rough`: times that size that its samples vary by in all, if it does not;
    - `most`: share of an output's values, though one is always allowed; more are another noise;
    - `values`: measured ones below which nothing tells what the others would be;
    - `least`: share of the signal, root mean square; less would be seen by nobody;
    - `trimmed`: size from which on samples do not count while the fit to most of them is sought, in
      `rounds` at most; in the first `steps` as many as `most` do not;
    - `iterations`: of each fit in those, which the next one begins from;
    - `tail`: least share of the squares that `most` of the samples have, .65 in normal noise, where
      outliers have drawn the fit so far that none is left beyond the `limit`;
    - `before`: nodes before an outlier at which a jump may stand for it;
    - `probability`: that a sample is an outlier, a priori.
    """

    limit: float = 5.0
    beside: float = 3.5
    echo: float = 0.1
    few: int = 3
    hidden: int = 2
    abrupt: float = 0.5
    rough: float = 2.3
    most: float = 0.2
    values: int = 10
    least: float = 1e-4
    trimmed: float = 3.5
    rounds: int = 3
    steps: int = 2
    iterations: int = 2
    tail: float = 0.7
    before: int = 3
    probability: float = 0.01

    @property
    def penalty(self) -> float:
        """-2 log of the prior probability of one outlier."""
        return 2.0 * math.log(1.0 / self.probability)


OUTLIERS = OutlierSettings()


def outliers_in(window: WindowState, residuals: Array, *, noise_known: bool) -> BoolArray:
    """Return which samples (K, r) of a window are outliers by residuals (K, r); see `suspects`.

    None is by a loss of squares.
    """
    if not window.robust:
        return np.zeros(residuals.shape, dtype=np.bool_)
    return suspects(residuals, window.record.y, noise_known=noise_known)


def first_far(window: WindowState, innovations: Array, *, noise_known: bool) -> BoolArray:
    """Return the first of each run of a filter's innovations (K, r) far out, whatever follows it.

    An outlier moves the filter, and so the innovations that follow. None is by a loss of squares.
    """
    sizes = np.abs(innovations) / spread(innovations, noise_known=noise_known)
    found = np.zeros(sizes.shape, dtype=np.bool_)
    for column, e in enumerate(sizes.T if window.robust else ()):
        known = np.flatnonzero(np.isfinite(e))
        firsts = [known[first] for first, _ in _stretches(e[known] > OUTLIERS.limit)]
        if known.size >= OUTLIERS.values and len(firsts) <= _allowed(known.size):
            found[firsts, column] = True
    return found


def suspects(residuals: Array, y: Array, *, noise_known: bool) -> BoolArray:
    """Return which residuals (K, r) are those of outliers and bursts.

    NaN = not measured. They are in units of the noise, or in any if it is not known; y (K, r) are
    the measured values.
    """
    found = np.zeros(residuals.shape, dtype=np.bool_)
    near = noise_known and not (np.abs(residuals) > OUTLIERS.limit).any()  # NaN is not
    if near and not any(map(repeated, _known(y))):
        return found
    scaled = residuals / spread(residuals, noise_known=noise_known)
    for column, (e, values) in enumerate(zip(scaled.T, y.T, strict=True)):
        known = np.flatnonzero(np.isfinite(e))
        if known.size >= OUTLIERS.values:
            own = _outlying(e[known], values[known])
            if own.sum() <= _allowed(known.size):
                found[known, column] = own
    return found


def spread(residuals: Array, *, noise_known: bool) -> Array:
    """Return the standard deviations (r,) of residuals (K, r) by their median sizes.

    In units of a noise that is known they are 1 at least; infinite where nothing was measured.
    """
    sizes = [np.abs(column[np.isfinite(column)]) for column in residuals.T]
    found = np.array([np.median(each) / NORMAL_MEDIAN if each.size else np.inf for each in sizes])
    least = 1.0 if noise_known else np.finfo(float).tiny
    return np.asarray(np.maximum(found, least))


def repeated(y: Array) -> list[tuple[int, int]]:
    """Return first and end of the runs of the very same values (M,), of `few` at least.

    There are none where shorter ones are found: then the sensor rounds.
    """
    same = y[1:] == y[:-1]
    if not same.any():
        return []
    found = [(first, end + 1) for first, end in _stretches(same)]
    return found if all(end - first >= OUTLIERS.few for first, end in found) else []


def _known(y: Array) -> Iterator[Array]:
    """Yield the measured values (M,) of each output of y (K, r)."""
    return (column[np.isfinite(column)] for column in y.T)


def left_out(window: WindowState, found: BoolArray, residuals: Array) -> WindowState:
    """Return the window without outliers (K, r), noted by their residuals (K, r)."""
    grid, unit = window.objective.grid, spread(residuals, noise_known=window.noise_known)
    outliers = list(window.outliers)
    for i, column in enumerate(found.T):
        known = np.flatnonzero(grid.weight[:, i] > 0.0)
        for first, end in _stretches(column[known]):
            burst = float(grid.t[known[first]]) if end - first > OUTLIERS.few else None
            outliers += [
                Outlier(float(grid.t[k]), i, float(np.abs(residuals[k, i]) / unit[i]), burst)
                for k in known[first:end]
            ]
    return replace(window.without(found), outliers=tuple(outliers))


def _allowed(values: int) -> int:
    """Return how many of an output's values may be outliers."""
    return max(1, int(OUTLIERS.most * values))


def _outlying(e: Array, y: Array) -> BoolArray:
    """Return which of successive scaled residuals (M,) come and go as no plant would.

    y (M,) are the values measured.
    """
    far = np.abs(e) > OUTLIERS.limit
    same = repeated(y)
    for first, end in same:
        far[first:end] |= np.sum(e[first:end] ** 2) > OUTLIERS.limit**2
    found = np.zeros_like(far)
    for first, end in _runs(far):
        largest = float(np.abs(e[first:end]).max())
        beside = np.abs(e[[i for i in (first - 1, end) if 0 <= i < e.size]])
        quiet = (beside <= max(OUTLIERS.beside, OUTLIERS.echo * largest)).all()
        short = end - first < OUTLIERS.few
        if quiet and (short or (first, end) in same or _at_once(e, first, end, largest)):
            found[first:end] = True
    return found


def _runs(far: BoolArray) -> list[tuple[int, int]]:
    """Return first and end of the runs of samples (M,) far out, bursts as one each."""
    found: list[tuple[int, int]] = []
    for first, end in _stretches(far):
        found.append((first, end))
        begin = len(found) - 1
        while begin and found[begin][0] - found[begin - 1][1] <= OUTLIERS.hidden:
            begin -= 1
        if far[found[begin][0] : end].sum() > OUTLIERS.few:
            found[begin:] = [(found[begin][0], end)]
    return found


def _stretches(chosen: BoolArray) -> list[tuple[int, int]]:
    """Return first and end of the runs of chosen samples (M,)."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], chosen, [False]]).astype(np.int8)))
    return [(int(first), int(end)) for first, end in edges.reshape(-1, 2)]


def _at_once(e: Array, first: int, end: int, largest: float) -> bool:
    """Whether a run of residuals ends at once, or varies by more than a decay would."""
    around = np.abs(np.diff(e[max(first - 1, 0) : end + 1]))
    if around.sum() >= OUTLIERS.rough * largest:
        return True
    return bool(around[-1 if end < e.size else 0] >= OUTLIERS.abrupt * largest)
