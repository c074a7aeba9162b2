"""Tests of obs_ros.horizon.search: windows whose outputs wrap, as solved from the front door."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from spinner import SHAFT, TRUTH, TURN, UNWRAPPED, shaft, truth, window

from obs_ros import Estimate, Model, Outcome, Record, Variable, solve_window
from obs_ros.core.deadline import Deadline
from obs_ros.horizon.search import searched
from obs_ros.inference.objective import Objective
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid
from obs_ros.optimization.methods import method_for

STRAIGHT = shaft(None)  # the same bounds, which only the start of a window keeps here
SAME = 1e-3  # of deviations: wherever a search comes from, its fit ends at one optimum
NOISE = {'angle': 0.02, 'tenth': 0.1}
CAR = Path(__file__).parents[3] / 'shared' / 'data' / 'car_yaw.csv'


def off(found: Estimate, other: Estimate) -> float:
    """The largest difference of parameters, in deviations of the other's."""
    return max(
        abs(found.parameters[name] - value) / other.stddev[name]
        for name, value in other.parameters.items()
        if np.isfinite(other.stddev[name])
    )


def from_truth(found: Estimate) -> float:
    """The largest error of the parameters, in their deviations."""
    return max(abs(found.parameters[name] - value) / found.stddev[name]
               for name, value in TRUTH.items())  # fmt: skip


@pytest.mark.parametrize('known', [True, False])
@pytest.mark.parametrize('plant', [{}, {'torque': 4.0}, {'rate': 30.0}, {'rate': -30.0}])
def test_a_wrapped_angle_gives_the_parameters_of_one_without_wraps(
    plant: Any, *, known: bool
) -> None:
    """One crossing, and some 5 to 12 turns."""
    wrapped, plain, states = window(**plant)
    noise = NOISE if known else None
    found, expected = (
        solve_window(model, record, seed=1, noise=noise)
        for model, record in ((SHAFT, wrapped), (STRAIGHT, plain))
    )
    assert found.outcome is Outcome.CONVERGED
    assert off(found, expected) < SAME and found.cost == pytest.approx(expected.cost, rel=1e-4)
    assert abs(np.ptp(states[:, 0])) > 4.0
    true = states[-1, 0]
    assert -np.pi <= found.state['angle'] < np.pi
    assert np.cos(found.state['angle'] - true) == pytest.approx(1.0, abs=1e-3)
    low, high = found.interval['angle']
    assert low < found.state['angle'] < high < low + 0.2
    np.testing.assert_array_equal(found.states[-1], list(found.state.values()))
    assert np.abs(np.diff(found.states[:, 0])).max() < 2.0, 'free of wraps inside the window'


def test_starts_that_are_whole_turns_apart_are_the_same() -> None:
    wrapped, plain, _ = window(torque=4.0)
    found = solve_window(SHAFT, wrapped, seed=1, noise=NOISE)
    for turns in (-7, 3):
        moved = plain.y + np.array([turns * TURN, 0.0])
        other = solve_window(SHAFT, Record(plain.t, plain.u, moved), seed=1, noise=NOISE)
        assert off(other, found) < 1e-6
        assert other.state['angle'] == pytest.approx(found.state['angle'], abs=1e-9)


@pytest.mark.parametrize('known', [True, False])
@pytest.mark.parametrize('given', [{}, {'process_noise': 'given', 'walks': {'rate': 0.47}}])
def test_under_process_noise_a_wrapped_angle_gives_the_same_too(given: Any, *, known: bool) -> None:
    """Torques that nobody measured push the shaft about."""
    t = 0.05 * np.arange(81)
    torque, rng = 5.0 * np.sin(3.0 * t), np.random.default_rng(5)
    states = truth(t, torque + 0.7 * rng.standard_normal(t.size), 2.8, 0.0)
    y = np.full((t.size, 2), np.nan)
    y[:, 0] = states[:, 0] + NOISE['angle'] * rng.standard_normal(t.size)
    wrapped = y - [TURN, 0.0] * np.round(y / TURN)
    assert np.ptp(wrapped[:, 0]) > 5.5
    noise = NOISE if known else None
    found, expected = (
        solve_window(model, Record(t, torque, each), seed=1, noise=noise, **given)
        for model, each in ((SHAFT, wrapped), (UNWRAPPED, y))
    )
    assert found.outcome is expected.outcome and max(found.walks.values()) > 0.0
    assert off(found, expected) < SAME and np.isfinite(expected.stddev['k'])


@pytest.mark.parametrize(('lower', 'upper'), [(0.0, TURN), (-np.inf, np.inf), (1.5, 4.5)])
def test_bounds_hold_for_the_start_and_modulo_the_period(lower: float, upper: float) -> None:
    """The shaft starts at 2.8 and turns on; 1.5 to 4.5 is less than a period."""
    wrapped, _, _ = window()
    expected = solve_window(SHAFT, wrapped, seed=1, noise=NOISE)
    found = solve_window(shaft(lower=lower, upper=upper), wrapped, seed=1, noise=NOISE)
    assert found.outcome is Outcome.CONVERGED and off(found, expected) < SAME
    assert found.initial_state['angle'] == pytest.approx(2.8, abs=0.1)


def test_bounds_of_less_than_a_period_exclude_the_rest() -> None:
    wrapped, _, _ = window()
    found = solve_window(shaft(lower=-1.0, upper=1.0), wrapped, seed=1, noise=NOISE)
    assert found.outcome is not Outcome.CONVERGED
    assert -1.0 <= found.initial_state['angle'] <= 1.0


def test_an_angle_that_hovers_at_half_a_turn_with_much_noise() -> None:
    wrapped, plain, _ = window(np.pi, swing=1.0, noise=0.4)
    assert np.abs(np.diff(wrapped.y[:, 0])).max() > 4.0, 'it wraps again and again'
    noise = {**NOISE, 'angle': 0.4}
    found = solve_window(SHAFT, wrapped, seed=1, noise=noise)
    expected = solve_window(STRAIGHT, plain, seed=1, noise=noise)
    assert found.cost == pytest.approx(expected.cost, rel=1e-3)
    turns = (found.state['angle'] - expected.state['angle']) / TURN
    assert turns == pytest.approx(round(turns), abs=0.01)
    assert found.parameters['k'] == pytest.approx(expected.parameters['k'], rel=0.05)


def test_in_a_gap_the_model_decides_how_far_the_shaft_turned() -> None:
    """Over 0.75 s at some 28 rad/s: more than two turns, of which the sensor knows nothing."""
    wrapped, plain, states = window(rate=28.0)
    y, true = wrapped.y.copy(), plain.y.copy()
    y[20:35] = true[20:35] = np.nan
    assert abs(states[35, 0] - states[19, 0]) > 2.3 * TURN
    found = solve_window(SHAFT, Record(wrapped.t, wrapped.u, y), seed=1, noise=NOISE)
    expected = solve_window(STRAIGHT, Record(plain.t, plain.u, true), seed=1, noise=NOISE)
    assert found.outcome is Outcome.CONVERGED
    assert off(found, expected) < 0.01 and from_truth(found) < 3.0


def test_an_outlier_of_half_a_turn_leads_no_other_sample_astray() -> None:
    wrapped, _, _ = window()
    y = wrapped.y.copy()
    y[30, 0] += 3.1 if y[30, 0] < 0.0 else -3.1
    found = solve_window(SHAFT, Record(wrapped.t, wrapped.u, y), seed=1, noise=NOISE)
    assert found.outcome is Outcome.CONVERGED and from_truth(found) < 3.0
    assert '1 outlier' in found.message


def two_compasses(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any]:
    return x[0], x[0] + p[1]


def turning(t: Any, x: Any, u: Any, p: Any) -> tuple[Any]:
    return (p[0] * u[0],)


def test_two_sensors_of_one_angle_need_not_wrap_together() -> None:
    """At half a turn one says pi, the other -pi."""
    outputs = tuple(Variable(name, 'rad', period=TURN) for name in ('one', 'other'))
    model = Model(
        'compasses', states=(Variable('yaw', 'rad', -np.pi, np.pi, period=TURN),), outputs=outputs,
        inputs=(Variable('rate'),), dynamics=turning, output=two_compasses, max_step=0.05,
        parameters=(Variable('gain', lower=0.1, upper=3.0), Variable('offset', 'rad', -0.5, 0.5)),
    )  # fmt: skip
    t = 0.05 * np.arange(60)
    u = np.sin(2.0 * t)
    yaw = np.pi + 0.15 + np.concatenate([[0.0], np.cumsum(0.05 * 1.2 * u[:-1])])
    y = yaw[:, None] + [0.0, -0.3] + 0.02 * np.random.default_rng(3).standard_normal((60, 2))
    wrapped = (y + np.pi) % TURN - np.pi
    assert np.ptp(wrapped[0]) > 5.5
    noise = {'one': 0.02, 'other': 0.02}
    found = solve_window(model, Record(t, u, wrapped), seed=1, noise=noise, backend='numpy')
    assert found.outcome is Outcome.CONVERGED
    for name, value in (('gain', 1.2), ('offset', -0.3)):
        assert abs(found.parameters[name] - value) < 3.0 * found.stddev[name]


def test_without_periods_the_search_is_the_method_s_own() -> None:
    """Bit by bit, and with one search only."""
    record = window()[1]
    method, settings = method_for('memetic')
    objective = Objective(
        kernels_for(STRAIGHT, 'numpy'), Grid.of(STRAIGHT, record, np.array([0.02, 0.1])),
        Unknowns.of(STRAIGHT),
    )  # fmt: skip
    found = searched(
        method, settings, objective, np.random.default_rng(1), Deadline(None), None, True
    )
    own = method.search(
        replace(objective), np.random.default_rng(1), Deadline(None), settings, None, True
    )
    np.testing.assert_array_equal(found.z, own.z)
    assert found.cost == own.cost


def car_dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any]:
    return (p[0] * u[1] * np.tan(u[0] + p[1]),)


def car_output(t: Any, x: Any, u: Any, p: Any) -> tuple[Any]:
    return (x[0],)


def car(period: float | None, bound: float) -> Model:
    """The kinematic single track: gain is one over the wheelbase."""
    yaw = Variable('yaw', 'rad', -bound, bound, period=period)
    return Model(
        'car', states=(yaw,), outputs=(Variable('yaw', 'rad', period=period),),
        inputs=(Variable('steer', 'rad'), Variable('vx', 'm/s')), dynamics=car_dynamics,
        parameters=(Variable('gain', '1/m', 0.05, 10.0), Variable('offset', 'rad', -0.5, 0.5)),
        output=car_output, max_step=0.02,
    )  # fmt: skip


@pytest.mark.skipif(not CAR.exists(), reason='the recording of a car is not here')
def test_a_recording_of_a_car_with_nine_wraps() -> None:
    """Windows of 3 s, wrapped, unwrapped, and unwrapped from three turns on."""
    rows = np.genfromtxt(CAR, delimiter=',', names=True)
    plain = np.unwrap(rows['yaw'])
    assert np.count_nonzero(np.abs(np.diff(rows['yaw'])) > np.pi) == 9
    u = np.c_[rows['steer'], rows['vx']]
    worst, compared = 0.0, 0
    for first in range(0, rows.size - 151, 150):
        part = slice(first, first + 151)
        begun = plain - TURN * np.round(plain[first] / TURN)
        estimates = [
            solve_window(
                model, Record(rows['t'][part], u[part], y[part]), seed=1, process_noise='off',
                noise={'yaw': 0.2},
            )
            for model, y in (
                (car(None, np.pi), begun), (car(TURN, np.pi), rows['yaw']),
                (car(TURN, np.pi), plain + 3.0 * TURN),
            )
        ]  # fmt: skip
        expected, *others = estimates
        known = [name for name in expected.parameters if np.isfinite(expected.stddev[name])]
        for found in others:
            assert found.cost == pytest.approx(expected.cost, rel=1e-4)
            for name in known:
                error = abs(found.parameters[name] - expected.parameters[name])
                worst, compared = max(worst, error / expected.stddev[name]), compared + 1
    assert compared >= 6
    assert worst < 1e-3
