"""How published values follow those of the same windows alone."""

from collections.abc import Sequence

import numpy as np

from benchmarks.mismatch.run import Followed
from obs_ros.core.typing import Array, BoolArray

SDS = 3.0  # deviations, of nearness
STILL, MOVED = 1e-3, 1.0  # deviations, from window to window
LAG, CYCLES = 4, 0.5  # windows, and the correlation that is a cycle


def nearness(runs: Sequence[Followed], *, larger: bool = False) -> tuple[int, int]:
    """Count the values within SDS of those alone, and all that both determine.

    In published deviations, or in the `larger` of the two: a window alone may know much less.
    """
    near, count = 0, 0
    for run in runs:
        sd = np.fmax(run.sd, run.alone_sd) if larger else run.sd
        told = np.isfinite(run.sd) & np.isfinite(run.alone_sd)
        near += int((np.abs(run.values - run.alone) <= SDS * sd)[told].sum())
        count += int(told.sum())
    return near, count


def frozen(run: Followed) -> int:
    """Count the times that a parameter stays in three windows while those alone move.

    One step of two windows may be so short by chance.
    """
    sd = scale(run)[1:]
    still = np.abs(np.diff(run.values, axis=0)) < STILL * sd
    still &= np.abs(np.diff(run.alone, axis=0)) > MOVED * sd
    return int((still[1:] & still[:-1]).sum())


def scale(run: Followed) -> Array:
    """Return published deviations (W, q), and for those withheld the scatter of values alone."""
    return np.asarray(np.where(np.isfinite(run.sd), run.sd, run.alone.std(axis=0)))


def cycles(run: Followed) -> BoolArray:
    """Tell of which parameters (q,) the difference to those alone comes back every LAG windows."""
    off = run.values - run.alone
    off = off - off.mean(axis=0)
    power = (off**2).mean(axis=0)
    back = (off[LAG:] * off[:-LAG]).mean(axis=0)
    return np.asarray(back > CYCLES * np.where(power > 0.0, power, np.inf))
