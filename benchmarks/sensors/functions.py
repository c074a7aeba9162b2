"""Ways of writing a function: the same estimates, and the time of each beside the plain way.

And advice: what no input can tell is said, what moving inputs would tell is not; arguments in a
wrong order are named.
"""

import functools
import re
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from benchmarks.report import Requirement, table
from benchmarks.sensors.attempts import Failure, attempted, judged
from benchmarks.sensors.scores import median_ratio, words
from benchmarks.sensors.solved import Solved, alone
from benchmarks.sensors.spring import forces
from benchmarks.sensors.ways import PLAIN, WAYS, built, dynamics, model, output, swapped
from obs_ros import Model, Record, Variable
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid

INTERVAL, SAMPLES = 0.02, 150  # s
NOISE = 0.005  # m
TRUTH = {'stiffness': 9.0, 'friction': 0.8}  # N/m, N s/m
SAME, TIME = 1e-6, 1.3  # relative difference of values; times the plain way
REPEATS = 3  # of a timed solve, of which the least counts


@functools.cache
def window(seed: int) -> Record:
    """Return a window of the plant under random forces, some beyond its limits."""
    rng = np.random.default_rng([seed, SAMPLES])
    t, signal = INTERVAL * np.arange(SAMPLES), forces(rng, INTERVAL * SAMPLES)
    u = np.array([signal(each) for each in t])
    y = simulated(built(dynamics, output), t, u, [0.5, 0.0], list(TRUTH.values()))
    return Record(t, u, y + NOISE * rng.standard_normal(y.shape))


def simulated(plant: Model, t: Any, u: Any, x0: Any, p: Any) -> Any:
    """Return the exact outputs (K, r) of a plant."""
    blank = Record(t, u, np.zeros((len(t), len(plant.outputs))))
    grid = Grid.of(plant, blank, np.ones(len(plant.outputs)))
    return kernels_for(plant).trajectories(grid, np.c_[x0], np.c_[p])[1][..., 0]


def written(way: str, seed: int) -> Solved:
    """Solve a window with the functions written in a way, as fast as it gets."""
    plant, noise = model(way), {'front': NOISE, 'rear': NOISE}
    found = [alone(plant, window(seed), TRUTH, seed, noise=noise) for _ in range(REPEATS)]
    return min(found, key=lambda one: one.seconds)


def product(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Return the rate of a lag whose gain is a product."""
    return (p[0] * p[1] * u[0] - p[2] * x[0],)


def total(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Return the rate of a lag whose losses add."""
    return (p[2] * u[0] - (p[0] + p[1]) * x[0],)


def two_inputs(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Return the rate of a lag whose two gains differ only while the inputs do."""
    return (p[0] * u[0] + p[1] * u[1] - p[2] * x[0],)


class Case(NamedTuple):
    """A lag that leaves something open: its rate, names of three parameters, number of inputs.

    `says` is what the message and the advice must say, and `never` what they must not.
    """

    rate: Any
    names: tuple[str, str, str]
    inputs: int
    says: str
    never: str


CASES = {
    'a product, a b': Case(
        product, ('a', 'b', 'c'), 1, r'no input can tell a from b|no input can tell b from a',
        'move the inputs|moving them',
    ),
    'a sum, k1 + k2': Case(
        total, ('k1', 'k2', 'g'), 1, r'only k1 ?\+ ?k2 is determined', 'move the inputs|moving them'
    ),
    'two gains, inputs that go together': Case(
        two_inputs, ('g1', 'g2', 'c'), 2, r'input|moving', 'no input can tell'
    ),
}  # fmt: skip


def advised(name: str, seed: int) -> str:
    """Return what is said of a window that leaves something open."""
    case = CASES[name]
    plant = Model(
        name='benchmark_lag',
        states=(Variable('level', lower=-20.0, upper=20.0),),
        inputs=tuple(Variable(f'u{i}') for i in range(case.inputs)),
        outputs=(Variable('y'),),
        parameters=tuple(Variable(each, lower=0.1, upper=5.0) for each in case.names),
        dynamics=case.rate,
        output=lambda t, x, u, p: (x[0],),
        max_step=0.05,
    )
    rng = np.random.default_rng([seed, SAMPLES])
    t = 0.1 * np.arange(200)
    levels = rng.uniform(-2.0, 2.0, size=20)
    u = np.repeat(levels, 10)[:, None] * np.ones(case.inputs)
    y = simulated(plant, t, u, [0.5], rng.uniform(0.5, 2.0, size=3))
    record = Record(t, u, y + 0.01 * rng.standard_normal(y.shape))
    found = alone(plant, record, dict.fromkeys(case.names, np.nan), seed, noise={'y': 0.01})
    return found.message


def refused() -> str:
    """Return what is said of arguments in a wrong order; they must be refused."""
    try:
        built(swapped, output)
    except ValueError as error:
        return str(error)
    raise AssertionError('arguments in a wrong order are taken')


def measured(runs: int, seed: int) -> tuple[list[Requirement], str]:
    """Solve so many windows in each way; return the rows and a table."""
    cells: dict[str, list[Any]] = {way: [] for way in WAYS}
    for way in WAYS:  # compiles
        attempted(written, way, seed)
    for each in range(seed, seed + runs):  # in turns, so that what slows the machine slows all
        for way in WAYS:
            cells[way].append(attempted(written, way, each))
    said = {name: [attempted(advised, name, seed + i) for i in range(runs)] for name in CASES}
    rows = [*_ways(cells), *_advice(said), _order(attempted(refused))]
    return rows, _table(cells)


def _ways(cells: Mapping[str, list[Any]]) -> Iterator[Requirement]:
    for way in WAYS:
        if way == PLAIN:
            continue

        def same(both: list[Any], count: int = len(cells[way])) -> tuple[str, bool]:
            own, plain = both[:count], both[count:]
            off = max(
                float(np.max(np.abs(one.values / other.values - 1.0)))
                for one, other in zip(own, plain, strict=True)
            )
            ratio = median_ratio([one.seconds for one in own], [other.seconds for other in plain])
            said = f'differs by {off:.0e}, time {words(ratio, ".2f")}'
            return said, off <= SAME and ratio[0] <= TIME

        asked = f'{way}: the same estimate to {SAME:g}, at <= {TIME:g} x the time'
        yield judged(asked, [*cells[way], *cells[PLAIN]], same)


def _advice(said: Mapping[str, list[Any]]) -> Iterator[Requirement]:
    for name, texts in said.items():
        case = CASES[name]

        def right(texts: list[Any], case: Case = case) -> tuple[str, bool]:
            hits = [
                bool(re.search(case.says, text)) and not re.search(case.never, text)
                for text in texts
            ]
            example = next((t for t, hit in zip(texts, hits, strict=True) if not hit), texts[0])
            return f'{sum(hits)} of {len(hits)}, as "{example[:120]}"', all(hits)

        asked = f'{name}: says "{case.says}", not "{case.never}"'.replace('|', '" or "')
        yield judged(asked, texts, right)


def _order(said: Any) -> Requirement:
    def named(texts: list[Any]) -> tuple[str, bool]:
        text = texts[0].replace('|', '/')
        return f'"{text[:160]}"', bool(re.search(r'order|\(t, x, u, p\)', text))

    return judged('dynamics(x, t, u, p): refused, the order of arguments named', [said], named)


def _table(cells: Mapping[str, list[Any]]) -> str:
    rows = []
    for way, own in cells.items():
        good = [one for one in own if not isinstance(one, Failure)]
        rows.append({
            'way': way, 'windows': len(good),
            'ms': f'{1e3 * np.median([one.seconds for one in good]):.2f}' if good else '-',
        })  # fmt: skip
    return table(rows)
