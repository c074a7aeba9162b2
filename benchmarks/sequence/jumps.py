"""Table 3: whether a jump is found, when, and with which parameter, time and size."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from benchmarks.report import quantiles, slashed
from benchmarks.report import table as markdown
from benchmarks.sequence.plants import PLANTS
from benchmarks.sequence.scenes import SIZES
from benchmarks.sequence.scores import Share, binomial
from benchmarks.sequence.track import Track
from obs_ros.core.model import names

Tracks = Mapping[str, Sequence[Track]]


class Found(NamedTuple):
    """One jump of `size` boxes, as the windows report it.

    `alarm`: in time, that is in a window that holds at most one period of samples after the jump,
    or in the first that holds more; `delay` counts windows, 1 = the first that holds a sample after
    it, infinite if never. `right`: the first window that holds a period after it reports just that
    parameter; `named`: or has it among its alternatives. `time_error` (s), `time_z` and `size_z`
    (sd) are of that report; NaN where it is not right. `extra` counts further alarms.
    """

    seed: int
    size: float
    alarm: bool
    delay: float
    right: bool
    named: bool
    time_error: float
    time_z: float
    size_z: float
    extra: int


def found(track: Track) -> Found:
    """Judge a run with one jump."""
    plant, (change,) = PLANTS[track.scene.plant], track.changes
    name = names(plant.model.parameters)[change.place]
    size = abs(change.size) / float(plant.width[change.place])
    holding = np.flatnonzero(track.end > change.time)
    due = int(np.flatnonzero(track.end >= change.time + plant.period)[0])
    alarms = holding[track.alarms[holding] > 0]
    jumps = track.jumps[due]
    right = [jump for jump in jumps if set(jump.sizes) == {name}]
    sole = len(jumps) == 1 and bool(right)
    nearest = min(right, key=lambda j: abs(j.time - change.time)) if sole else None
    return Found(
        seed=track.scene.seed,
        size=size,
        alarm=bool(alarms.size) and bool(alarms[0] <= due),
        delay=float(alarms[0] - holding[0] + 1) if alarms.size else np.inf,
        right=sole,
        named=sole or any(name in jump.alternatives for jump in jumps),
        time_error=abs(nearest.time - change.time) if nearest else np.nan,
        time_z=(nearest.time - change.time) / nearest.time_stddev if nearest else np.nan,
        size_z=(nearest.sizes[name] - change.size) / nearest.stddev[name] if nearest else np.nan,
        extra=max(0, int(track.alarms[holding].sum()) - 1),
    )


def part(jumps: Sequence[Found], what: str) -> Share:
    """Return the share of jumps that have a property."""
    value = float(np.mean([getattr(jump, what) for jump in jumps])) if jumps else np.nan
    return Share(value, binomial(value, len(jumps)))


def time_errors(jumps: Sequence[Found]) -> list[float]:
    """Return the errors (s) of the times of those rightly found."""
    return [jump.time_error for jump in jumps if jump.right]


def table(tracks: Tracks) -> str:
    """Tell of every plant and SNR, and of each size class."""
    classes = {'all': (SIZES[0][0], SIZES[-1][1] + 1e-9)}
    classes |= {f'{least:g} to {most:g}': (least, most) for least, most in SIZES}
    return markdown(
        {'plant': cell, 'size (box)': label} | _row(chosen)
        for cell, own in tracks.items()
        for jumps in ([found(track) for track in own],)
        for label, (least, most) in classes.items()
        if (chosen := [jump for jump in jumps if least <= jump.size < most])
    )


def _row(jumps: Sequence[Found]) -> dict[str, object]:
    errors, delays = time_errors(jumps), [jump.delay for jump in jumps]
    late = np.quantile(delays, 0.95, method='higher')
    right = [jump for jump in jumps if jump.right]
    inside = {
        name: np.mean([abs(getattr(jump, name)) <= 2.0 for jump in right]) if right else np.nan
        for name in ('time_z', 'size_z')
    }
    return {
        'jumps': len(jumps),
        'alarm in time': part(jumps, 'alarm'),
        'right set': part(jumps, 'right'),
        'right or alternative': f'{part(jumps, "named").value:.3f}',
        'time error, s: median / 95 %': slashed(quantiles(errors)) if errors else '-',
        'time in 2 sd': f'{inside["time_z"]:.2f}',
        'size in 2 sd': f'{inside["size_z"]:.2f}',
        'windows: median / 95 %': slashed((np.median(delays), late), 'g'),
        'never': sum(np.isinf(delay) for delay in delays),
        'further alarms': sum(jump.extra for jump in jumps),
    }


def missed(tracks: Tracks) -> str:
    """List the jumps without an alarm in time, or with the wrong parameters."""
    lines = []
    for cell, own in tracks.items():
        late = [jump for jump in map(found, own) if not jump.alarm]
        wrong = [jump for jump in map(found, own) if jump.alarm and not jump.right]
        for what, jumps in (('no alarm in time', late), ('wrong set', wrong)):
            told = ', '.join(f'{jump.seed} ({jump.size:.3f})' for jump in jumps)
            if told:
                lines.append(f'- {cell}, {what}: {told}')
    return '\n'.join(lines) or 'None.'
