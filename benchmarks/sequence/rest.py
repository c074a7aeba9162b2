"""Table 2: whether estimates stay where they are when nothing happens any more."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from benchmarks.report import slashed
from benchmarks.report import table as markdown
from benchmarks.sequence.scores import confidently_wrong, coverage, share, withheld
from benchmarks.sequence.track import Track
from obs_ros.core.typing import Array, BoolArray

ABRUPT = 0.2


class Drift(NamedTuple):
    """The drift of the parameters of one run, over the windows that lie wholly in the rest.

    `box` and `deviations` (q,) are the last estimate less the first, in boxes and in the standard
    deviation that was the last published (not withheld) by then; `steps` (W - 1, q) those from
    window to window, in the last published before each.
    """

    box: Array
    deviations: Array
    steps: Array


def drift(track: Track) -> Drift:
    """Measure one run."""
    inside = np.flatnonzero(track.begin >= track.event)
    published = latest(track.p_sd)
    p = track.p[inside]
    moved = np.abs(p[-1] - p[0])
    steps = np.abs(np.diff(p, axis=0)) / published[inside[:-1]]
    return Drift(moved, moved / published[inside[0]], steps)


def latest(deviations: Array) -> Array:
    """Return for every window the newest (W, q) that was published; infinite before the first."""
    seen = np.full(deviations.shape[1], np.inf)
    rows = []
    for row in deviations:
        seen = np.where(np.isfinite(row), row, seen)
        rows.append(seen)
    return np.array(rows)


class Worst(NamedTuple):
    """Drift over all runs, of the parameter that moves most: median, 95 % and most."""

    box: Array
    deviations: Array
    large_steps: float  # share of steps above the last published standard deviation
    largest_step: float


def worst(tracks: Sequence[Track]) -> Worst:
    """Sum up several runs."""
    drifts = [drift(track) for track in tracks]
    steps = np.concatenate([each.steps for each in drifts])
    levels = (0.5, 0.95, 1.0)
    return Worst(
        np.quantile([each.box.max() for each in drifts], levels),
        np.quantile([each.deviations.max() for each in drifts], levels),
        float(np.mean(steps > 1.0)),
        float(steps.max()),
    )


def abrupt(track: Track) -> tuple[BoolArray, BoolArray]:
    """Return where (W, q) a standard deviation is far below its median over the run, and all."""
    given = np.isfinite(track.p_sd)
    usual = [
        np.median(column[known]) if known.any() else np.nan
        for column, known in zip(track.p_sd.T, given.T, strict=True)
    ]
    return track.p_sd < ABRUPT * np.array(usual), given


def table(tracks: Mapping[tuple[str, str], Sequence[Track]]) -> str:
    """Tell of every cell and contestant."""
    rows = []
    for (cell, contestant), own in tracks.items():
        each = worst(own)
        resting = [track.only(track.begin >= track.event) for track in own]
        rows.append({
            'rest': cell,
            'contestant': contestant,
            'windows': sum(len(track.end) for track in resting),
            'drift, boxes: median / 95 % / most of the runs': slashed(each.box, '.3f'),
            'drift, sd: median / 95 % / most': slashed(each.deviations),
            'steps > 1 sd': f'{each.large_steps:.3f}',
            'largest step, sd': f'{each.largest_step:.2f}',
            'coverage p': coverage(resting, 'p'),
            'coverage end state': coverage(resting, 'x'),
            'cw': confidently_wrong(resting),
            'withheld p': f'{withheld(resting, "p").value:.3f}',
            'sd < 1/5 of its median': f'{share(resting, abrupt).value:.3f}',
        })  # fmt: skip
    return markdown(rows)
