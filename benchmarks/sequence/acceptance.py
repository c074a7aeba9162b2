"""The requirements on windows in sequence."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from benchmarks.report import Requirement, quantiles
from benchmarks.sequence import cost, jumps, rest
from benchmarks.sequence.contestants import OURS
from benchmarks.sequence.information import FIRST, VALUES
from benchmarks.sequence.run import Measured
from benchmarks.sequence.scores import alarmed, before, confidently_wrong, coverage, windows
from benchmarks.sequence.tables import difference

FALSE_ALARMS = 0.005
DRIFT, DRIFT_DEVIATIONS = 0.05, 1.3
ALARM, RIGHT, TIME = 0.97, 0.98, 2.0
MEDIAN_TIME = 0.5
NOISE_DIFFERENCE = 0.02
COVERAGE, EFFICIENCY = (0.93, 0.97), 1.05
COST = 2.0


class Limit(NamedTuple):
    """The least coverage asked of clean windows, and the most that may be confidently wrong."""

    coverage: float
    wrong: float


LIMITS = {
    'tanks 40 dB': Limit(0.93, 0.02),
    'tanks 20 dB': Limit(0.93, 0.02),
    'tanks 0 dB': Limit(0.90, 0.10),
    'lag': Limit(0.92, 0.01),
}


def asked(measured: Measured) -> list[Requirement]:
    """Judge all that was measured."""
    return [
        *_clean(measured), *_rest(measured), *_jumps(measured), *_noise(measured),
        *_information(measured), *_cost(measured),
    ]  # fmt: skip


def _clean(measured: Measured) -> Iterator[Requirement]:
    for (cell, contestant), own in measured.clean.items():
        if contestant != OURS:
            continue
        limit = next(value for name, value in LIMITS.items() if cell.startswith(name))
        for what, label in (('p', 'parameters'), ('x', 'end state')):
            value = coverage(own, what)
            claim = f'{cell}: coverage of {label} >= {limit.coverage:g}'
            told = f'{value} of {windows(own)}'
            yield Requirement(claim, told, value.value >= limit.coverage)
        wrong = confidently_wrong(own)
        claim = f'{cell}: cw <= {limit.wrong:g}'
        yield Requirement(claim, str(wrong), wrong.value <= limit.wrong)
    own = [track for (_, who), tracks in measured.clean.items() if who == OURS for track in tracks]
    own += [before(track) for tracks in measured.jumps.values() for track in tracks]
    value = alarmed(own)
    alarms = int(sum(np.sum(track.alarms > 0) for track in own))
    yield Requirement(
        f'false jump alarms <= {100.0 * FALSE_ALARMS:g} % (clean windows, and those before jumps)',
        f'{alarms} of {windows(own)}: {100.0 * value.value:.2f} ± {100.0 * value.margin:.2f} %',
        value.value <= FALSE_ALARMS,
    )


def _rest(measured: Measured) -> Iterator[Requirement]:
    for (cell, contestant), own in measured.rest.items():
        if contestant != OURS or cell.startswith('tanks 0 dB'):
            continue
        found = rest.worst(own)
        for what, values, limit in (
            ('boxes', found.box, DRIFT), ('sd', found.deviations, DRIFT_DEVIATIONS),
        ):  # fmt: skip
            yield Requirement(
                f'{cell}: drift of every run <= {limit:g} {what}',
                f'median {values[0]:.3f}, 95 % {values[1]:.3f}, most {values[2]:.3f}',
                bool(values[2] <= limit),
            )


def _jumps(measured: Measured) -> Iterator[Requirement]:
    for cell, tracks in measured.jumps.items():
        if not cell.startswith('tanks 20 dB'):
            continue
        found = [jumps.found(track) for track in tracks]
        for what, label, limit in (
            ('alarm', 'alarm in the first window after a jump', ALARM),
            ('right', 'right set', RIGHT),
        ):
            value = jumps.part(found, what)
            claim, told = f'{cell}: {label} >= {limit:g}', f'{value} of {len(found)}'
            yield Requirement(claim, told, value.value >= limit)
        errors = jumps.time_errors(found)
        if errors:
            median, high = quantiles(errors)
            told = f'median {median:.2f}, 95 % {high:.2f}, most {max(errors):.1f} s'
            yield Requirement(f'{cell}: time error <= {TIME:g} s in 95 %', told, high <= TIME)
            claim = f'{cell}: median time error <= {MEDIAN_TIME:g} s'
            yield Requirement(claim, f'{median:.2f} s', median <= MEDIAN_TIME)


def _noise(measured: Measured) -> Iterator[Requirement]:
    for factor in sorted({factor for factor, _ in measured.noise if factor != 1.0}):
        values = [difference(measured.noise, factor, True, what) for what in ('p', 'x')]
        yield Requirement(
            f'noise given x {factor:g}, learned: coverage within {NOISE_DIFFERENCE:g} of x 1',
            f'parameters {values[0]:+.3f}, end state {values[1]:+.3f}',
            max(map(abs, values)) <= NOISE_DIFFERENCE,
        )


def _information(measured: Measured) -> Iterator[Requirement]:
    low, high = COVERAGE
    for snr, own in measured.information.items():
        own = own.only(np.arange(len(own.error)) < FIRST)
        covered, (ratios, margins) = own.coverage, own.efficiency
        least, most = int(covered.argmin()), int(covered.argmax())
        yield Requirement(
            f'{snr:g} dB, {len(own.error)} windows alone: coverage of each value {low} to {high}',
            f'{VALUES[least]} {covered[least]:.3f} to {VALUES[most]} {covered[most]:.3f}',
            bool(low <= covered[least] and covered[most] <= high),
        )
        worst = int(ratios.argmax())
        yield Requirement(
            f'{snr:g} dB, alone: RMSE over Cramér-Rao bound <= {EFFICIENCY:g}',
            f'at most {ratios[worst]:.3f} ± {margins[worst]:.3f} ({VALUES[worst]})',
            bool(ratios[worst] <= EFFICIENCY),
        )


def _cost(measured: Measured) -> Iterator[Requirement]:
    for cell, times in measured.cost.items():
        for way in (cost.BARE, cost.PLAIN):
            value = cost.ratio(times, way)
            claim = f'{cell}: time over {way} <= {COST:g}'
            yield Requirement(claim, f'{value:.2f}', value <= COST)
