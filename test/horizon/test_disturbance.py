"""Tests of obs_ros.horizon.disturbance, by way of the front door and of windows in sequence."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from plants import LAG, square_wave
from scipy.signal import lfilter

from obs_ros import Outcome, Record, solve_window
from obs_ros.core.deadline import Deadline
from obs_ros.core.rng import random_generator
from obs_ros.core.typing import Array
from obs_ros.horizon.moving_horizon import MovingHorizon
from obs_ros.horizon.settings import EstimationSettings
from obs_ros.horizon.solver import Solver
from obs_ros.optimization.memetic import MemeticSettings, memetic_search
from obs_ros.optimization.methods import Method

K, TAU, SIGMA, WALK = 1.2, 3.0, 0.02, 0.1
INTERVAL = 0.1


def record(nodes: int = 400, walk: float = WALK, seed: int = 0) -> Record:
    return pushed(nodes, walk, seed)[0]


def pushed(nodes: int, walk: float = WALK, seed: int = 0) -> tuple[Record, Array]:
    """A record of the lag, and its state (nodes,)."""
    rng = np.random.default_rng([seed, 7])
    t = INTERVAL * np.arange(nodes)
    u = square_wave(t) * np.repeat(rng.uniform(0.5, 1.5, nodes // 30 + 1), 30)[:nodes]
    hold = np.exp(-INTERVAL / TAU)
    push = walk * np.sqrt(0.5 * TAU * (1.0 - hold**2))
    x = np.empty(nodes)
    x[0] = 0.5
    for k in range(nodes - 1):
        x[k + 1] = K * u[k] + (x[k] - K * u[k]) * hold + push * rng.standard_normal()
    return Record(t, u, x + SIGMA * rng.standard_normal(nodes)), x


def test_off_a_pushed_plant_is_a_mismatch_and_auto_it_is_explained_with_deviations() -> None:
    off = solve_window(LAG, record(), seed=1, process_noise='off')
    assert off.outcome is Outcome.MODEL_MISMATCH
    found = solve_window(LAG, record(), seed=1, process_noise='auto')
    assert found.outcome is Outcome.CONVERGED
    assert found.message.startswith('process noise explains the residual; forecasts an eighth')
    assert 'pushed about by what the model leaves out: x by 0.1' in found.message
    for name, truth in (('k', K), ('tau', TAU)):
        assert abs(found.parameters[name] - truth) < 3.0 * found.stddev[name] < 1.5
    assert 0.5 * SIGMA < found.stddev['x'] < 2.0 * SIGMA
    assert found.walks['x'] == pytest.approx(WALK, rel=0.3) and found.walks['tau'] == 0.0
    assert found.noise['y'] == pytest.approx(SIGMA, rel=0.5)
    deviations = np.sqrt(np.diagonal(found.covariance))
    np.testing.assert_allclose(deviations, [found.stddev[name] for name in ('x', 'k', 'tau')])
    assert found.output_rms['y'] == pytest.approx(np.hypot(SIGMA, WALK * INTERVAL**0.5), rel=0.25)


@pytest.mark.parametrize('given', [True, False])
@pytest.mark.parametrize('seed', range(3))
def test_noise_of_a_sensor_that_filters_is_no_push_of_the_states(seed: int, given: bool) -> None:
    plain, states = pushed(400, walk=0.0, seed=seed)
    white = np.random.default_rng([seed, 9]).standard_normal(400)
    coloured = Record(plain.t, plain.u, states + SIGMA * lfilter([0.8], [1.0, -0.6], white))
    found = solve_window(LAG, coloured, seed=1, noise={'y': SIGMA} if given else None)
    assert not found.walks and 'not white, its lag-1 correlation is 0.' in found.message
    for name, truth in (('k', K), ('tau', TAU)):
        assert abs(found.parameters[name] - truth) < 3.0 * found.stddev[name] < 0.2


@pytest.mark.parametrize('mode', ['auto', 'off'])
def test_an_exact_plant_is_solved_as_without(mode: Any) -> None:
    plain = solve_window(LAG, record(walk=0.0), seed=1, process_noise='off')
    found = solve_window(LAG, record(walk=0.0), seed=1, process_noise=mode)
    assert found.parameters == plain.parameters and found.stddev == plain.stddev
    assert (found.message, found.evaluations) == (plain.message, plain.evaluations)
    assert not found.walks and found.noise['y'] == pytest.approx(SIGMA, rel=0.15)


def test_given_walks_are_used_whatever_the_residual() -> None:
    walking = replace(LAG, states=(replace(LAG.states[0], walk=WALK),))
    found = solve_window(walking, record(), seed=1, process_noise='given')
    assert 'x by 0.1' in found.message
    auto = solve_window(LAG, record(), seed=1, process_noise='auto')
    assert found.parameters['k'] == pytest.approx(auto.parameters['k'], rel=0.05)


@pytest.mark.parametrize(
    ('settings', 'message'),
    [
        ({'process_noise': 'atuo'}, "unknown process_noise 'atuo': did you mean 'auto'"),
        ({'process_noise': 'given'}, "give a state of model 'lag' a walk"),
        ({'process_noise': 'given', 'search': 'ga'}, "set process_noise to 'off', not 'given'"),
    ],
)
def test_wrong_settings_are_refused(settings: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        solve_window(LAG, record(60), **settings)


def test_windows_in_sequence_hand_on_what_they_learned_and_hold_the_truth() -> None:
    long = record(2400, seed=3)
    solver = Solver.of(LAG, EstimationSettings(process_noise='auto'))
    solver.prepare()
    windows = MovingHorizon(solver)
    found = []
    for i, first in enumerate(range(0, 2400, 400)):
        part = slice(first, first + 400)
        window = Record(long.t[part], long.u[part], long.y[part])
        found.append(windows.solve(window, random_generator(0, i), Deadline()))
    assert {one.outcome for one in found} == {Outcome.CONVERGED}
    assert not any(one.jumps for one in found)
    for name, truth in (('k', K), ('tau', TAU)):
        errors = [abs(one.parameters[name] - truth) / one.stddev[name] for one in found]
        assert max(errors) < 3.5
        assert found[-1].stddev[name] < 0.7 * found[0].stddev[name]


def drifting(seed: int, walk: float) -> tuple[Record, float]:
    """A lag whose gain walks, stepped ten times in an interval; its record and last gain."""
    rng = np.random.default_rng([seed, 11])
    t = INTERVAL * np.arange(400)
    u = square_wave(t) * np.repeat(rng.uniform(0.5, 1.5, 14), 30)[:400]
    x, k, step, values = 0.5, K, INTERVAL / 10, []
    for i in range(400):
        values.append(x)
        gain = k
        for _ in range(10):
            x += step * (k * u[i] - x) / TAU
            k += walk * np.sqrt(step) * rng.standard_normal()
    return Record(t, u, np.array(values) + SIGMA * rng.standard_normal(400)), gain


def test_a_parameter_walks_inside_its_window_and_is_told_as_it_is_at_the_end() -> None:
    gain, tau = LAG.parameters
    walking = replace(LAG, parameters=(replace(gain, walk=0.1), tau))
    errors, naive = [], []
    for seed in range(40):
        record, k = drifting(seed, 0.1)
        found = solve_window(walking, record, seed=1)
        assert found.outcome in (Outcome.CONVERGED, Outcome.APPROXIMATE)
        assert found.walks['k'] == pytest.approx(0.1)
        errors.append((found.parameters['k'] - k) / found.stddev['k'])
        naive.append(solve_window(LAG, record, seed=1, process_noise='off').parameters['k'] - k)
        assert abs(found.parameters['k'] - k) < 0.5
    inside = np.mean(np.abs(errors) < 1.96)
    assert 0.85 <= inside <= 1.0  # 38 of 40 expected, 34 in one run of a hundred
    assert np.sqrt(np.mean(np.square(naive))) > 0.3  # constant, the gain is an average


def test_windows_in_sequence_follow_a_parameter_that_walks() -> None:
    gain, tau = LAG.parameters
    walking = replace(LAG, parameters=(replace(gain, walk=0.1), tau))
    record, _ = drifting(3, 0.1)
    solver = Solver.of(walking, EstimationSettings())
    solver.prepare()
    windows = MovingHorizon(solver)
    alone, handed = [], []
    for i, first in enumerate((0, 100, 200)):
        part = slice(first, first + 200)
        window = Record(record.t[part], record.u[part], record.y[part])
        handed.append(windows.solve(window, random_generator(0, i), Deadline()))
        alone.append(solve_window(walking, window, seed=1))
    last, other = handed[-1], alone[-1]
    assert abs(last.parameters['k'] - other.parameters['k']) < 2.0 * other.stddev['k']
    assert last.stddev['tau'] < other.stddev['tau']


def test_without_time_for_process_noise_the_outcome_says_so(monkeypatch: Any) -> None:
    def late(*arguments: Any) -> Any:
        found = memetic_search(*arguments)
        monkeypatch.setattr(Deadline, 'passed', True)
        return found

    method = Method(late, MemeticSettings, needs_squares=True)
    found = solve_window(LAG, record(), method, seed=1)
    assert found.outcome is Outcome.DEADLINE
    assert 'jumps or process noise' in found.message


def test_the_path_is_smoothed_by_all_of_the_window() -> None:
    """Between its measurements a state is nearer to the truth than the filtered one can be."""
    rng = np.random.default_rng(5)
    t = INTERVAL * np.arange(400)
    u, hold = square_wave(t), np.exp(-INTERVAL / TAU)
    x = np.empty(400)
    x[0] = 0.5
    for k in range(399):
        x[k + 1] = K * u[k] + (x[k] - K * u[k]) * hold + 0.03 * rng.standard_normal()
    found = solve_window(LAG, Record(t, u, x + 0.1 * rng.standard_normal(400)), seed=1)
    assert found.walks['x'] > 0.0
    smooth = np.sqrt(np.mean((found.states[:, 0] - x) ** 2))
    assert smooth < 0.05  # filtered, .055; measured, .1
    assert found.states[-1, 0] == pytest.approx(found.state['x'])
    assert found.states[0, 0] == pytest.approx(found.initial_state['x'], abs=1e-6)


@pytest.mark.parametrize('seed', [0, 1, 2])
def test_outliers_of_a_pushed_plant_are_left_out(seed: int) -> None:
    """Where the filter follows the outputs closely, it answers each of them; one is the last."""
    clean, x = pushed(400, seed=seed)
    y, places = clean.y.copy(), np.array([60, 101, 180, 260, 399])
    y[places, 0] += SIGMA * np.array([30.0, -25.0, 12.0, -40.0, 20.0])
    spoiled = clean.with_outputs(y)
    wanted, found = (solve_window(LAG, one, seed=1) for one in (clean, spoiled))
    squares = solve_window(LAG, spoiled, seed=1, loss='squares')
    assert 'outliers of y at ' in found.message
    assert found.noise['y'] == pytest.approx(wanted.noise['y'], rel=0.1)
    assert squares.noise['y'] > 2.5 * wanted.noise['y']
    for name in ('k', 'tau'):
        off = abs(found.parameters[name] - wanted.parameters[name])
        assert off < wanted.stddev[name], name
    assert found.t1 == clean.t[398]
    assert abs(found.state['x'] - x[398]) < 2.5 * found.stddev['x']
