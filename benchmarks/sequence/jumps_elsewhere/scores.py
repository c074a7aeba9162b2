"""Shares of windows and values, over runs."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from benchmarks.sequence.jumps_elsewhere.follow import Followed
from benchmarks.sequence.jumps_elsewhere.judged import announcements, calm
from benchmarks.sequence.jumps_elsewhere.rates import Rate, clustered, resampled, stacked
from obs_ros.core.typing import Array, BoolArray

Runs = Sequence[Followed]
Chosen = Callable[[Followed], BoolArray]  # windows (W,) of a run

SURE = 0.95  # of the weight, that one hypothesis has
FAR = 3.0  # deviations


def everywhere(run: Followed) -> BoolArray:
    """Choose all windows (W,)."""
    return np.ones(len(run.end), dtype=np.bool_)


def given(run: Followed, chosen: Chosen = everywhere) -> BoolArray:
    """Return the values (W, q + n) with an interval, in the accepted ones of the windows chosen."""
    return np.isfinite(run.upper) & np.isfinite(run.lower) & (run.accepted & chosen(run))[:, None]


def values_of(run: Followed, what: str) -> slice:
    """Return the places of parameters, of end states or of all."""
    q = len(run.scene.experiment.model.parameters)
    return {'p': slice(q), 'x': slice(q, None), 'all': slice(None)}[what]


def coverage(runs: Runs, chosen: Chosen = everywhere, what: str = 'all') -> Rate:
    """Return the share of intervals in accepted windows that hold the truth."""
    pairs = []
    for run in runs:
        part = values_of(run, what)
        counted = given(run, chosen)[:, part]
        held = (run.lower <= 0.0)[:, part] & (run.upper >= 0.0)[:, part]
        pairs.append(((held & counted).sum(), counted.sum()))
    return clustered(pairs)


def beyond(runs: Runs, deviations: float, chosen: Chosen = everywhere) -> Rate:
    """Return the share of accepted windows in which some error is beyond so many deviations."""
    pairs = []
    for run in runs:
        wrong = ((run.beyond > deviations) & given(run, chosen)).any(axis=1)
        pairs.append((wrong.sum(), accepted(run, chosen).sum()))
    return clustered(pairs)


def accepted(run: Followed, chosen: Chosen = everywhere) -> BoolArray:
    """Return the accepted windows (W,) among those chosen."""
    return np.asarray(run.accepted & chosen(run))


def count(runs: Runs, chosen: Chosen = everywhere) -> int:
    """Count the accepted windows."""
    return sum(int(accepted(run, chosen).sum()) for run in runs)


def pushed(runs: Runs, chosen: Chosen = everywhere) -> Rate:
    """Return the share of accepted windows that process noise explains."""
    pairs = [
        ((run.pushed & accepted(run, chosen)).sum(), accepted(run, chosen).sum()) for run in runs
    ]  # fmt: skip
    return clustered(pairs)


def withheld(runs: Runs) -> Rate:
    """Return the share of values without an interval, of all windows."""
    return clustered([((~given(run)).sum(), run.error.size) for run in runs])


def alarmed(runs: Runs, chosen: Chosen = calm) -> Rate:
    """Return the share of windows that announce a jump where nothing has jumped."""
    pairs = []
    for run in runs:
        mask = chosen(run)
        windows = {each.window for each in announcements(run) if mask[each.window]}
        pairs.append((len(windows), mask.sum()))
    return clustered(pairs)


def sure(run: Followed) -> BoolArray:
    """Return the accepted windows (W,) in which no jump has a rival."""
    clear = [
        all(not one.alternatives and not one.probability < SURE for one in said)
        for said in run.said
    ]  # fmt: skip
    return np.asarray(run.accepted & np.array(clear))


class Sharpness(NamedTuple):
    """Of values that both trees give and are sure of: ours over theirs, with intervals.

    `sd` is the median of the ratios of deviations, `rms` the geometric mean over the values of a
    plant of the ratios of their root mean square errors.
    """

    sd: tuple[float, float, float]
    rms: tuple[float, float, float]
    values: int


def sharpness(ours: Runs, theirs: Runs) -> Sharpness:
    """Compare the same runs, by two source trees."""
    both = [
        given(a, sure) & given(b, sure) for a, b in zip(ours, theirs, strict=True)
    ]  # fmt: skip
    ratios = [
        (a.deviations / np.maximum(b.deviations, 1e-12))[mask]
        for a, b, mask in zip(ours, theirs, both, strict=True)
    ]
    squares = [
        _squares(a, b, mask) for a, b, mask in zip(ours, theirs, both, strict=True)
    ]  # fmt: skip
    keys = [(run.scene.plant, run.scene.rich) for run in ours]

    def rms(places: Sequence[int]) -> float:
        sums: dict[tuple[str, bool], Array] = {}
        for i in places:
            sums[keys[i]] = sums.get(keys[i], 0.0) + squares[i]
        told = np.concatenate([s[:, s[2] > 0] for s in sums.values()], axis=1)
        return float(np.exp(0.5 * np.mean(np.log(told[0] / told[1]))))

    def sd(places: Sequence[int]) -> float:
        return float(np.median(stacked(ratios, places)))

    return Sharpness(
        resampled(sd, len(ours)), resampled(rms, len(ours)), int(sum(m.sum() for m in both))
    )


def _squares(a: Followed, b: Followed, mask: BoolArray) -> Array:
    """Return squared errors of both, and counts, (3, q + n)."""
    sums = [np.where(mask, each.error**2, 0.0).sum(axis=0) for each in (a, b)]
    return np.array([*sums, mask.sum(axis=0)])
