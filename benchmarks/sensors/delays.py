"""Offsets in time and dead times of a spring: estimated, given, and suggested where unknown.

And a cart whose accelerometer comes at 400 Hz and whose position at 10 Hz, stamped 50 ms late.
"""

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from benchmarks.intervals import share_interval
from benchmarks.report import Requirement, table
from benchmarks.sensors.attempts import attempted, carried_out, failures, judged
from benchmarks.sensors.scores import median_ratio, rms_ratio, words
from benchmarks.sensors.solved import Solved, alone, in_sequence
from benchmarks.sensors.spring import (
    INTERVAL,
    NOISE,
    SPRING,
    Run,
    declared,
    forces,
    run,
    run_of,
)
from obs_ros import Model, Variable
from plant_sim.actuators import Actuator
from plant_sim.scenario import Scenario
from plant_sim.sensors import Sensor
from plant_sim.signals import constant
from plant_sim.simulation import Simulation

SAMPLES = 500  # of a window: the bound on an offset lies near a hundredth of an interval
OFFSETS = (0.1, 0.2, 0.5, 1.0, 1.5, 2.5, 5.0)  # sample intervals
BOX = 8.0 * INTERVAL  # s, of an offset that is estimated, to either side
KINDS = ('an output late', 'an output early', 'an input late')
SDS, SHARE, INTERVALS = 3.0, 0.98, 0.05
AS_GOOD, COST = 1.15, 1.15
LATE = 0.05  # s, where it is to be suggested, or is that of the cart's position
NEAR = 0.2  # of it, by which a suggestion may be off
SUGGESTED, FALSE = 0.9, 0.01  # of runs with and without an offset
WINDOWS, WINDOW = 6, 250  # of such a run, and samples of each
SUGGESTION = re.compile(r'(\w+) looks ([\d.]+) ms (late|early)')
IMU, POSE = 0.0025, 40  # s; samples from one position to the next
NOISES = {'acceleration': 0.02, 'position': 0.002}  # m/s2, m
CART_SAMPLES = 2000
BEFORE = 40  # samples of a run before its window, more than an offset


class Found(NamedTuple):
    """A window with its offset: error and deviation in s, NaN where none is estimated."""

    window: Solved
    error: float
    sd: float


def faults(kind: str, delay: float) -> tuple[Sensor | None, Actuator | None]:
    """Return the sensor and actuator with an offset of a kind (s)."""
    if kind == KINDS[2]:
        return None, Actuator(delay=delay)
    return Sensor(delay=delay if kind == KINDS[0] else -delay), None


def late(kind: str, intervals: float, seed: int) -> Run:
    """Return the run of that seed with an offset of so many intervals, SAMPLES outputs.

    Outputs that are late are so from the first sample on. Of an input that is late the record has
    what was told before.
    """
    sensor, actuator = faults(kind, intervals * INTERVAL)
    drawn = run(seed, SAMPLES + BEFORE, sensor, actuator)
    if kind != KINDS[2] or not intervals:
        return drawn.later(BEFORE)
    y = drawn.record.y.copy()
    y[:BEFORE] = np.nan
    return drawn.spoiled(y)


def estimated(kind: str, intervals: float, seed: int) -> Found:
    """Solve a window whose offset is one of the unknowns."""
    drawn = late(kind, intervals, seed)
    if kind == KINDS[2]:
        model, name = declared(input={'delay': (0.0, BOX)}), 'force.delay'
    else:
        model, name = declared(output={'delay': (-BOX, BOX)}), 'y.delay'
    true = -intervals if kind == KINDS[1] else intervals
    truth = {**drawn.truth, name: true * INTERVAL}
    window = alone(model, drawn.record, truth, seed, noise={'y': NOISE})
    return Found(window, float(window.error[-1]), float(window.sd[-1]))


def given(kind: str, intervals: float, seed: int) -> Solved:
    """Solve a window whose offset is declared."""
    drawn = late(kind, intervals, seed)
    delay = (-intervals if kind == KINDS[1] else intervals) * INTERVAL
    properties = {'delay': delay} if delay else {}
    model = declared(input=properties) if kind == KINDS[2] else declared(output=properties)
    return alone(model, drawn.record, drawn.truth, seed, noise={'y': NOISE})


def undeclared(delay: float, seed: int) -> list[str]:
    """Return what is said of windows in sequence whose output is late by so many s, undeclared."""
    sensor, length = Sensor(delay=delay), WINDOWS * WINDOW
    drawn = run(seed, BEFORE + length, sensor if delay else None).later(BEFORE)
    found = in_sequence(SPRING, drawn.windows(WINDOW), drawn.truth, seed, noise={'y': NOISE})
    return [one.message for one in found]


def cart_dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any]:
    """Return the rates of a cart's position and speed."""
    return x[1], p[0] * u[0] - p[1] * x[1]


def cart_output(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any]:
    """Return acceleration and position."""
    return p[0] * u[0] - p[1] * x[1], x[0]


CART = Model(
    name='benchmark_cart',
    states=(
        Variable('place', 'm', lower=-20.0, upper=20.0),
        Variable('speed', 'm/s', lower=-10.0, upper=10.0),
    ),
    inputs=(Variable('push', 'N'),),
    outputs=(Variable('acceleration', 'm/s2'), Variable('position', 'm')),
    parameters=(
        Variable('gain', '1/kg', lower=0.05, upper=5.0),
        Variable('drag', '1/s', lower=0.0, upper=5.0),
    ),
    dynamics=cart_dynamics,
    output=cart_output,
    max_step=0.01,
)


def cart(seed: int, properties: Mapping[str, Any]) -> Solved:
    """Solve 5 s of a cart whose position is stamped late, with properties of that output."""
    rng = np.random.default_rng([seed, CART_SAMPLES])
    gain, drag = rng.uniform((0.5, 0.3), (1.5, 1.0)).tolist()
    truth = {'gain': gain, 'drag': drag}
    scenario = Scenario(
        name='cart',
        model=f'{__name__}:CART',
        initial_state=(0.0, float(rng.uniform(-1.0, 1.0))),
        inputs=forces(rng, IMU * (BEFORE + CART_SAMPLES)),
        parameters=constant(gain, drag),
        sample_period=IMU,
        duration=IMU * (BEFORE + CART_SAMPLES),
        snr_db=math.inf,
    )
    simulation = Simulation(scenario, seed=seed)
    simulation.sensors = {'position': Sensor(delay=LATE)}
    instants = [simulation.sample() for _ in range(BEFORE + CART_SAMPLES)]
    drawn = run_of(instants, truth).later(BEFORE)
    y = drawn.record.y + np.array(list(NOISES.values())) * rng.standard_normal((CART_SAMPLES, 2))
    y[np.arange(CART_SAMPLES) % POSE != 0, 1] = np.nan
    outputs = [CART.outputs[0], replace(CART.outputs[1], **properties)]
    if isinstance(properties.get('delay'), tuple):
        truth['position.delay'] = LATE
    record = drawn.record.with_outputs(y)
    return alone(replace(CART, outputs=outputs), record, truth, seed, noise=NOISES)


def paired(kind: str, seed: int) -> tuple[float, float]:
    """Return the process times (s) of a window with a known offset, and of one without.

    Both have as many outputs, and take turns.
    """
    turns = [[given(kind, offset, seed).seconds for offset in (2.5, 0.0)] for _ in range(5)]
    late, in_time = np.min(turns, axis=0).tolist()
    return late, in_time


def measured(runs: int, seed: int) -> tuple[list[Requirement], str]:
    """Solve so many windows of each offset; return the rows and a table."""
    for kind in KINDS[1:]:
        attempted(estimated, kind, 1.0, seed)  # compiles here, so that workers find it cached
        attempted(given, kind, 1.0, seed)
    seeds, many = range(seed, seed + runs), range(seed, seed + 4 * runs)
    # Each cell has noise of its own: an unlucky draw counts once, not once for every offset.
    found = carried_out(
        estimated, {(kind, offset): [(kind, offset, each + runs * place) for each in seeds]
                    for kind in KINDS for place, offset in enumerate(OFFSETS)}, 'offsets',
    )  # fmt: skip
    known = carried_out(
        given, {(kind, offset): [(kind, offset, each) for each in seeds] for kind in KINDS
                for offset in (0.0, 2.5)}, 'known offsets',
    )  # fmt: skip
    told = carried_out(
        undeclared, {delay: [(delay, each) for each in many] for delay in (0.0, LATE)},
        'suggestions',
    )  # fmt: skip
    runs_of_carts = [(each, {'delay': (-0.2, 0.2)}) for each in many]
    carts = carried_out(cart, {'': runs_of_carts}, 'carts')['']
    times = {kind: [attempted(paired, kind, each) for each in seeds] for kind in KINDS[1:]}
    rows = [
        *_estimated(found), *_given(known), *_costs(times), *_suggested(told), *_carts(carts),
    ]  # fmt: skip
    return rows, _table(found)


def _estimated(cells: Mapping[tuple[str, float], list[Any]]) -> Iterator[Requirement]:
    for kind in KINDS:
        own = [one for offset in OFFSETS for one in cells[kind, offset]]

        def near(own: list[Any]) -> tuple[str, bool]:
            hits = sum(abs(one.error) <= SDS * one.sd for one in own)
            low, high = share_interval(hits, len(own))
            share = hits / len(own)
            return f'{share:.3f} ({low:.3f}-{high:.3f}) of {len(own)}', share >= SHARE

        def exact(own: list[Any]) -> tuple[str, bool]:
            worst = max(abs(one.error) for one in own) / INTERVAL
            return f'worst {worst:.3f}', worst <= INTERVALS

        what = f'{kind} by {OFFSETS[0]:g} to {OFFSETS[-1]:g} intervals'
        yield judged(f'{what}: >= {SHARE:.0%} found within {SDS:g} sd', own, near)
        yield judged(f'{what}: within {INTERVALS:g} of an interval', own, exact)


def _given(cells: Mapping[tuple[str, float], list[Any]]) -> Iterator[Requirement]:
    for kind in KINDS:
        bad, good = cells[kind, 2.5], cells[kind, 0.0]

        def ratio(_: list[Any], bad: Any = bad, good: Any = good) -> tuple[str, bool]:
            found = rms_ratio(bad, good)
            return words(found), found[0] <= AS_GOOD

        asked = f'{kind} by 2.5 intervals, given: RMS error <= {AS_GOOD:g} x that without'
        yield judged(asked, [*bad, *good], ratio)


def _costs(times: Mapping[str, list[Any]]) -> Iterator[Requirement]:
    for kind, pairs in times.items():

        def cheap(pairs: list[Any]) -> tuple[str, bool]:
            found = median_ratio(*zip(*pairs, strict=True))
            return words(found), found[0] <= COST

        yield judged(f'{kind}, given: time <= {COST:g} x that without', pairs, cheap)


def said(messages: list[str]) -> bool:
    """Whether the last window's message names the offset: that of y, or of all inputs beside it."""
    match = SUGGESTION.search(messages[-1])
    if match is None or match[1] not in ('y', 'force') or match[3] != 'late':
        return False
    return abs(1e-3 * float(match[2]) - LATE) <= NEAR * LATE


def _suggested(cells: Mapping[float, list[Any]]) -> Iterator[Requirement]:
    def found(own: list[Any]) -> tuple[str, bool]:
        hits = sum(map(said, own))
        return _share(hits, len(own)), hits >= SUGGESTED * len(own)

    def false(own: list[Any]) -> tuple[str, bool]:
        hits = sum(any(map(SUGGESTION.search, messages)) for messages in own)
        return _share(hits, len(own)), hits <= FALSE * len(own)

    late = f'y {1e3 * LATE:g} ms late, not declared'
    yield judged(
        f'{late}: the message says so, to {NEAR:.0%}, in >= {SUGGESTED:.0%} of runs', cells[LATE],
        found,
    )  # fmt: skip
    yield judged(f'no offset: suggested in <= {FALSE:.0%} of runs', cells[0.0], false)


def _carts(carts: list[Any]) -> Iterator[Requirement]:
    def near(own: list[Any]) -> tuple[str, bool]:
        off = np.abs([one.error / one.sd for one in own])
        hits, count = int((off <= SDS).sum()), off.size
        return _share(hits, count), bool(hits >= SHARE * count)

    yield judged(
        f'400 Hz accelerometer, 10 Hz position {1e3 * LATE:g} ms late, estimated: >= {SHARE:.0%} '
        f'of values within {SDS:g} sd', carts, near,
    )  # fmt: skip


def _share(hits: int, count: int) -> str:
    low, high = share_interval(hits, count)
    return f'{hits / count:.3f} ({low:.3f}-{high:.3f}) of {count}'


def _table(cells: Mapping[tuple[str, float], list[Any]]) -> str:
    rows = []
    for (kind, offset), own in cells.items():
        if not failures(own):
            errors, sds = (np.array([getattr(one, n) for one in own]) for n in ('error', 'sd'))
            rows.append({
                'offset': kind, 'intervals': f'{offset:g}', 'windows': len(own),
                'RMS error, intervals': f'{np.sqrt(np.mean(errors**2)) / INTERVAL:.4f}',
                'median sd': f'{np.median(sds) / INTERVAL:.4f}',
                'RMS error / sd': f'{np.sqrt(np.mean((errors / sds) ** 2)):.2f}',
                'accepted': sum(one.window.accepted for one in own),
                'ms': f'{1e3 * np.median([one.window.seconds for one in own]):.1f}',
            })  # fmt: skip
    return table(rows)
