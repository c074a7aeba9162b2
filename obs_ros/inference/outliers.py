"""Outliers: single samples far beyond the noise that are no measurements of the plant.

They are left out of their window. A burst, a step, and the decay after a jump of a fast parameter
are none: they have samples beside them that are far out too.
"""

import math
from collections.abc import Sequence
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
    - `longest`: most consecutive samples of one output; more are a burst, or a step;
    - `most`: share of the window's values, though one is always allowed; more are another noise;
    - `values`: measured ones below which nothing tells what the others would be;
    - `least`: share of the signal, root mean square; less would be seen by nobody;
    - `comparable`: share of the largest size that others need to be left out beside it: a gross
      outlier drags the fit, and others seem far out that are not;
    - `rounds`: of leaving out and fitting anew;
    - `before`: nodes before an outlier at which a jump may stand for it;
    - `together`: share of the squares of several outliers that one jump must not explain: it may
      show in single samples alone, one at each step of an input;
    - `hint`: gain in -2 log evidence, penalty apart, of such a jump by all other samples, from
      which on the search for jumps decides;
    - `probability`: that a sample is an outlier, a priori;
    - `told`: outliers that a message names.
    """

    limit: float = 5.0
    beside: float = 3.5
    echo: float = 0.1
    longest: int = 2
    most: float = 0.03
    values: int = 10
    least: float = 1e-4
    comparable: float = 0.3
    rounds: int = 5
    before: int = 3
    together: float = 0.5
    hint: float = 0.0
    probability: float = 0.01
    told: int = 3

    @property
    def penalty(self) -> float:
        """-2 log of the prior probability of one outlier."""
        return 2.0 * math.log(1.0 / self.probability)


OUTLIERS = OutlierSettings()


def suspects(residuals: Array, *, noise_known: bool) -> BoolArray:
    """Return which residuals (K, r) are those of single samples far beyond the noise.

    NaN = not measured. They are in units of the noise, or in any if it is not known.
    """
    sizes = np.abs(residuals) / spread(residuals, noise_known=noise_known)
    far = np.nan_to_num(sizes, nan=0.0) > OUTLIERS.limit
    if not far.any():
        return np.asarray(far)
    values = int(np.isfinite(residuals).sum())
    if values < OUTLIERS.values or far.sum() > max(1, int(OUTLIERS.most * values)):
        return np.zeros_like(far)
    single = np.zeros_like(far)
    for column in np.flatnonzero(far.any(axis=0)):
        known = np.flatnonzero(np.isfinite(sizes[:, column]))
        single[known, column] = _single(sizes[known, column], far[known, column])
    return single


def spread(residuals: Array, *, noise_known: bool) -> Array:
    """Return the standard deviations (r,) of residuals (K, r) by their median sizes.

    In units of a noise that is known they are 1 at least; infinite where nothing was measured.
    """
    sizes = [np.abs(column[np.isfinite(column)]) for column in residuals.T]
    found = np.array([np.median(each) / NORMAL_MEDIAN if each.size else np.inf for each in sizes])
    least = 1.0 if noise_known else np.finfo(float).tiny
    return np.asarray(np.maximum(found, least))


def left_out(window: WindowState, found: BoolArray, residuals: Array) -> WindowState:
    """Return the window without outliers (K, r), noted by their residuals (K, r)."""
    unit = spread(residuals, noise_known=window.noise_known)
    t = window.objective.grid.t
    outliers = tuple(
        Outlier(float(t[k]), int(i), float(np.abs(residuals[k, i]) / unit[i]))
        for k, i in np.argwhere(found)
    )
    return replace(window.without(found), outliers=(*window.outliers, *outliers))


class OutlierCount:
    """Counts outliers of successive windows, each sample once however many windows hold it."""

    def __init__(self) -> None:
        self.total = 0
        self._recent: set[tuple[float, int]] = set()

    def note(self, outliers: Sequence[Outlier], start: float) -> None:
        """Count those of a window that starts at `start` (s) and were not counted before."""
        found = {(outlier.time, outlier.output) for outlier in outliers}
        self.total += len(found - self._recent)
        self._recent = {known for known in self._recent | found if known[0] >= start}


def words(outliers: Sequence[Outlier], outputs: Sequence[str]) -> list[str]:
    """Say for each output which samples were left out, if any were."""
    said = []
    for output, name in enumerate(outputs):
        own = sorted((o for o in outliers if o.output == output), key=lambda o: -o.size)
        if not own:
            continue
        largest = ', '.join(f'{o.time:.2f} s ({o.size:.3g} sigma)' for o in own[: OUTLIERS.told])
        count = '1 outlier' if len(own) == 1 else f'{len(own)} outliers'
        more = ' and others' if len(own) > OUTLIERS.told else ''
        said.append(f'{count} of {name} at {largest}{more} left out')
    return said


def _single(sizes: Array, far: BoolArray) -> BoolArray:
    """Return which of the sizes (M,) of successive samples that are `far` out are single ones."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], far, [False]]).astype(np.int8)))
    single = far.copy()
    for first, end in edges.reshape(-1, 2):
        beside = sizes[[i for i in (first - 1, end) if 0 <= i < sizes.size]]
        limit = max(OUTLIERS.beside, OUTLIERS.echo * sizes[first:end].max())
        if end - first > OUTLIERS.longest or (beside > limit).any():
            single[first:end] = False
    return single
