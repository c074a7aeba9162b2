"""Tests of obs_ros.horizon.stepping: steps that no user chooses."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from stiff_plants import KINKED, MOTOR, ROBERTSON, integration_error, measured, van_der_pol

from obs_ros import Record, solve_window
from obs_ros.core.estimate import Outcome
from obs_ros.horizon.integration_error import Answer
from obs_ros.horizon.settings import EstimationSettings
from obs_ros.horizon.solver import Solver
from obs_ros.horizon.stepping import Stepping, nominal, spread_over_box
from obs_ros.inference.prior import Prior
from obs_ros.models.three_tank import THREE_TANK

NOTHING = np.empty((200, 0))
T = np.arange(200.0)


def drive(t: Any) -> Any:
    return np.sign(np.sin(5.0 * t))[:, None]


def crossing(t: Any) -> Any:
    return 0.3 * np.column_stack([np.sin(0.11 * t) > 0, np.sin(0.11 * t) < 0])


CASES = {
    'motor': (MOTOR, 0.01 * T, drive(0.01 * T), (0.0, 0.0), (1.3, 0.07), 'rosenbrock', 'LSODA'),
    'smooth': (van_der_pol(1.0), 0.1 * T, NOTHING, (2.0, 0.0), (1.2,), 'rk4', 'DOP853'),
    'relaxing': (van_der_pol(10.0), 0.1 * T, NOTHING, (2.0, 0.0), (11.0,), 'rk4', 'DOP853'),
    'robertson': (
        ROBERTSON, np.append(0.0, np.geomspace(1e-4, 1e4, 99)), np.empty((100, 0)),
        (1.0, 0.0, 0.0), (0.05,), 'rosenbrock', 'Radau',
    ),
    'kinked': (KINKED, T, crossing(T), (20.0, 18.0), (1.0,), 'rk4', 'DOP853'),
}  # fmt: skip


@pytest.mark.parametrize('name', list(CASES))
def test_an_answer_errs_by_less_than_three_tenths_of_the_noise(name: str) -> None:
    model, t, u, x0, p, method, by = CASES[name]
    share = 1e-3 if name == 'kinked' else 1e-2
    record, noise = measured(model, t, u, x0, p, share, by=by)
    for given in (noise, None):
        estimate = solve_window(model, record, noise=given, seed=1, process_noise='off')
        error = integration_error(model, estimate, u, given or estimate.output_rms, by=by)
        assert error < 0.3
        assert estimate.figures['integration_error_sd'] == pytest.approx(error, rel=0.5, abs=0.02)
        assert f'integration_steps.{method}' in estimate.figures
        for variable, value in zip(model.parameters, p, strict=True):
            off = abs(estimate.parameters[variable.name] - value)
            assert off < 4.0 * estimate.stddev[variable.name]


@pytest.mark.parametrize(('interval', 'share'), [(0.3, 0.02), (0.3, 0.05), (0.5, 0.2)])
def test_small_errors_that_are_alike_move_no_estimate(interval: float, share: float) -> None:
    """1500 samples, each of which errs by less than a tenth of the noise."""
    model, t = van_der_pol(1.0), interval * np.arange(1500)
    record, _ = measured(model, t, np.empty((1500, 0)), (2.0, 0.0), (1.2,), share, by='DOP853')
    found, exact = (
        solve_window(each, record, seed=1, process_noise='off')
        for each in (model, replace(model, max_step=interval / 16.0))
    )
    off = found.parameters['mu'] - exact.parameters['mu']
    assert abs(off) < 0.3 * exact.stddev['mu']
    assert found.outcome is Outcome.CONVERGED


def test_where_rk4_does_nothing_changes_by_the_choice() -> None:
    t = np.arange(120.0)
    u = np.column_stack([30.0 + 20.0 * np.sign(np.sin(0.1 * t)), np.full(120, 30.0)])
    record, noise = measured(THREE_TANK, t, u, (40.0, 20.0, 30.0), (0.8, 0.7, 0.9))
    explicit = replace(THREE_TANK, integrator='rk4')
    for given in (noise, None):
        found = [solve_window(m, record, noise=given, seed=3) for m in (THREE_TANK, explicit)]
        np.testing.assert_equal(found[0].parameters, found[1].parameters)
        np.testing.assert_equal(found[0].stddev, found[1].stddev)  # NaN is NaN
        assert found[0].figures['integration_steps.rk4'] == 1.0


def test_a_max_step_is_only_an_upper_limit() -> None:
    model = replace(MOTOR, max_step=2e-3)
    record, noise = measured(MOTOR, 0.01 * T, drive(0.01 * T), (0.0, 0.0), (1.3, 0.07))
    estimate = solve_window(model, record, noise=noise)
    assert estimate.figures['integration_steps.rosenbrock'] >= 5.0
    given = solve_window(replace(MOTOR, integrator='rk4'), record, noise=noise)
    assert given.figures['integration_steps.rk4'] > 30.0
    assert given.parameters['R'] == pytest.approx(1.3, abs=4 * given.stddev['R'])


def test_the_same_seed_gives_the_same_bits() -> None:
    record, _ = measured(MOTOR, 0.01 * T, drive(0.01 * T), (0.0, 0.0), (1.3, 0.07))
    first, second = (solve_window(MOTOR, record, seed=5) for _ in range(2))
    assert first.parameters == second.parameters and first.stddev == second.stddev


def test_windows_go_on_with_the_steps_of_the_one_before() -> None:
    solver = Solver.of(MOTOR, EstimationSettings(process_noise='off'))
    record, _ = measured(MOTOR, 0.01 * T, drive(0.01 * T), (0.0, 0.0), (1.3, 0.07))
    posed = solver.pose(record, prior=Prior.box(solver.unknowns), noise_known=False)
    grid = posed.objective.grid
    steps = np.where(np.arange(199) < 99, 4, 2)
    window = replace(posed, objective=replace(posed.objective, grid=grid.stepped(steps)))
    before = Stepping.of(Answer(window.objective, None))
    assert not before.plain and before.usual == pytest.approx(0.005)
    later = Record(record.t + 0.5, record.u, record.y)
    moved = solver.pose(later, prior=Prior.box(solver.unknowns), noise_known=False).objective.grid
    np.testing.assert_array_equal(before.steps(moved), np.where(np.arange(199) < 49, 4, 2))
    assert before.between.max_step == pytest.approx(0.005, rel=0.2)
    plain = Stepping.of(Answer(posed.objective, None))
    assert plain.plain and plain.steps(moved) is moved.steps and plain.between is MOTOR


def test_what_no_steps_can_follow_is_not_told_as_if_they_did() -> None:
    # A switch in every few milliseconds, between samples: chaos at 1e-3 of the noise.
    model = replace(
        van_der_pol(1.0), name='switching',
        dynamics=lambda t, x, u, p: (x[1], p[0] * np.sign(np.sin(1e4 * x[0])) * 50.0 - x[0]),
    )  # fmt: skip
    t = 0.1 * np.arange(30)
    y = np.cos(t)[:, None] + 1e-3 * np.random.default_rng(1).standard_normal((30, 1))
    estimate = solve_window(model, Record(t, np.empty((30, 0)), y), noise={'x': 1e-3})
    far = estimate.residual_rms / 1e-3
    assert estimate.figures['integration_error_sd'] > 0.3 * max(1.0, far)
    assert estimate.outcome is not Outcome.CONVERGED
    assert 'smooth what switches in the model' in estimate.message
    assert np.isnan(list(estimate.stddev.values())).all()


def test_the_reference_is_nominal_and_the_spread_is_over_the_whole_box() -> None:
    solver = Solver.of(THREE_TANK)
    assert nominal(solver.unknowns)['p1'] == 1.0
    assert np.isnan(nominal(solver.unknowns)['h1'])
    points = spread_over_box(4)
    assert points.shape == (15, 4) and points is spread_over_box(4)
    np.testing.assert_allclose(np.sort(points, axis=0)[:, 0], (np.arange(15) + 0.5) / 15)
