"""Tests of obs_ros.horizon.horizon_memory."""

import json
import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from plants import LAG

from obs_ros import Record
from obs_ros.core.deadline import Deadline
from obs_ros.core.plain_data import from_plain, to_plain
from obs_ros.core.rng import random_generator
from obs_ros.horizon.found_jumps import JumpFound, Size
from obs_ros.horizon.horizon_memory import HorizonMemory
from obs_ros.horizon.moving_horizon import MovingHorizon
from obs_ros.horizon.settings import EstimationSettings
from obs_ros.horizon.solver import Solver
from obs_ros.inference.jumps.layout import Layout

SOLVER = Solver.of(LAG, EstimationSettings(noise={'y': 0.05}))


def record(end: float) -> Record:
    """Of the lag: 10 s until there, with a gain that jumps at 17 s."""
    rng = np.random.default_rng(5)
    t = np.arange(0.0, 40.0, 0.2)
    u = np.repeat(rng.uniform(0.0, 2.0, 20), 10)
    x = np.zeros(t.size)
    for k in range(t.size - 1):
        x[k + 1] = x[k] + 0.2 * ((3.0 if t[k] >= 17.0 else 2.0) * u[k] - x[k]) / 3.0
    y = x + 0.05 * rng.standard_normal(t.size)
    inside = (t > end - 10.0) & (t <= end)
    return Record(t[inside], u[inside, None], y[inside, None])


@pytest.fixture(scope='module')
def memory() -> HorizonMemory:
    """After windows that showed a jump."""
    windows = MovingHorizon(SOLVER)
    for i, end in enumerate((10.0, 15.0, 20.0, 25.0)):
        windows.solve(record(end), random_generator(0, i), Deadline())
    found = windows.memory
    assert found is not None and found.arrival_cost.jumps and found.announcements.events
    assert found.explained is not None and found.explained.layout.events
    return found


def recalled(memory: HorizonMemory) -> MovingHorizon:
    windows = MovingHorizon(SOLVER)
    windows.recall(memory)
    return windows


def wrong_ones(memory: HorizonMemory) -> Iterator[tuple[str, HorizonMemory]]:
    """Yield memories that no run can have, and what is said of each."""
    cost, told = memory.arrival_cost, memory.announcements
    elsewhere = frozenset({7})
    jump, event, explained = cost.jumps[0], told.events[0], memory.explained
    assert explained is not None and memory.previous is not None and memory.stepping is not None
    other = JumpFound(1.0, 0.1, {'mass': Size(1.0, 0.1, 0.1, 0.01)})
    entry = cost.entries[-1]
    weightless = tuple(replace(one, weight=0.0) for one in entry.parts)
    yield (
        'arrival_cost.jumps: places',
        replace(memory, arrival_cost=replace(cost, jumps=(replace(jump, parameters=elsewhere),))),
    )
    yield (
        'arrival_cost.jumps: places',
        replace(
            memory,
            arrival_cost=replace(cost, jumps=(replace(jump, chances=((1.0, elsewhere, None),)),)),
        ),
    )
    yield (
        'arrival_cost.jumps: names',
        replace(
            memory,
            arrival_cost=replace(
                cost, jumps=(replace(jump, chances=((1.0, frozenset({1}), other),)),)
            ),
        ),
    )
    yield (
        'arrival_cost.entries: weights',
        replace(
            memory, arrival_cost=replace(cost, entries=(replace(entry, components=weightless),))
        ),
    )
    yield (
        'announcements: names',
        replace(memory, announcements=replace(told, events=(replace(event, found=other),))),
    )
    yield (
        'announcements: sizes',
        replace(
            memory,
            announcements=replace(
                told, events=(replace(event, jump=replace(event.jump, stddev={})),)
            ),
        ),
    )
    yield 'announcements: rates', replace(memory, announcements=replace(told, rates={'mass': 1.0}))
    yield 'contradicted: places', replace(memory, contradicted=elsewhere)
    yield 'alone', replace(memory, alone=(True,))
    yield 'explained: point', replace(memory, explained=replace(explained, layout=Layout(3)))
    events = tuple((9,) * len(event) for event in explained.layout.events)
    yield (
        'explained: places',
        replace(memory, explained=replace(explained, layout=Layout(3, events))),
    )
    yield 'stepping: method', replace(memory, stepping=replace(memory.stepping, method='magic'))
    yield (
        'stepping: steps',
        replace(memory, stepping=replace(memory.stepping, h=memory.stepping.h[1:])),
    )
    yield (
        'previous: times',
        replace(
            memory, previous=replace(memory.previous, times=np.empty(0), states=np.empty((0, 1)))
        ),
    )
    yield 'previous: states', replace(memory, previous=replace(memory.previous, state={'v': 1.0}))
    yield 'previous: parameters', replace(memory, previous=replace(memory.previous, parameters={}))
    yield 'forecasts: judged', replace(memory, forecasts=replace(memory.forecasts, judged=()))
    yield 'resolutions', replace(memory, resolutions=replace(memory.resolutions, steps=()))
    yield 'resolutions: places', replace(
        memory, resolutions=replace(memory.resolutions, unknown=(3,)))  # fmt: skip


def test_what_no_run_can_have_is_refused(memory: HorizonMemory) -> None:
    recalled(memory)
    for said, wrong in wrong_ones(memory):
        with pytest.raises(ValueError, match=f'{said}.* cannot be of this model'):
            recalled(wrong)


def leaves(plain: Any) -> Iterator[tuple[Any, Any]]:
    """Yield every place of plain data, as container and key."""
    for key in plain if isinstance(plain, dict) else range(len(plain)):
        yield plain, key
        if isinstance(plain[key], dict | list):
            yield from leaves(plain[key])


def test_nothing_but_a_value_error_comes_of_what_is_not_as_it_was(memory: HorizonMemory) -> None:
    """Each of some hundred places, changed by chance: refused, or a window is solved with it."""
    rng = np.random.default_rng(0)
    windows, text = MovingHorizon(SOLVER), json.dumps(to_plain(memory))
    strange = (None, True, -3, 10**400, 0.0, -1e300, 'nan', 'x', [], {}, [[]], {'shape': [-1]})
    refused = solved = 0
    for _ in range(400):
        plain = json.loads(text)
        places = list(leaves(plain))
        container, key = places[rng.integers(len(places))]
        container[key] = strange[rng.integers(len(strange))]
        try:
            other = recalled(from_plain(HorizonMemory, plain, windows.shapes))
        except ValueError:
            refused += 1
            continue
        solved += 1
        if solved <= 10:
            estimate = other.solve(record(30.0), random_generator(0, 4), Deadline())
            assert math.isfinite(estimate.t1)
    assert refused > 300
    assert solved > 10


def test_no_nan_where_none_may_be(memory: HorizonMemory) -> None:
    cost = memory.arrival_cost
    entry = replace(cost.entries[0], mean=np.full_like(cost.entries[0].mean, np.nan))
    poisoned = replace(memory, arrival_cost=replace(cost, entries=(entry,)))
    windows = MovingHorizon(SOLVER)
    with pytest.raises(ValueError, match=r'arrival_cost.entries\[0\].mean must be finite numbers'):
        from_plain(HorizonMemory, to_plain(poisoned), windows.shapes)
    poisoned = replace(memory, probation=replace(memory.probation, since=math.nan))
    with pytest.raises(ValueError, match=r'probation\.since must be a finite number'):
        from_plain(HorizonMemory, to_plain(poisoned), windows.shapes)
