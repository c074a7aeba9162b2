"""Tests of obs_ros.optimization.refinement, against scipy and closed forms."""

from typing import Any

import numpy as np
import pytest
from problems import decay_problem, linear, ripples_problem, rows_of
from scipy.optimize import least_squares

from obs_ros.core.deadline import Deadline
from obs_ros.optimization.levenberg_marquardt import levenberg_marquardt
from obs_ros.optimization.refinement import refined, refined_point
from obs_ros.optimization.result import Effort, Found

NEVER = Deadline()
SAME = 2e-4  # deviations, of each of d = 3 unknowns: what is left to gain is 1e-8 d variances


def found_at(z: Any, cost: float) -> Found:
    return Found(np.array(z), cost, converged=True, accepted=None, effort=Effort(1, 'round'))


@pytest.mark.parametrize('seed', range(5))
def test_fits_from_different_starts_end_at_one_point(seed: int) -> None:
    rng = np.random.default_rng(seed)
    problem = decay_problem(tuple(rng.uniform(0.25, 0.75, 3)), seed=seed)
    exact = least_squares(
        lambda z: problem.errors(z[None])[0], np.full(3, 0.5), xtol=1e-15, ftol=1e-15, gtol=1e-15,
        x_scale='jac',
    )  # fmt: skip
    variance = 2.0 * exact.cost / (200 - 3)
    deviations = np.sqrt(variance * np.diagonal(np.linalg.inv(exact.jac.T @ exact.jac)))
    before = []
    for start in rng.uniform(0.1, 0.9, (6, 3)):
        fit = levenberg_marquardt(problem, start[None], 200, 60, NEVER)
        found = refined(problem, found_at(fit.z[0], fit.squares[0]), NEVER)
        before.append(np.abs((fit.z[0] - exact.x) / deviations).max())
        assert np.abs((found.z - exact.x) / deviations).max() < SAME
        assert found.cost <= fit.squares[0]
        assert found.cost == pytest.approx(2.0 * exact.cost, rel=1e-9)
    assert max(before) > 5.0 * SAME, 'the searches alone end apart'


def test_a_linear_problem_takes_one_step() -> None:
    problem, optimum, _ = linear()
    z, squares = refined_point(problem, optimum + 0.01, problem.nodes, NEVER)
    np.testing.assert_allclose(z, optimum, atol=1e-7)
    assert squares == pytest.approx(float(problem.costs(optimum[None])[0]), rel=1e-9)
    again, _ = refined_point(problem, z, problem.nodes, NEVER)
    assert again is z, 'an optimum stays'


def test_an_unknown_at_its_bound_stays_there() -> None:
    problem = decay_problem((0.7, 0.4, -0.2))
    fit = levenberg_marquardt(problem, np.full((1, 3), 0.5), 200, 100, NEVER)
    assert fit.z[0, 2] == 0.0
    z, squares = refined_point(problem, fit.z[0], 200, NEVER)
    exact = least_squares(
        lambda z: problem.errors(z[None])[0], np.full(3, 0.5), bounds=(0.0, 1.0), xtol=1e-15,
        ftol=1e-15, gtol=1e-15,
    )  # fmt: skip
    assert z[2] == 0.0 and squares <= fit.squares[0]
    np.testing.assert_allclose(z, exact.x, atol=1e-5)


def test_where_steps_lead_astray_the_fit_stays_as_good_as_it_was() -> None:
    """Far from any optimum of a rugged problem, and on a flat one."""
    problem = ripples_problem()
    for start in np.random.default_rng(2).random((20, 2)):
        z, squares = refined_point(problem, start, 300, NEVER)
        assert squares <= problem.costs(start[None])[0]
        assert ((z >= 0.0) & (z <= 1.0)).all()
    flat = rows_of(lambda z: np.ones((5, len(z))))
    start = np.array([0.3, 0.4])
    assert refined_point(flat, start, 5, NEVER) == (start, 5.0)


def test_what_is_not_finite_and_what_is_late_stays() -> None:
    nowhere = rows_of(lambda z: np.full((5, len(z)), np.nan))
    found = found_at([0.3, 0.4], np.inf)
    assert refined(nowhere, found, NEVER).z is found.z
    problem = decay_problem()
    late = found_at([0.6, 0.5, 0.3], 1.0)
    stayed = refined(problem, late, Deadline(0.0))
    assert stayed.z is late.z and stayed.cost == late.cost
