"""Tests of obs_ros.observers.sliding_window."""

import hashlib
import json
import re
import threading
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from arx import ARX, PERIOD, A, B, course, pushes
from arx import samples as nodes
from plants import tank_outputs

from obs_ros import Estimate, Outcome, Record, Sample, solve_window
from obs_ros.core.plain_data import described, to_plain
from obs_ros.interface.checkpoint_file import VERSION
from obs_ros.observers.sliding_window import SlidingWindowObserver, WindowsMemory
from obs_ros.optimization.acceptance import Acceptance
from obs_ros.optimization.levenberg_marquardt import levenberg_marquardt
from obs_ros.optimization.methods import METHODS, Method
from obs_ros.optimization.problem import Problem
from obs_ros.optimization.result import Effort, Found
from plant_sim.scenarios import load_scenario
from plant_sim.simulation import Simulation

S = 10**9
FEED = np.array([30.0, 30.0])
NOISE = {'h1': 0.01, 'h2': 0.01}
X0, P = (50.0, 40.0, 45.0), (0.6, 0.5, 0.7)
LEVELS = tank_outputs(np.arange(1000.0), X0, P)
LEVELS += 0.01 * np.random.default_rng(2).standard_normal(LEVELS.shape)


def make(duration: float = 100.0, period: float | None = None, **settings: Any) -> Any:
    return SlidingWindowObserver('three_tank', duration=duration, period=period, **settings)


def samples(first: int = 0, last: int = 402) -> list[Sample]:
    return [Sample(k * S, y=LEVELS[k], u=FEED) for k in range(first, last)]


def window(first: int, last: int) -> Record:
    t = np.arange(float(first), last)
    return Record(t, np.tile(FEED, (t.size, 1)), LEVELS[first:last])


def run(observer: Any, stream: list[Sample]) -> list[Estimate]:
    return [observer.estimate() for sample in stream if observer.absorb(sample)]


def test_it_tells_what_it_estimates() -> None:
    assert make(states=(), fixed={'h3': 45.0, 'h1': 50.0, 'h2': 40.0}).unknowns.names == (
        'p1', 'p2', 'p3',
    )  # fmt: skip


def test_abutting_windows() -> None:
    found = run(make(noise=NOISE), samples())
    assert [(e.t0, e.t1) for e in found] == [(0, 100), (101, 200), (201, 300), (301, 400)]
    assert [e.stamp for e in found] == [100 * S, 200 * S, 300 * S, 400 * S]
    for estimate in found:
        assert estimate.outcome is Outcome.CONVERGED
        assert estimate.parameters['p2'] == pytest.approx(0.5, abs=0.01)
        assert estimate.parameters == pytest.approx({'p1': 0.6, 'p2': 0.5, 'p3': 0.7}, abs=0.2)
        assert estimate.state['h1'] == pytest.approx(LEVELS[round(estimate.t1), 0], abs=0.05)


def test_overlapping_windows() -> None:
    found = run(make(200.0, 50.0, noise=NOISE), samples())
    assert [e.t1 for e in found] == [200, 250, 300, 350, 400]
    assert [e.t0 for e in found] == [0, 51, 101, 151, 201]
    for estimate in found:
        assert estimate.outcome is Outcome.CONVERGED
        assert estimate.parameters == pytest.approx({'p1': 0.6, 'p2': 0.5, 'p3': 0.7}, abs=0.02)


def test_it_solves_what_solve_window_solves() -> None:
    estimate = run(make(noise=NOISE, seed=3), samples(0, 102))[0]
    alone = solve_window('three_tank', window(0, 101), noise=NOISE)
    assert estimate.cost == pytest.approx(alone.cost, abs=0.1)


def test_windows_inherit_the_previous_estimate() -> None:
    found = run(make(noise=NOISE), samples())
    evaluations = [estimate.evaluations for estimate in found]
    # A population and some rounds at first; then few steps from where the last one ended.
    assert evaluations[0] > 1000
    alone = solve_window('three_tank', window(201, 301), noise=NOISE)
    assert max(evaluations[1:]) < 0.5 * alone.evaluations
    for name, tells in (('p1', 0.5), ('p3', 0.5)):
        assert found[2].stddev[name] < tells * alone.stddev[name]


def test_an_estimate_without_values_is_not_inherited() -> None:
    stream = samples()
    # Two stamps in the second window are too few for six unknowns.
    stream = [s for s in stream if not 102 * S <= s.stamp <= 199 * S]
    observer = make(noise=NOISE)
    found = run(observer, stream)
    outcomes = [estimate.outcome is Outcome.TOO_FEW_SAMPLES for estimate in found]
    assert outcomes == [False, True, False, False]
    # Nothing is known of the start of a window that follows no other.
    assert found[0].evaluations > 1000
    later = max(found[2].evaluations, found[3].evaluations)
    alone = solve_window('three_tank', window(201, 301), noise=NOISE)
    assert 0 < later < 0.6 * alone.evaluations
    assert found[2].stddev['p1'] < 0.7 * alone.stddev['p1']


def taken_up(memory: Any, **settings: Any) -> Any:
    """An observer that goes on after what another one knew, once it has been a text."""
    observer = make(**settings)
    observer.recall(json.loads(json.dumps(to_plain(memory), allow_nan=False)))
    return observer


@pytest.mark.parametrize('settings', [
    {'duration': 100.0, 'noise': NOISE},
    {'duration': 100.0, 'period': 50.0, 'noise': NOISE, 'learn_noise': True, 'seed': 3},
])  # fmt: skip
def test_an_observer_that_is_stopped_and_taken_up_goes_on_with_the_same_bits(
    settings: dict[str, Any],
) -> None:
    period = settings.get('period', settings['duration'])
    observer, memories, expected = make(**settings), [], []
    for sample in samples():
        if observer.absorb(sample):
            expected.append(observer.estimate())
            memories.append(observer.memory)
    for k in (0, len(expected) - 3):
        resumed = taken_up(memories[k], **settings)
        left = memories[k].end + (period - settings['duration']) * S
        found = run(resumed, [sample for sample in samples() if sample.stamp > left])
        alike = [replace(estimate, solve_time=0.0) for estimate in (*found, *expected[k + 1 :])]
        texts = [json.dumps(to_plain(vars(estimate))) for estimate in alike]
        assert texts[: len(found)] == texts[len(found) :] and len(found) == len(expected) - k - 1
        assert to_plain(resumed.memory) == to_plain(memories[-1])


def test_the_first_estimate_after_a_gap_has_the_old_knowledge() -> None:
    observer = make(duration=100.0, noise=NOISE)
    run(observer, samples(0, 201))
    memory = observer.memory
    # Nobody looked for 35 s of a window: what is left of it tells little of p1 by itself.
    stream = samples(240, 305)
    resumed = run(taken_up(memory, duration=100.0, noise=NOISE), stream)[0]
    whole = run(observer, stream)[0]
    assert (resumed.t0, resumed.t1) == (240, 300)
    assert resumed.parameters == whole.parameters
    assert resumed.stddev == whole.stddev
    fresh = make(duration=60.0, noise=NOISE)
    alone = run(fresh, stream)[0]
    assert np.isnan(alone.stddev['p1']) and resumed.stddev['p1'] < 0.03
    assert resumed.parameters['p1'] == pytest.approx(0.6, abs=4.0 * resumed.stddev['p1'])


def test_a_clock_that_was_set_back_makes_it_begin_anew() -> None:
    observer = make(noise=NOISE)
    run(observer, samples(0, 205))
    resumed = taken_up(observer.memory, noise=NOISE)
    assert resumed.memory is not None
    found = run(resumed, samples(0, 102))
    assert 'output stamps jumped back from' in resumed.last_break
    assert resumed.memory is not None and len(found) == 1
    alone = run(make(noise=NOISE), samples(0, 102))
    assert found[0].parameters == alone[0].parameters


@pytest.mark.parametrize(
    ('changes', 'said'),
    [
        ({'solved': 0}, 'was none'),
        ({'end': 2**63}, 'was none'),
        ({'end': 1.5}, 'end must be an integer'),
        ({'horizon': None}, 'horizon must be an object'),
    ],
)
def test_a_memory_that_is_none_leaves_the_observer_as_it_was(
    changes: dict[str, Any], said: str
) -> None:
    observer = make(noise=NOISE)
    run(observer, samples(0, 102))
    plain = {**to_plain(observer.memory), **changes}
    other = make(noise=NOISE)
    with pytest.raises(ValueError, match=said):
        other.recall(plain)
    assert other.memory is None and other.last_break is None
    assert run(other, samples(0, 102))[0].usable


def test_the_layout_of_a_memory_is_that_of_its_version() -> None:
    """Whoever changes the fields of what is remembered raises the version of the file."""
    layout = described(WindowsMemory)
    digest = hashlib.sha256(layout.encode()).hexdigest()[:16]
    assert {VERSION: digest} == {1: 'a42d1769759c626f'}, layout


def test_the_identity_has_what_changes_the_meaning_of_what_was_learned() -> None:
    one = make(noise=NOISE).identity
    assert make(noise=NOISE, seed=5, capacity=500, period=20.0).identity == one
    for settings, name in (
        ({'noise': {'h1': 0.02, 'h2': 0.01}}, 'noise.h1'),
        ({'noise': NOISE, 'duration': 50.0}, 'window.duration'),
        ({'noise': NOISE, 'learn_noise': True}, 'learn_noise'),
        ({'noise': NOISE, 'loss': 'squares'}, 'loss'),
        ({'noise': NOISE, 'process_noise': 'off'}, 'process_noise'),
        ({'noise': NOISE, 'bounds': {'p1': (0.1, 0.9)}}, 'bounds.p1'),
        ({'noise': NOISE, 'fixed': {'p1': 0.5}}, 'fixed.p1'),
    ):
        other = make(**settings).identity
        assert name in {key for key in {*one, *other} if one.get(key) != other.get(key)}


def test_only_the_newest_due_window_is_solved_and_the_others_are_counted() -> None:
    observer = make(noise=NOISE)
    assert observer.counts['skipped'] == 0
    due = [observer.absorb(sample) for sample in samples()]
    assert sum(due) == 4
    estimate = observer.estimate()
    assert (estimate.t0, estimate.t1) == (301, 400)
    assert observer.counts['skipped'] == 3
    assert observer.estimate() is None


def test_results_begun_before_a_reset_are_dropped() -> None:
    interruptions = [True, False]

    def interrupted(*problem: Any) -> Found:
        if interruptions.pop(0):
            observer.reset()
        return METHODS['memetic'].search(*problem)

    method = Method(interrupted, METHODS['memetic'].settings, needs_squares=True)
    observer = make(noise=NOISE, search=method)
    for sample in samples(0, 102):
        observer.absorb(sample)
    assert observer.estimate() is None
    after = run(observer, samples(300, 402))
    fresh = run(make(noise=NOISE), samples(300, 402))
    assert not interruptions
    for a, b in zip(after, fresh, strict=True):
        assert (a.t0, a.parameters) == (300.0, b.parameters)
        assert a.stddev == pytest.approx(b.stddev, abs=0.0, rel=0.0, nan_ok=True)
        assert a.evaluations == b.evaluations


def test_a_method_of_the_users_own_may_ask_a_window_with_a_prior_all_that_it_asks_others() -> None:
    asked = set()

    @dataclass(frozen=True)
    class Own:
        starts: int = 8

    def own(problem: Any, rng: Any, deadline: Any, settings: Own, *_: Any) -> Found:
        asked.update(name for name in dir(Problem) if name[0] != '_' and hasattr(problem, name))
        assert problem.is_least_squares and problem.signal > 0.0
        z = rng.random((settings.starts, problem.dimension))
        found = levenberg_marquardt(problem, z, problem.nodes, 100, deadline)
        cost = float(problem.costs(found.z[:1])[0])
        assert problem.residuals(found.z[0]).shape == (problem.nodes, 2)
        assert problem.block_squares(found.z[:1], np.array([problem.nodes]))[0, 0] == cost
        return Found(found.z[0], cost, True, Acceptance.METHOD, Effort(8, 'start'))

    method = Method(own, Own, needs_squares=True)
    alone = solve_window('three_tank', window(0, 101), method, noise=NOISE)
    estimate = run(make(noise=NOISE, search=method), samples(0, 102))[0]
    assert asked == {name for name in dir(Problem) if name[0] != '_'}
    for found in (alone, estimate):
        assert found.outcome is Outcome.CONVERGED
        assert found.parameters['p2'] == pytest.approx(0.5, abs=0.01)
    assert estimate.cost == pytest.approx(alone.cost, abs=0.1)


def test_the_same_samples_give_the_same_bits_also_after_a_reset() -> None:
    observer, other = make(seed=5), make(seed=5)
    first, second = run(observer, samples(0, 202)), run(other, samples(0, 202))
    observer.reset()
    third = run(observer, samples(0, 202))
    for a, b, c in zip(first, second, third, strict=True):
        assert a.parameters == b.parameters == c.parameters
        assert a.evaluations == b.evaluations == c.evaluations


def test_one_thread_absorbs_while_another_estimates() -> None:
    observer = make(50.0, 10.0, noise=NOISE)
    observer.prepare()
    due, done = threading.Event(), threading.Event()
    found: list[Estimate] = []
    errors: list[BaseException] = []

    def work() -> None:
        try:
            while not done.is_set():
                due.wait(0.01)
                due.clear()
                estimate = observer.estimate(0.05)
                if estimate is not None:
                    found.append(estimate)
        except BaseException as error:
            errors.append(error)

    worker = threading.Thread(target=work)
    worker.start()
    closed = 0
    for sample in samples(0, 1000):
        if observer.absorb(sample):
            closed += 1
            due.set()
        if sample.stamp == 500 * S:
            observer.reset()
    done.set()
    worker.join(10.0)
    assert not worker.is_alive() and not errors
    left = observer.estimate(0.05)
    found += [left] if left else []
    assert closed == 46 + 45  # ends at 50, 60 ... 500 s, then at 551, 561 ... 991 s
    # At most what a reset drops is missing: the window due and the one being solved.
    assert closed - 2 <= len(found) + observer.counts['skipped'] <= closed
    ends = [estimate.t1 for estimate in found]
    assert len(set(ends)) == len(ends)
    assert ends == sorted(ends)


def test_a_deadline_is_obeyed_and_its_result_inherited() -> None:
    observer = make(noise=NOISE)
    for sample in samples(0, 102):
        observer.absorb(sample)
    assert observer.estimate(0.0).outcome is Outcome.DEADLINE


def test_settings_reach_the_solver() -> None:
    observer = make(
        parameters=['p1'], fixed={'p2': 0.5, 'p3': 0.7}, bounds={'p1': (0.5, 0.65)}, noise=NOISE
    )
    estimate = run(observer, samples(0, 102))[0]
    assert (estimate.parameters['p2'], estimate.parameters['p3']) == (0.5, 0.7)
    assert estimate.parameters['p1'] == pytest.approx(0.6, abs=0.02)


@pytest.mark.parametrize(
    ('settings', 'message'),
    [
        ({'duration': 0.0}, 'duration 0.0 s is not a positive time'),
        ({'duration': 10.0, 'period': -1.0}, 'period -1.0 s is not a positive time'),
        ({'duration': 10.0, 'capacity': 1}, 'capacity 1 is too small'),
        ({'duration': 10.0, 'parameters': ['p7']}, "no parameter 'p7' to estimate"),
        ({'duration': 10.0, 'noise': {'h1': -1.0}}, 'noise of h1: standard deviation -1.0'),
        ({'duration': 10.0, 'search': 'x'}, "unknown search method 'x'"),
        ({'duration': 10.0, 'backend': 'x'}, "backend 'x' is neither"),
        ({'duration': 10.0, 'seed': -1}, 'seed must be an integer >= 0, not -1'),
    ],
)
def test_wrong_settings_are_named_at_once(settings: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=re.escape(message)):
        make(**settings)


def test_two_valves_that_jump_at_once_are_found_by_every_window_that_holds_them() -> None:
    """The scenario's first fault at 40 dB; a search that gave up too soon saw no second jump."""
    pytest.importorskip('numba')
    run = Simulation(load_scenario('three_tank'), seed=1)
    watched = SlidingWindowObserver('three_tank', duration=300.0, period=50.0)
    outcomes, jumps = [], []
    while run.t <= 1310.0:
        instant = run.sample()
        stamp = round(instant.t * 1e9)
        watched.absorb(Sample(stamp, u=instant.u))
        if watched.absorb(Sample(stamp, y=instant.y)):
            estimate = watched.estimate()
            assert estimate is not None
            if estimate.t0 < 1000.0 < estimate.t1:
                outcomes.append(estimate.outcome)
                jumps.append({name: size for jump in estimate.jumps
                              for name, size in jump.sizes.items()})  # fmt: skip
    assert len(outcomes) == 5 and set(outcomes) <= {Outcome.CONVERGED, Outcome.AT_BOUND}
    for sizes in jumps:
        assert sizes == pytest.approx({'p1': -0.3, 'p2': -0.5}, abs=0.02)


def test_windows_of_a_discrete_model_are_those_of_its_nodes() -> None:
    """Jitter, outputs that are missing, every 50th output between nodes."""
    u = pushes(301)
    u[25::50] = u[24::50]  # inputs between nodes act from the next one on
    states, y = course(u, noise=0.01)
    y[np.random.default_rng(1).random(301) < 0.3] = np.nan
    y[[0, 100, 200, 300]] = course(u)[1][[0, 100, 200, 300]]
    offsets = np.random.default_rng(2).uniform(-0.05, 0.05, 301)
    offsets[0], offsets[25::50] = 0.0, 0.3
    observer = SlidingWindowObserver(ARX, duration=10.0, noise={'y': 0.01})
    found = run(observer, nodes(u, y, offsets, since=5 * S))
    assert len(found) == 3
    dropped = int(np.isfinite(y[25::50]).sum())
    assert observer.counts['off_grid'] == dropped + 6  # and inputs
    for k, estimate in enumerate(found, 1):
        assert estimate.outcome is Outcome.CONVERGED
        assert estimate.parameters == pytest.approx({'a1': A[0], 'a2': A[1], 'b': B}, abs=0.02)
        assert abs(estimate.stamp - (5 * S + k * 10 * S)) <= 0.1 * PERIOD * S
        assert list(estimate.state.values()) == pytest.approx(states[100 * k], abs=0.03)
