"""Coarse and saturated sensors, actuators that saturate, and a recording in whole degrees."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benchmarks.recordings import OVERLAP, PLANTS, recorded
from benchmarks.report import Requirement, table
from benchmarks.sensors.attempts import attempted, carried_out, failures, judged
from benchmarks.sensors.scores import accepted, coverage, rms_ratio, words
from benchmarks.sensors.solved import Solved, alone
from benchmarks.sensors.spring import NOISE, SPRING, declared, run
from obs_ros import Record, Sample
from obs_ros.observers.base import load_observer
from plant_sim.actuators import Actuator
from plant_sim.sensors import Sensor

WINDOWS = 10  # of each run of a cell
STEP = 4.0 / 255.0  # m: 8 bits for +-2 m, 4 standard deviations of the noise
LIMITS = (-0.3, 0.3)  # m, beyond which the positions are for a third of the time
FORCES = (-5.0, 5.0)  # m/s2, of 8
COVERED, LEAST_ACCEPTED = (0.92, 0.97), 0.9
AS_GOOD = 1.01  # times the error of a model that is told what acts
BOARD, DEGREE = 'heater board', 1.0  # degC


class Kind(NamedTuple):
    """A sensor or an actuator that is not perfect, and what is declared of it."""

    sensor: Sensor | None
    actuator: Actuator | None
    output: Mapping[str, Any]
    input: Mapping[str, Any]


KINDS: Mapping[str, Kind] = {
    'clean': Kind(None, None, {}, {}),
    '8-bit converter': Kind(Sensor(resolution=STEP), None, {'resolution': STEP}, {}),
    'saturating sensor': Kind(Sensor(range=LIMITS), None, {'range': LIMITS}, {}),
    '8 bits, saturating': Kind(
        Sensor(resolution=STEP, range=LIMITS), None, {'resolution': STEP, 'range': LIMITS}, {}
    ),
    'saturating actuator': Kind(None, Actuator(range=FORCES), {}, {'range': FORCES}),
    'told what acts': Kind(None, Actuator(range=FORCES), {}, {}),
}
SENSORS = ('8-bit converter', 'saturating sensor', '8 bits, saturating')
KNOWN = {'noise given': True, 'noise learned': False}


def window(kind: str, known: bool, seed: int) -> Solved:
    """Solve a window with a sensor or actuator that is declared."""
    chosen = KINDS[kind]
    drawn = run(seed, sensor=chosen.sensor, actuator=chosen.actuator)
    plain = not chosen.output and not chosen.input
    model = SPRING if plain else declared(chosen.output, chosen.input)
    noise = {'noise': {'y': NOISE}} if known else {}
    record = drawn.record
    if kind == 'told what acts':
        record = Record(record.t, np.clip(record.u, *FORCES), record.y)
    return alone(model, record, drawn.truth, seed, **noise)


class Board(NamedTuple):
    """The windows of the heater board, rounded: outcomes, values lost as stuck, of so many."""

    outcomes: tuple[str, ...]
    stuck: int
    values: int


def board(folder: str, declares: bool) -> Board:
    """Solve the windows of the heater board, rounded to whole degrees, as a node does."""
    plant, whole = PLANTS[BOARD], recorded(BOARD, Path(folder))
    model = plant.model
    if declares:
        outputs = [replace(v, resolution=DEGREE) for v in model.outputs]
        model = replace(model, outputs=outputs)
    sliding: Any = load_observer('sliding_window')
    observer = sliding(model, duration=plant.window, period=plant.window / OVERLAP)
    observer.prepare()
    outcomes = []
    y = DEGREE * np.round(whole.y / DEGREE)
    for t, u, values in zip(whole.t, whole.u, y, strict=True):
        if observer.absorb(Sample(round(t * 1e9), y=values, u=u)):
            outcomes.append(observer.estimate().outcome.value)
    return Board(tuple(outcomes), observer.counts['stuck'], y.size)


def measured(runs: int, seed: int, folder: Path) -> tuple[list[Requirement], str]:
    """Solve so many runs of windows of each kind, and the recording; return rows and tables."""
    for kind in ('clean', 'saturating sensor', 'saturating actuator'):
        attempted(window, kind, True, seed)  # compiles here, so that workers find it cached
    seeds = range(seed, seed + WINDOWS * runs)
    cells = carried_out(
        window, {(kind, words_of_it): [(kind, known, each) for each in seeds] for kind in KINDS
                 for words_of_it, known in KNOWN.items()}, 'coarse sensors',
    )  # fmt: skip
    boards: Mapping[bool, list[Any]] = {}
    if (folder / PLANTS[BOARD].file).is_file():
        boards = carried_out(
            board, {declares: [(str(folder), declares)] for declares in (True, False)}, 'board'
        )
    return [*_rows(cells), *_board(boards)], '\n\n'.join((_table(cells), _boards(boards)))


def _rows(cells: Mapping[tuple[str, str], list[Any]]) -> Iterator[Requirement]:
    for (kind, known), own in cells.items():
        if kind in SENSORS:
            asked = f'{kind}, {known}: coverage {COVERED[0]:g}-{COVERED[1]:g}'
            yield judged(asked, own, _covers)
            asked = f'{kind}, {known}: >= {LEAST_ACCEPTED:.0%} of windows accepted'
            yield judged(asked, own, _accepts)
        elif kind == 'saturating actuator':
            told = cells['told what acts', known]

            def ratio(_: list[Any], own: Any = own, told: Any = told) -> tuple[str, bool]:
                found = rms_ratio(own, told)
                return words(found), found[0] <= AS_GOOD

            asked = f'{kind}, {known}: RMS error <= {AS_GOOD:g} x that of a model told what acts'
            yield judged(asked, [*own, *told], ratio)


def _covers(own: list[Any]) -> tuple[str, bool]:
    found = coverage(own)
    return words(found), COVERED[0] <= found[0] <= COVERED[1]


def _accepts(own: list[Any]) -> tuple[str, bool]:
    found = accepted(own)
    return words(found, '.2f'), found[0] >= LEAST_ACCEPTED


def _board(boards: Mapping[bool, list[Any]]) -> Iterator[Requirement]:
    def free(own: list[Any]) -> tuple[str, bool]:
        values = sum(one.stuck for one in own)
        windows = sum(one.outcomes.count('stale_output') for one in own)
        said = f'{values} of {own[0].values} values, {windows} of {len(own[0].outcomes)} windows'
        return said, values == windows == 0

    for declares, own in boards.items():
        what = 'declared' if declares else 'learned from the grid'
        yield judged(f'{BOARD} in whole degrees, {what}: nothing is lost as stuck', own, free)


def _table(cells: Mapping[tuple[str, str], list[Any]]) -> str:
    rows = []
    for (kind, known), own in cells.items():
        clean = cells['clean', known]
        if not failures([*own, *clean]):
            rows.append({
                'sensor or actuator': kind, 'noise': known.removeprefix('noise '),
                'windows': len(own), 'accepted': words(accepted(own), '.2f'),
                'coverage': words(coverage(own)), 'RMS / clean': words(rms_ratio(own, clean)),
                'ms': f'{1e3 * np.median([one.seconds for one in own]):.1f}',
            })  # fmt: skip
    return table(rows)


def _boards(boards: Mapping[bool, list[Any]]) -> str:
    return table(
        {
            'heater board': 'declared' if declares else 'not declared',
            'windows': len(one.outcomes),
            'outcomes': ', '.join(f'{n} {one.outcomes.count(n)}' for n in sorted({*one.outcomes})),
            'values lost as stuck': one.stuck,
        }
        for declares, own in boards.items()
        for one in own
        if not failures([one])
    )
