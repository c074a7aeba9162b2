"""Tests of obs_ros.horizon.knowledge: windows that are stopped, and taken up by another horizon."""

import json
from collections.abc import Callable
from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest
from plants import INTEGRATOR, LAG

from obs_ros import Estimate, Model, Outcome, Record
from obs_ros.core.deadline import Deadline
from obs_ros.core.plain_data import described, from_plain, to_plain
from obs_ros.core.rng import random_generator
from obs_ros.horizon.horizon_memory import MOST_NODES, HorizonMemory, PreviousWindow
from obs_ros.horizon.knowledge import NOT_FINITE, SHAPES
from obs_ros.horizon.moving_horizon import MovingHorizon
from obs_ros.horizon.settings import EstimationSettings
from obs_ros.horizon.solver import Solver

SIGMA = 0.05


def lag_course(jumps: bool, pushed: float, seed: int = 3) -> Record:
    """A lag of gain 2 and time constant 3 s, 60 s at 5 Hz; `pushed` is its process noise."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 60.0, 0.2)
    u = np.repeat(rng.uniform(0.0, 2.0, 30), 10)
    x, y = 0.5, []
    for k in range(t.size):
        y.append(x)
        gain = 2.6 if jumps and t[k] >= 27.0 else 2.0
        x += 0.2 * (gain * u[k] - x) / 3.0 + pushed * 0.2**0.5 * rng.standard_normal()
    noise = SIGMA * rng.standard_normal(t.size)
    return Record(t, u[:, None], (np.array(y) + noise)[:, None])


def cut(course: Record, duration: float, period: float) -> list[Record]:
    ends = np.arange(duration, 60.0, period)
    inside = [(course.t > end - duration) & (course.t <= end) for end in ends]
    return [Record(course.t[some], course.u[some], course.y[some]) for some in inside]


def horizon(model: Model = LAG, *, learn_noise: bool = False, **settings: Any) -> MovingHorizon:
    return MovingHorizon(Solver.of(model, EstimationSettings(**settings)), learn_noise=learn_noise)


def taken_up(memory: HorizonMemory | None, new: MovingHorizon) -> MovingHorizon:
    """Let a new horizon recall a memory that has been a text."""
    text = json.dumps(to_plain(memory), allow_nan=False)
    new.recall(from_plain(HorizonMemory, json.loads(text), new.shapes))
    return new


def bits(estimate: Estimate) -> str:
    """All of an estimate but the time that it took."""
    told = {f.name: getattr(estimate, f.name) for f in fields(estimate) if f.name != 'solve_time'}
    return json.dumps(to_plain(told))


def solved(windows: MovingHorizon, records: list[Record], first: int = 0) -> list[Estimate]:
    return [
        windows.solve(record, random_generator(0, first + i), Deadline())
        for i, record in enumerate(records)
    ]


CASES: dict[str, tuple[Record, float, Callable[[], MovingHorizon]]] = {
    'abutting': (lag_course(False, 0.0), 10.0, lambda: horizon(noise={'y': SIGMA})),
    'overlapping, a jump': (lag_course(True, 0.0), 5.0, lambda: horizon(noise={'y': SIGMA})),
    'noise learned': (lag_course(True, 0.0), 5.0, lambda: horizon(learn_noise=True)),
    'pushed about': (lag_course(False, 0.1), 5.0, lambda: horizon(noise={'y': SIGMA})),
    'another search': (
        lag_course(False, 0.0), 10.0,
        lambda: horizon(search='chaotic_de', search_options={'generations': 20}),
    ),
}  # fmt: skip


@pytest.mark.parametrize('case', list(CASES))
def test_a_run_that_is_taken_up_has_the_bits_of_one_that_never_stopped(case: str) -> None:
    course, period, make = CASES[case]
    records = cut(course, 10.0, period)
    whole, memories, expected = make(), [], []
    for i, record in enumerate(records):
        expected += solved(whole, [record], i)
        memories.append(whole.memory)
    assert sum(estimate.usable for estimate in expected) >= len(expected) - 1
    if case == 'pushed about':
        assert any(estimate.walks for estimate in expected)
    if case == 'overlapping, a jump':
        assert any(jump.new for estimate in expected for jump in estimate.jumps)
    # Of all later windows once, and from every window on the next one.
    resumed = taken_up(memories[1], make())
    assert list(map(bits, solved(resumed, records[2:], 2))) == list(map(bits, expected[2:]))
    assert to_plain(resumed.memory) == to_plain(memories[-1])
    for k in range(2, len(records) - 1):
        following = solved(taken_up(memories[k], make()), [records[k + 1]], k + 1)
        assert bits(following[0]) == bits(expected[k + 1])


def test_a_memory_does_not_change_with_the_horizon_that_it_is_of() -> None:
    course, period, make = CASES['pushed about']
    records, windows = cut(course, 10.0, period), make()
    solved(windows, records[:6])
    memory = windows.memory
    before = json.dumps(to_plain(memory))
    solved(windows, records[6:], 6)
    assert json.dumps(to_plain(memory)) == before
    resumed = taken_up(memory, make())
    solved(resumed, records[6:], 6)
    assert json.dumps(to_plain(memory)) == before


def test_before_the_first_window_there_is_nothing_to_remember() -> None:
    assert horizon().memory is None


def test_time_that_nobody_looked_at_widens_what_is_known_as_a_gap_does() -> None:
    course, period, make = CASES['abutting']
    records = cut(course, 10.0, period)
    few = slice(0, 12)  # samples of the window after the gap, which tell little by themselves
    deviations = []
    for gap in (0.0, 100.0, 10_000.0):
        whole, last = make(), records[4]
        solved(whole, records[:4])
        resumed = taken_up(whole.memory, make())
        later = Record(last.t[few] + gap, last.u[few], last.y[few])
        found = solved(resumed, [later], 4)[0]
        assert bits(found) == bits(solved(whole, [later], 4)[0])
        deviations.append(found.stddev['k'])
    alone = solved(make(), [later])[0].stddev['k']
    assert deviations[0] < 0.5 * deviations[1] < deviations[2]
    # Beyond all memory it is as if nothing had been known, but that it lies in its box.
    assert deviations[2] == pytest.approx(alone, rel=0.05)


def test_of_a_long_window_the_end_is_kept() -> None:
    t = np.arange(float(MOST_NODES + 1))
    one = {'x': 1.0}
    estimate = Estimate(
        one, one, one, {}, Outcome.CONVERGED, '', 0.0, t[-1], times=t, states=t[:, None]
    )
    kept = PreviousWindow.of(estimate)
    assert kept.times.tolist() == [t[-1]] and kept.states.tolist() == [[t[-1]]]
    shorter = replace(estimate, times=t[1:], states=t[1:, None])
    assert PreviousWindow.of(shorter).times.size == MOST_NODES


def test_every_array_of_a_memory_has_a_shape() -> None:
    """What `from_plain` reads must be in the table, and nothing else."""
    arrays, all_fields = set(), set()
    for line in described(HorizonMemory).splitlines():
        name, _, rest = line.partition('(')
        for each in rest.removesuffix(')').split(', '):
            field, _, kind = each.partition(': ')
            all_fields.add(f'{name.lstrip("_")}.{field}')
            if 'Array' in kind:
                arrays.add(f'{name.lstrip("_")}.{field}')
    assert arrays == set(SHAPES)
    assert all_fields >= NOT_FINITE


def test_another_model_is_refused() -> None:
    """By the file before that: this is the second wall."""
    course, period, make = CASES['abutting']
    windows = make()
    solved(windows, cut(course, 10.0, period)[:2])
    plain = to_plain(windows.memory)
    other = horizon(INTEGRATOR)
    with pytest.raises(ValueError, match=r'cannot be of this model|must be an array of'):
        other.recall(from_plain(HorizonMemory, plain, other.shapes))
    assert other.memory is None


def test_priors_that_were_contradicted_stay_so() -> None:
    model = replace(LAG, parameters=tuple(
        replace(v, prior=(0.9, 0.01)) if v.name == 'k' else v for v in LAG.parameters
    ))  # fmt: skip
    course, period, _ = CASES['abutting']
    windows = horizon(model, noise={'y': SIGMA})
    solved(windows, cut(course, 10.0, period)[:1])
    memory = windows.memory
    assert memory is not None and memory.contradicted
    resumed = taken_up(memory, horizon(model, noise={'y': SIGMA})).memory
    assert resumed is not None and resumed.contradicted == memory.contradicted
