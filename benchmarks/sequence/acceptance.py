"""What was asked, what was measured, and whether it is met."""

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from benchmarks.common import mark, quantiles
from benchmarks.common import table as markdown
from benchmarks.sequence import cost, jumps, rest
from benchmarks.sequence.contestants import OURS
from benchmarks.sequence.information import FIRST, VALUES, Informed
from benchmarks.sequence.scores import (
    alarmed,
    before,
    confidently_wrong,
    coverage,
    windows,
)
from benchmarks.sequence.tables import Cells, difference
from benchmarks.sequence.track import Track
from obs_ros.core.typing import Array

FALSE_ALARMS = 0.005
DRIFT, DRIFT_DEVIATIONS = 0.05, 1.3
ALARM, RIGHT, TIME = 0.95, 0.90, 2.0
NOISE_DIFFERENCE = 0.02
COVERAGE, EFFICIENCY = (0.93, 0.97), 1.05
COST = 2.0


class Limit(NamedTuple):
    """What is asked of clean windows: least coverage, most that are confidently wrong."""

    coverage: float
    wrong: float


LIMITS = {
    'tanks 40 dB': Limit(0.93, 0.02),
    'tanks 20 dB': Limit(0.93, 0.02),
    'tanks 0 dB': Limit(0.90, 0.10),
    'lag': Limit(0.92, 0.01),
}


class Measured(NamedTuple):
    """All that was measured; see the tables."""

    clean: Cells
    rest: Cells
    jumps: Mapping[str, Sequence[Track]]
    hard: Cells
    noise: Mapping[tuple[float, bool], Sequence[Track]]
    information: Mapping[float, Informed]
    cost: Mapping[str, Mapping[str, Array]]


Line = tuple[str, str, bool]


def table(measured: Measured) -> str:
    """Tell of every line whether it is met, by the value itself: margins excuse nothing."""
    lines = [
        *_clean(measured), *_rest(measured), *_jumps(measured), *_noise(measured),
        *_information(measured), *_cost(measured),
    ]  # fmt: skip
    return markdown(('asked', 'measured', 'met'), [(*line[:2], mark(line[2])) for line in lines])


def _clean(measured: Measured) -> Iterator[Line]:
    for (cell, contestant), own in measured.clean.items():
        if contestant != OURS:
            continue
        limit = next(value for name, value in LIMITS.items() if cell.startswith(name))
        for what, label in (('p', 'parameters'), ('x', 'end state')):
            value = coverage(own, what)
            asked = f'{cell}: coverage of {label} >= {limit.coverage:g}'
            yield asked, f'{value} of {windows(own)}', value.value >= limit.coverage
        wrong = confidently_wrong(own)
        yield f'{cell}: cw <= {limit.wrong:g}', str(wrong), wrong.value <= limit.wrong
    own = [track for (_, who), tracks in measured.clean.items() if who == OURS for track in tracks]
    own += [before(track) for tracks in measured.jumps.values() for track in tracks]
    value = alarmed(own)
    alarms = int(sum(np.sum(track.alarms > 0) for track in own))
    yield (
        f'false jump alarms <= {100.0 * FALSE_ALARMS:g} % (clean windows, and those before jumps)',
        f'{alarms} of {windows(own)}: {100.0 * value.value:.2f} ± {100.0 * value.margin:.2f} %',
        value.value <= FALSE_ALARMS,
    )


def _rest(measured: Measured) -> Iterator[Line]:
    for (cell, contestant), own in measured.rest.items():
        if contestant != OURS or cell.startswith('tanks 0 dB'):
            continue
        found = rest.worst(own)
        for what, values, limit in (
            ('boxes', found.box, DRIFT), ('sd', found.deviations, DRIFT_DEVIATIONS),
        ):  # fmt: skip
            yield (
                f'{cell}: drift of every run <= {limit:g} {what}',
                f'median {values[0]:.3f}, 95 % {values[1]:.3f}, most {values[2]:.3f}',
                bool(values[2] <= limit),
            )


def _jumps(measured: Measured) -> Iterator[Line]:
    for cell, tracks in measured.jumps.items():
        if not cell.startswith('tanks 20 dB'):
            continue
        found = [jumps.found(track) for track in tracks]
        for what, label, limit in (
            ('alarm', 'alarm in the first window after a jump', ALARM),
            ('right', 'right set', RIGHT),
        ):
            value = jumps.part(found, what)
            yield f'{cell}: {label} >= {limit:g}', f'{value} of {len(found)}', value.value >= limit
        errors = jumps.time_errors(found)
        if errors:
            median, high = quantiles(errors)
            told = f'median {median:.2f}, 95 % {high:.2f}, most {max(errors):.1f} s'
            yield f'{cell}: time error <= {TIME:g} s in 95 %', told, high <= TIME


def _noise(measured: Measured) -> Iterator[Line]:
    for factor in sorted({factor for factor, _ in measured.noise if factor != 1.0}):
        values = [difference(measured.noise, factor, True, what) for what in ('p', 'x')]
        yield (
            f'noise given x {factor:g}, learned: coverage within {NOISE_DIFFERENCE:g} of x 1',
            f'parameters {values[0]:+.3f}, end state {values[1]:+.3f}',
            max(map(abs, values)) <= NOISE_DIFFERENCE,
        )


def _information(measured: Measured) -> Iterator[Line]:
    low, high = COVERAGE
    for snr, own in measured.information.items():
        own = own.only(np.arange(len(own.error)) < FIRST)
        covered, (ratios, margins) = own.coverage, own.efficiency
        least, most = int(covered.argmin()), int(covered.argmax())
        yield (
            f'{snr:g} dB, {len(own.error)} windows alone: coverage of each value {low} to {high}',
            f'{VALUES[least]} {covered[least]:.3f} to {VALUES[most]} {covered[most]:.3f}',
            bool(low <= covered[least] and covered[most] <= high),
        )
        worst = int(ratios.argmax())
        yield (
            f'{snr:g} dB, alone: RMSE over Cramér-Rao bound <= {EFFICIENCY:g}',
            f'at most {ratios[worst]:.3f} ± {margins[worst]:.3f} ({VALUES[worst]})',
            bool(ratios[worst] <= EFFICIENCY),
        )


def _cost(measured: Measured) -> Iterator[Line]:
    for cell, times in measured.cost.items():
        for way in (cost.BARE, cost.PLAIN):
            value = cost.ratio(times, way)
            yield f'{cell}: time over {way} <= {COST:g}', f'{value:.2f}', value <= COST
