"""Tests of obs_ros.integration.window_steps."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from plants import OSCILLATOR, square_wave
from scipy.integrate import solve_ivp

from obs_ros import Model, Record, Variable
from obs_ros.core.typing import Array
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid
from obs_ros.integration.step_choice import chosen
from obs_ros.integration.step_trials import STEPPING
from obs_ros.integration.window_steps import Methods, WindowTrial, by_method, methods_of

COARSE = replace(OSCILLATOR, max_step=np.inf)
T = np.append(np.linspace(0.0, 4.0, 41), np.linspace(4.2, 8.0, 20))
X0, P0 = np.array([1.0, 0.0]), np.array([1.5, 0.5])


def trial(noise: float, model: Model = COARSE, backend: Any = None, spread: float = 0.0) -> Any:
    record = Record(T, square_wave(T)[:, None], np.zeros((T.size, 2)))
    grid = Grid.of(model, record, np.full(2, noise))
    rng = np.random.default_rng(1)
    x0 = X0[:, None] + spread * rng.standard_normal((2, 16))
    p = P0[:, None] * (1.0 + 0.2 * spread * rng.standard_normal((2, 16)))
    x0[:, 0], p[:, 0] = X0, P0
    return WindowTrial(Methods(model, backend), replace(grid, y=truth(grid)), x0, p)


def truth(grid: Grid) -> Array:
    """The outputs (K, r) of the reference by an independent integrator."""
    x, states = X0, [X0]
    for k in range(grid.t.size - 1):

        def rates(t: float, x: Any, k: int = k) -> Any:
            u = grid.u[k] + (t - grid.t[k]) * grid.slope[k]
            return COARSE.dynamics(t, tuple(x), tuple(u), tuple(P0))

        span = grid.t[k], grid.t[k + 1]
        x = solve_ivp(rates, span, x, method='DOP853', rtol=1e-11, atol=1e-12).y[:, -1]
        states.append(x)
    rows = zip(grid.t, states, grid.u, strict=True)
    return np.array([COARSE.output(t, tuple(x), tuple(u), tuple(P0)) for t, x, u in rows])


@pytest.mark.parametrize('backend', ['numpy', None])
def test_the_error_told_is_that_beside_the_truth(backend: Any) -> None:
    tried = trial(1e-4, backend=backend)
    kernels = tried.methods.kernels('rk4')
    for n in (1, 2, 4):
        steps = n * tried.grid.steps
        outputs = kernels.trajectories(tried.grid.stepped(steps), tried.x0, tried.p)[1]
        real = np.abs(outputs[:, :, 0] - tried.grid.y).max() / 1e-4
        assert tried.judge('rk4', steps).error == pytest.approx(real, rel=0.3)


@pytest.mark.parametrize('noise', [1e-2, 1e-4, 1e-6])
def test_chosen_steps_keep_errors_below_a_tenth_of_the_noise(noise: float) -> None:
    tried = trial(noise, spread=0.3)
    found = chosen(tried, ('rk4',), tried.grid.steps, lambda method: 1.0)
    grid = tried.grid.stepped(found.steps)
    outputs = tried.methods.kernels('rk4').trajectories(grid, tried.x0, tried.p)[1]
    assert found.fine and np.abs(outputs[:, :, 0] - grid.y).max() <= STEPPING.aimed * noise
    # Intervals twice as long take more steps.
    if noise < 1e-3:
        assert found.steps[40:].mean() > 1.3 * found.steps[:40].mean()


def test_shares_are_those_of_the_intervals_that_err() -> None:
    tried = trial(1e-4)
    steps = 8 * tried.grid.steps
    steps[12] = 1
    verdict = tried.judge('rk4', steps)
    shares = tried.shares('rk4', steps, verdict)
    assert shares.argmax() == 12
    assert shares.sum() == pytest.approx(verdict.worst(), rel=0.01)
    assert shares[12] > 0.9 * shares.sum()


def test_far_candidates_may_err_by_a_share_of_what_they_are_off() -> None:
    near, far = trial(1e-4), trial(1e-4, spread=0.5)
    steps = near.grid.steps
    assert near.judge('rk4', steps).excess[1:].max() > 20.0
    assert far.judge('rk4', steps).excess[1:].max() < 1.0


def test_what_was_not_measured_does_not_count() -> None:
    tried = trial(1e-4)
    weight = tried.grid.weight.copy()
    weight[1:] = 0.0
    blind = replace(tried, grid=replace(tried.grid, weight=weight))
    assert blind.judge('rk4', tried.grid.steps).error == 0.0


@pytest.mark.parametrize('backend', ['numpy', None])
def test_intervals_begin_anew_at_the_states_given(backend: Any) -> None:
    tried = trial(1e-4, backend=backend, spread=0.3)
    kernels = kernels_for(COARSE, backend)
    grid = tried.grid.stepped(3 * tried.grid.steps)
    states = kernels.trajectories(grid, tried.x0, tried.p)[0]
    ends = kernels.restarted(grid, states, tried.p)
    np.testing.assert_allclose(ends, states[1:], rtol=1e-12, atol=1e-14)


def test_a_model_by_another_method_or_with_shorter_steps_differs_in_nothing_else() -> None:
    assert by_method(COARSE, 'rk4') is COARSE
    shorter = by_method(COARSE, 'rk4', 0.01)
    assert shorter.max_step == 0.01 and shorter.dynamics is COARSE.dynamics
    assert by_method(shorter, 'rk4', 0.1) is shorter
    assert by_method(COARSE, 'euler').method == 'euler'
    assert methods_of('euler') == ('euler',) and methods_of('auto')[0] == 'rk4'


def test_candidates_that_diverge_exceed_what_they_may() -> None:
    escape = Model(
        'escape', (Variable('x', lower=0.0, upper=1.0),), (Variable('x'),),
        lambda t, x, u, p: (p[0] * x[0] * x[0],), lambda t, x, u, p: (x[0],),
        parameters=(Variable('p', lower=0.0, upper=1.0),),
    )  # fmt: skip
    t = np.linspace(0.0, 1.0, 41)
    grid = Grid.of(escape, Record(t, np.empty((41, 0)), np.zeros((41, 1))), np.ones(1))
    p = np.array([[0.1, 3.0]])
    verdict = WindowTrial(Methods(escape), grid, np.ones((1, 2)), p).judge('rk4', grid.steps)
    assert verdict.excess[0] < 1e-3 and verdict.excess[1] == np.inf


@pytest.mark.parametrize('backend', ['numpy', None])
def test_what_is_farther_off_than_numbers_reach_diverged(backend: Any) -> None:
    growing = Model(
        'growing', (Variable('x'),), (Variable('x'),),
        lambda t, x, u, p: (p[0] * x[0],), lambda t, x, u, p: (x[0],),
        parameters=(Variable('rate'),), integrator='rk4',
    )  # fmt: skip
    t = np.linspace(0.0, 1.0, 16)
    grid = Grid.of(growing, Record(t, None, np.zeros((16, 1))), np.ones(1))
    tried = WindowTrial(Methods(growing, backend), grid, np.ones((1, 2)), np.full((1, 2), 1.9e3))
    verdict = tried.judge('rk4', grid.steps)
    assert 1e155 < verdict.error < np.inf and np.isinf(verdict.excess).all()


def test_steps_in_which_a_candidate_explodes_grow_from_its_begin() -> None:
    stiff = Model(
        'stiff', (Variable('x'),), (Variable('x'),),
        lambda t, x, u, p: (-p[0] * x[0],), lambda t, x, u, p: (x[0],),
        parameters=(Variable('rate'),), integrator='rk4',
    )  # fmt: skip
    t = np.linspace(0.0, 1.0, 21)
    grid = Grid.of(stiff, Record(t, None, np.zeros((21, 1))), np.full(1, 1e-3))
    tried = WindowTrial(Methods(stiff), grid, np.ones((1, 1)), np.full((1, 1), 200.0))
    shares = tried.shares('rk4', grid.steps, tried.judge('rk4', grid.steps))
    assert shares.min() > 0.9 * shares.max()


def test_only_modes_that_die_out_within_an_interval_call_for_implicit_steps() -> None:
    t = np.linspace(0.0, 1.0, 11)
    for rate, wanted in ((-30.0, True), (-5.0, False), (30.0, False)):
        plain = Model(
            'plain', (Variable('x', lower=0.0, upper=1.0),), (Variable('x'),),
            lambda t, x, u, p, rate=rate: (rate * x[0],), lambda t, x, u, p: (x[0],),
        )  # fmt: skip
        grid = Grid.of(plain, Record(t, np.empty((11, 0)), np.zeros((11, 1))), np.ones(1))
        tried = WindowTrial(Methods(plain), grid, np.ones((1, 2)), np.empty((0, 2)))
        assert tried.decays() is wanted
