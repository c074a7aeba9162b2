"""Tests of obs_ros.horizon.bases."""

import numpy as np
import pytest
from plants import LAG, square_wave

from obs_ros import Outcome, Record, solve_window
from obs_ros.core.deadline import Deadline
from obs_ros.core.rng import random_generator
from obs_ros.horizon.bases import Bases
from obs_ros.horizon.cleaning import rescaled_to_residuals
from obs_ros.horizon.disturbance import explain_by_process_noise
from obs_ros.horizon.forecasts import Basis
from obs_ros.horizon.moving_horizon import MovingHorizon
from obs_ros.horizon.settings import EstimationSettings
from obs_ros.horizon.solver import Solver
from obs_ros.inference.assessment.deviations import Deviations
from obs_ros.inference.assessment.informed_subspace import marginal_information
from obs_ros.inference.assessment.uncertainty import Uncertainty
from obs_ros.inference.jumps.hypothesis import hypothesis_at
from obs_ros.inference.jumps.piecewise import PiecewiseProblem

K, TAU, SIGMA, INTERVAL, NODES = 1.2, 3.0, 0.02, 0.1, 400


def pushed(seed: int, colour: float = 0.0) -> tuple[Record, float]:
    """A lag whose state is pushed about, the push correlated from sample to sample."""
    rng = np.random.default_rng([seed, 12])
    t = INTERVAL * np.arange(NODES)
    u = square_wave(t) * np.repeat(rng.uniform(0.5, 1.5, NODES // 30 + 1), 30)[:NODES]
    hold, x, push = np.exp(-INTERVAL / TAU), np.empty(NODES), 0.0
    x[0] = 0.5
    for k in range(NODES - 1):
        push = colour * push + np.sqrt(1.0 - colour**2) * rng.standard_normal()
        x[k + 1] = K * u[k] + (x[k] - K * u[k]) * hold + 0.03 * push
    return Record(t, u, x + SIGMA * rng.standard_normal(NODES)), float(x[-1])


def bases(record: Record) -> Bases:
    solver = Solver.of(LAG, EstimationSettings())
    solver.prepare()
    window = solver.pose(record, noise_known=False)
    window, found = solver.fit(window, window.objective, random_generator(1), Deadline(), None)
    window, found = rescaled_to_residuals(window, found)
    plain = hypothesis_at(PiecewiseProblem(window.objective, window.prior), found.z)
    own = explain_by_process_noise(
        window, found, plain, solver.given_noise, Deadline(), mode='auto'
    )
    assert own is not None
    return Bases(window, plain, own)


def test_each_basis_has_its_parameters_and_its_state_at_the_end() -> None:
    record, x = pushed(1)
    found = bases(record)
    own, filtered, plain = (found.ends[basis] for basis in Basis)
    np.testing.assert_array_equal(filtered.parameters, plain.parameters)
    assert abs(own.parameters[0] - plain.parameters[0]) > 0.0
    # Measurements of deviation .02 tell the filtered states; output error is off by the pushes.
    for end in (own, filtered):
        assert abs(end.state[0] - x) < 0.06
    assert abs(plain.state[0] - x) > 0.06


@pytest.mark.parametrize('basis', Basis)
def test_intervals_of_every_basis_hold_the_truth(basis: Basis) -> None:
    inside = np.zeros((40, 3))
    for seed in range(40):
        record, x = pushed(seed)
        window = bases(record).window(basis)
        best = window.hypothesis
        uncertainty = window.added_to(
            Uncertainty(best, best.covariance, marginal_information(best, 1))
        )
        told = Deviations.of(best, uncertainty.covariance, 1.0, uncertainty.end)
        p = best.problem.objective.unknowns.values(best.point[None])[1]
        errors = [*(p[:, 0] - [K, TAU]), best.trajectory[0][-1, 0] - x]
        deviations = [*told.parameters, *told.state]
        inside[seed] = np.abs(errors) < 1.96 * np.array(deviations)
    # 38 of 40 are expected; fewer than 34 in one run of a hundred, for each of three.
    assert (inside.sum(axis=0) >= 33).all(), inside.sum(axis=0)


def test_of_a_right_model_forecasts_speak_for_process_noise() -> None:
    chosen = [bases(pushed(seed)[0]).by_cross_validation() for seed in range(10)]
    assert set(chosen) == {Basis.PROCESS_NOISE}


def test_where_one_step_ahead_misleads_output_error_is_taken_and_said_to_be_rough() -> None:
    """Measurement noise that wanders is no push of the state, but looks like one."""
    rng = np.random.default_rng(3)
    t = INTERVAL * np.arange(NODES)
    u = square_wave(t, 6.0)
    x = np.empty(NODES)
    x[0], hold = 0.5, np.exp(-INTERVAL / TAU)
    for k in range(NODES - 1):
        x[k + 1] = K * u[k] + (x[k] - K * u[k]) * hold
    noise = np.empty(NODES)
    noise[0] = 0.0
    for k in range(NODES - 1):
        noise[k + 1] = 0.9 * noise[k] + 0.1 * rng.standard_normal()
    found = solve_window(LAG, Record(t, u, x + noise), seed=1)
    plain = solve_window(LAG, Record(t, u, x + noise), seed=1, process_noise='off')
    assert found.outcome in (Outcome.APPROXIMATE, Outcome.CONVERGED)
    # Whichever is taken, its deviations hold the truth.
    for name, truth in (('k', K), ('tau', TAU)):
        assert abs(found.parameters[name] - truth) < 3.0 * found.stddev[name]
        assert found.stddev[name] > plain.stddev[name] / 3.0


def test_in_sequence_output_error_keeps_its_own_optimum() -> None:
    """A lag whose measurement noise wanders slowly: near forecasts are those of output error."""
    rng = np.random.default_rng(5)
    t = INTERVAL * np.arange(8 * NODES)
    u = square_wave(t, 6.0)
    x, noise = np.empty(t.size), np.zeros(t.size)
    x[0], hold = 0.5, np.exp(-INTERVAL / TAU)
    for k in range(t.size - 1):
        x[k + 1] = K * u[k] + (x[k] - K * u[k]) * hold
        noise[k + 1] = 0.98 * noise[k] + 0.02 * rng.standard_normal()
    solver = Solver.of(LAG, EstimationSettings())
    solver.prepare()
    windows = MovingHorizon(solver)
    windows.forecasts.basis, windows.forecasts.begun = Basis.OUTPUT_ERROR, True
    compared = 0
    for i, first in enumerate(range(0, 4 * NODES, NODES // 2)):
        part = slice(first, first + NODES)
        record = Record(t[part], u[part], (x + noise)[part])
        found = windows.solve(record, random_generator(0, i), Deadline())
        plain = solve_window(LAG, record, seed=1, process_noise='off')
        if windows.forecasts.basis is Basis.OUTPUT_ERROR and found.walks:
            for name in ('k', 'tau'):
                assert found.parameters[name] == pytest.approx(plain.parameters[name], rel=0.01)
                compared += 1
    assert compared >= 4
