"""The runs that are solved, and by whom."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from benchmarks.runner import monte_carlo
from benchmarks.sequence.contestants import CONTESTANTS, OURS
from benchmarks.sequence.cost import costs
from benchmarks.sequence.information import Informed, informed, pooled
from benchmarks.sequence.plants import PLANTS
from benchmarks.sequence.scenes import Scene, run_of
from benchmarks.sequence.track import Cells, Track, tracked
from obs_ros.core.typing import Array
from obs_ros.integration.backends import kernels_for

SNRS = (40.0, 20.0, 0.0)
LAG_SNR = 0.0  # its noise is fixed
LONG, SHORT = 20, 5  # window lengths of a clean run, with abutting and with overlapping windows
REST, JUMP, HARD = 8, 6, 15
LONG_RAMP = 'ramp over 10 windows'
RESTS = (
    ('tanks', 40.0, 'rest'), ('tanks', 20.0, 'rest'), ('tanks', 0.0, 'rest'),
    ('tanks', 20.0, 'rest, Q1 = 0'), ('lag', LAG_SNR, 'rest'),
)  # fmt: skip
SURPRISES = {
    'ramp over 3 windows': 10, LONG_RAMP: HARD, 'two jumps, two parameters': 7,
    'two jumps, one parameter': 7, 'noise x 3 from half way': 8, '10 % outliers': SHORT,
    'wrong tank area': SHORT, 'wrong pipe area': SHORT,
}  # fmt: skip
FACTORS = (1.0, 0.5, 2.0, 10.0)
PER_CHUNK = 20
INFORMATION_SNRS = (40.0, 20.0)
PER_CELL = 400  # windows: what the numbers of runs below are for
REST_RUNS, JUMP_RUNS, HARD_RUNS, NOISE_RUNS, COST_RUNS = 15, 96, 10, 24, 8
ALONE = 2000


class Measured(NamedTuple):
    """Everything measured; see the tables. `cost` are process times (W,) in s by cell and way."""

    clean: Cells
    rest: Cells
    jumps: Mapping[str, Sequence[Track]]
    hard: Cells
    noise: Mapping[tuple[float, bool], Sequence[Track]]
    information: Mapping[float, Informed]
    cost: Mapping[str, Mapping[str, Array]]


Runs = list[tuple[Any, ...]]  # arguments of `tracked`, or of `informed`


class Plan(NamedTuple):
    """Runs by table and cell."""

    clean: Mapping[tuple[str, str], Runs]
    rest: Mapping[tuple[str, str], Runs]
    jumps: Mapping[str, Runs]
    hard: Mapping[tuple[str, str], Runs]
    noise: Mapping[tuple[float, bool], Runs]
    information: Mapping[float, Runs]


def plan(windows: int, seed: int) -> Plan:
    """Return all runs for about so many windows in each clean cell; the others in proportion."""

    def runs(usual: int) -> range:
        return range(seed, seed + max(2, math.ceil(usual * windows / PER_CELL)))

    cells = [('tanks', snr) for snr in SNRS] + [('lag', LAG_SNR)]
    return Plan(
        clean={
            (f'{label(*cell)}, {_spacing(cell[0], abutting)}', contestant): [
                (Scene(*cell, 'clean', s, length), abutting, contestant)
                for s in runs(math.ceil(PER_CELL / windows_in(cell[0], length, abutting)))
            ]
            for cell in cells
            for abutting, length in ((False, SHORT), (True, LONG))
            for contestant in CONTESTANTS
        },
        rest={
            (label(plant, snr) + kind.removeprefix('rest'), contestant): [
                (Scene(plant, snr, kind, s, REST), False, contestant) for s in runs(REST_RUNS)
            ]
            for plant, snr, kind in RESTS
            for contestant in CONTESTANTS
        },
        jumps={
            label(*cell): [(Scene(*cell, 'jump', s, JUMP), False) for s in runs(JUMP_RUNS)]
            for cell in cells
        },
        hard={
            (kind, f'{snr:g} dB'): [
                (Scene('tanks', snr, kind, s, length), False) for s in runs(HARD_RUNS)
            ]
            for kind, length in SURPRISES.items()
            for snr in SNRS
        },
        noise={
            (factor, learn): [
                (Scene('tanks', 20.0, 'clean', s, SHORT), False, OURS, factor, learn)
                for s in runs(NOISE_RUNS)
            ]
            for learn in (True, False)
            for factor in FACTORS
        },
        information={
            snr: [(snr, range(s, s + PER_CHUNK)) for s in runs(ALONE)[::PER_CHUNK]]
            for snr in INFORMATION_SNRS
        },
    )


def windows_in(plant: str, length: int, abutting: bool) -> int:
    """Return how many windows a run of so many window lengths has."""
    if abutting:
        return length
    return round((length - 1) * PLANTS[plant].duration / PLANTS[plant].period) + 1


def label(plant: str, snr: float) -> str:
    """Return the name of a cell."""
    return f'{plant} {snr:g} dB' if plant == 'tanks' else plant


def _spacing(plant: str, abutting: bool) -> str:
    return 'abutting' if abutting else f'every {PLANTS[plant].period:g} s'


def compile_all(seed: int) -> None:
    """Compile here, once, so that the workers find the kernels cached."""
    for name, plant in PLANTS.items():
        _ = kernels_for(plant.model)
        run = run_of(Scene(name, 20.0, 'clean', seed, 1))
        for contestant in CONTESTANTS.values():
            contestant(run, plant.duration)


def carried_out(chosen: Plan, timed: Mapping[str, Sequence[Scene]]) -> Measured:
    """Do it all on all cores, then time some runs alone."""
    cells = chosen._asdict()
    alone = monte_carlo(informed, cells.pop('information'), 'windows alone')
    runs = {(table, key): own for table, by_key in cells.items() for key, own in by_key.items()}
    # The same run at all noises and for all contestants is simulated anew: that is quick.
    found: dict[str, Any] = {table: {} for table in cells}
    for (table, key), tracks in monte_carlo(tracked, runs, 'sequences').items():
        found[table][key] = tracks
    pooled_alone = {snr: pooled(parts) for snr, parts in alone.items()}
    return Measured(**found, information=pooled_alone, cost=costs(timed))


def timed_scenes(windows: int, seed: int) -> Mapping[str, Sequence[Scene]]:
    """Return the runs that are timed, for about so many windows in each clean cell."""
    seeds = range(seed, seed + max(1, math.ceil(COST_RUNS * windows / PER_CELL)))
    return {
        'tanks 20 dB': [Scene('tanks', 20.0, 'clean', s, SHORT) for s in seeds],
        'lag': [Scene('lag', LAG_SNR, 'clean', s, SHORT) for s in seeds],
        'tanks 20 dB, with a jump': [Scene('tanks', 20.0, 'jump', s, JUMP) for s in seeds],
    }
