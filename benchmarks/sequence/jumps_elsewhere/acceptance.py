"""The requirements on jumps on plants that nobody has tuned to."""

from collections.abc import Iterator

import numpy as np

from benchmarks.report import Requirement
from benchmarks.sequence.jumps_elsewhere import scores
from benchmarks.sequence.jumps_elsewhere.cost import ratio
from benchmarks.sequence.jumps_elsewhere.follow import FARTHEST
from benchmarks.sequence.jumps_elsewhere.judged import How, after, false_jumps, settled, told
from benchmarks.sequence.jumps_elsewhere.rates import clustered
from benchmarks.sequence.jumps_elsewhere.run import Measured
from benchmarks.sequence.jumps_elsewhere.scenes import BESIDE, CLEAN, JUMP
from benchmarks.sequence.jumps_elsewhere.tables import pooled

OVERALL, POOR, MISNAMED = (0.92, 0.98), (0.90, 0.98), 0.90
FARTHER, ENOUGH, ENOUGH_MISNAMED = 0.002, 4000, 200  # share of windows; windows
SD, RMS = 1.15, 1.05
EXACT, INEXACT = 0.005, 0.03
WITH_JUMP = 1.5
EXACT_KINDS = {'white noise': (CLEAN, JUMP), 'coloured noise': ('coloured noise',)} | {
    't3 noise': ('t3 noise',)
}
INEXACT_KINDS = ('unmodelled 5 %', 'unmodelled 10 %', 'oscillating')


def asked(measured: Measured) -> list[Requirement]:
    """Judge all that was measured."""
    return [*_covered(measured), *_sharp(measured), *_false(measured), *_cost(measured)]


def _covered(measured: Measured) -> Iterator[Requirement]:
    every, poor = pooled(measured.cells, [JUMP]), pooled(measured.cells, [JUMP], rich=False)
    for label, runs, (low, high) in (
        ('jumps of 15-40 %', every, OVERALL), ('the same, poor excitation', poor, POOR),
    ):  # fmt: skip
        value = scores.coverage(runs)
        yield Requirement(
            f'{label}: coverage of accepted windows {low:g} to {high:g}',
            f'{value} of {scores.count(runs)} windows',
            low <= value.value <= high,
        )

    def misnamed(run: scores.Followed) -> scores.BoolArray:
        return after(run, (How.LISTED, How.MISNAMED))

    value, windows = scores.coverage(every, misnamed), scores.count(every, misnamed)
    yield Requirement(
        f'coverage after misnamed jumps >= {MISNAMED:g}, in >= {ENOUGH_MISNAMED} windows',
        f'{value} of {windows} windows',
        bool(value.value >= MISNAMED and windows >= ENOUGH_MISNAMED),
    )
    for label, chosen in (
        ('', scores.everywhere),
        (', but for those that end within a sixth of a window after a jump', settled),
        (', but for those before any test could tell of the jump', told),
    ):
        value, windows = scores.beyond(every, FARTHEST, chosen), scores.count(every, chosen)
        yield Requirement(
            f'any error > 5 sd in < {100.0 * FARTHER:g} % of >= {ENOUGH} accepted windows{label}',
            f'{value.hits} of {windows}: {value}',
            bool(value.value < FARTHER and windows >= ENOUGH),
        )


def _sharp(measured: Measured) -> Iterator[Requirement]:
    if not measured.theirs:
        return
    ours = [run for cell in measured.theirs for run in measured.cells[cell]]
    theirs = [run for own in measured.theirs.values() for run in own]
    found = scores.sharpness(ours, theirs)
    for label, value, most in (('median sd', found.sd, SD), ('RMS error', found.rms, RMS)):
        yield Requirement(
            f'where one hypothesis is sure: {label} <= {most:g} x that of the other tree',
            '{:.3f} ({:.3f}-{:.3f})'.format(*value) + f', {found.values} values',
            bool(value[0] <= most),
        )


def _false(measured: Measured) -> Iterator[Requirement]:
    limits = {label: (kinds, EXACT) for label, kinds in EXACT_KINDS.items()}
    limits |= {kind: ((kind,), INEXACT) for kind in INEXACT_KINDS}
    for label, (kinds, most) in limits.items():
        value = scores.alarmed(pooled(measured.cells, kinds))
        yield Requirement(
            f'{label}: false jumps in <= {100.0 * most:g} % of windows',
            f'{value.hits} of {value.count}: {value}',
            bool(value.value <= most),
        )
    value = spoiled_alarms(measured)
    yield Requirement(
        'windows with a single outlier of 10 sd: no false jump',
        f'{value.hits} of {value.count}: {value}',
        bool(value.count and not value.hits),
    )


def spoiled_alarms(measured: Measured) -> scores.Rate:
    """Return the share of windows with an outlier that announce a jump which is none."""
    pairs = []
    for run in pooled(measured.cells, ['outliers', BESIDE]):
        wrong = np.zeros(len(run.end), dtype=np.bool_)
        wrong[[each.window for each in false_jumps(run)]] = True
        pairs.append(((wrong & run.spoiled).sum(), run.spoiled.sum()))
    return clustered(pairs)


def _cost(measured: Measured) -> Iterator[Requirement]:
    if not measured.times:
        return
    with_jump, without = (ratio(measured.times, jumped) for jumped in (True, False))
    yield Requirement(
        f'time of a window with a jump <= {WITH_JUMP:g} x that of the other tree',
        '{:.3f} ({:.3f}-{:.3f})'.format(*with_jump),
        bool(with_jump[0] <= WITH_JUMP),
    )
    yield Requirement(
        'time of a window without: no more, as far as the interval tells',
        '{:.3f} ({:.3f}-{:.3f})'.format(*without),
        bool(without[1] <= 1.0),
    )
