"""The compiled linear algebra of Levenberg-Marquardt."""

import numpy as np
import pytest
from plants import tank_record

from obs_ros import solve_window
from obs_ros.horizon.solver import Solver
from obs_ros.inference import parameterisation
from obs_ros.models import load_model
from obs_ros.optimization import lm_linalg
from obs_ros.optimization.levenberg_marquardt import LM_DEFAULTS


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


def started() -> tuple[np.ndarray, ...]:
    """Two starts in a valley of squares 1 + (z - 1/4)^2, the second at its bottom, undamped."""
    z = np.array([[0.5], [0.25]])
    squares, gradient = 1.0 + ((z - 0.25) ** 2)[:, 0], z - 0.25
    return z, squares, gradient, np.ones((2, 1, 1)), np.full(2, 1e-11), np.zeros(2, dtype=np.int64)


def test_a_start_at_the_bottom_is_over_and_the_other_goes_there() -> None:
    state, limits, rules = started(), np.array([[0.0], [1.0]]), LM_DEFAULTS.rules
    mark = np.full(2, np.inf)
    trial, gain, h, converged, over, number = lm_linalg.proposed(
        *state, mark, limits, 1e-4, True, rules
    )
    np.testing.assert_allclose(trial, 0.25, rtol=1e-9)
    np.testing.assert_allclose(gain, [0.0625, 0.0], atol=1e-9)
    np.testing.assert_allclose(h, LM_DEFAULTS.most_step)  # two hundredths of 1e-2 are more
    assert converged.tolist() == over.tolist() == [False, True] and number == 1
    np.testing.assert_array_equal(mark, state[1])
    growth, there = np.full(2, 2.0), np.array([1.0, np.nan])
    lm_linalg.moved(*state, growth, trial, gain, there, trial - 0.25, np.ones((2, 1, 1)), 0.1)
    assert state[0][0, 0] == trial[0, 0] and state[0][1, 0] == 0.25
    assert state[1].tolist() == [1.0, 1.0] and state[5].tolist() == [0, 1]


def test_the_last_step_is_taken_where_it_gains_enough() -> None:
    state, limits, rules = started(), np.array([[0.0], [1.0]]), LM_DEFAULTS.rules
    first = tuple(each[:1] for each in state[:4])
    for least, worth in ((0.06, True), (0.07, False)):
        trial, _, found = lm_linalg.last_step(*first, limits, least, 1e-4, rules)
        assert found is worth and trial[0, 0] == pytest.approx(0.25, rel=1e-9)
    wrong = first[0], np.array([np.nan]), *first[2:]
    assert not lm_linalg.last_step(*wrong, limits, 0.0, 1e-4, rules)[2]


def test_everything_is_compiled_before_the_clock_starts() -> None:
    """A second signature would be compiled within the first solve's deadline."""
    pytest.importorskip('numba')
    functions = (
        lm_linalg.proposed,
        lm_linalg.moved,
        lm_linalg.last_step,
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
