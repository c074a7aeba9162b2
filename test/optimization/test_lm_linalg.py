"""The compiled linear algebra of Levenberg-Marquardt."""

import numpy as np
import pytest
from plants import tank_record

from obs_ros import solve_window
from obs_ros.horizon.solver import Solver
from obs_ros.inference import parameterisation
from obs_ros.models import load_model
from obs_ros.optimization import lm_linalg


@pytest.mark.parametrize('d', [1, 3, 8])
def test_solved_is_the_solution_over_the_free_unknowns(d: int) -> None:
    rng = np.random.default_rng(d)
    root = rng.standard_normal((20, d))
    hessian, right = root.T @ root, rng.standard_normal(d)
    scale, free = np.diagonal(hessian).copy(), rng.random(d) < 0.7
    x = lm_linalg.solved(hessian, scale, 0.1, right, free)
    expected = np.zeros(d)
    damped = (hessian + 0.1 * np.diag(scale))[np.ix_(free, free)]
    expected[free] = np.linalg.solve(damped, right[free])
    assert x == pytest.approx(expected, rel=1e-10)


def test_a_singular_matrix_gives_finite_steps() -> None:
    row = np.array([[1.0, 2.0, -1.0]])
    step, gain, full_gain = lm_linalg.damped_steps(
        np.full((1, 3), 0.5),
        row.copy(),
        (row.T @ row)[None],
        np.array([1e-12]),
        np.array([[0.0] * 3, [1.0] * 3]),
        1e-6,
    )
    assert np.isfinite(step).all()
    assert gain[0] > 0.0
    assert full_gain[0] == pytest.approx(1.0, rel=1e-6)  # the residual of 1 can be undone


def test_a_better_predicted_gain_damps_less_and_a_nan_is_rejected() -> None:
    damps, growth = np.ones(3), np.full(3, 2.0)
    rejections = np.zeros(3, dtype=np.int64)
    squares, tried = np.full(3, 10.0), np.array([5.0, 9.9, np.nan])
    won = lm_linalg.judged(squares, tried, np.full(3, 5.0), damps, growth, rejections, 1.0 / 3.0)
    assert won.tolist() == [True, True, False]
    assert damps[0] == pytest.approx(1.0 / 3.0)
    assert damps[1] > 1.0
    assert (damps[2], growth[2], rejections[2]) == (2.0, 4.0, 1)


def test_everything_is_compiled_before_the_clock_starts() -> None:
    """A second signature would be compiled within the first solve's deadline."""
    pytest.importorskip('numba')
    functions = (
        lm_linalg.damped_steps,
        lm_linalg.judged,
        lm_linalg.solved,
        parameterisation._perturbed,
    )
    Solver.of(load_model('three_tank')).prepare()
    compiled = [set(function.signatures) for function in functions]  # others' tests may add some
    for options in (
        {},
        {'bounds': {'p1': (0.0, np.inf)}},
        {'parameters': ['p1'], 'states': ['h3']},
    ):
        fixed = {'h1': 50.0, 'h2': 40.0} if 'states' in options else None
        solve_window('three_tank', tank_record(), fixed=fixed, deadline=1.0, **options)
    assert [set(function.signatures) for function in functions] == compiled
