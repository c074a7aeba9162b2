"""Tests of obs_ros.integration.live_steps: candidates against SciPy's Radau, and RK4's own bits."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from plants import BLOW_UP, OSCILLATOR
from sampled_stiff_plants import MOTOR, by_radau, chain, van_der_pol

from obs_ros.core.model import Model, Variable
from obs_ros.core.typing import Array
from obs_ros.integration.filter_step import LiveFilter
from obs_ros.integration.live_steps import LiveStepper, figures_of, live_stepper, prepare
from obs_ros.integration.path import LANES, Path
from obs_ros.integration.stepper import stepper_for
from obs_ros.models import load_model

TANKS = load_model('three_tank')


def path(dt: float, u: Any = (), t: float = 0.0, steps: int = 1) -> Path:
    """One piece of dt s under held inputs u (m,)."""
    inputs = np.repeat(np.array([u], dtype=np.float64).reshape(1, -1), 2, axis=0)
    return Path(1, np.array([t, t + dt]), np.array([dt]), np.array([steps]), inputs, 0.0 * inputs)


def spread(values: Any, share: float = 0.0) -> Array:
    """Candidates (n, lanes) about values (n,), apart by a share of them."""
    away = 1.0 + share * np.linspace(-1.0, 1.0, LANES)
    away[0] = 1.0
    return np.ascontiguousarray(np.array(values, dtype=np.float64)[:, None] * away)


def stepper(model: Model, noise: float, stddev: Array | None = None) -> LiveStepper:
    return LiveStepper(model, 'numpy', np.full(len(model.outputs), noise), stddev)


@pytest.mark.parametrize(
    ('model', 'x', 'u', 'p', 'dt', 'noise'),
    [
        (MOTOR, (0.0, 0.0), (12.0,), (0.05,), 0.01, 0.1),
        (van_der_pol(100.0), (2.0, -0.01), (), (100.0,), 2.0, 0.01),
        (chain(6), (20.0,) * 6, (60.0,), (20.0,), 10.0, 0.1),
    ],
)
def test_a_stiff_plant_errs_by_less_than_a_tenth_of_the_noise(
    model: Model, x: Any, u: Any, p: Any, dt: float, noise: float
) -> None:
    """All candidates, without a step given, from output to output and linearly implicit."""
    live = stepper(model, noise)
    candidates, parameters = spread(x, 0.1), spread(p)
    exact = candidates.copy()
    for k in range(8):
        live.propagate(path(dt, u, k * dt), candidates, parameters)
        for lane in (0, 1, LANES - 1):
            exact[:, lane] = by_radau(
                model, k * dt, (k + 1) * dt, exact[:, lane], np.array(u), parameters[:, lane]
            )
            y, truth = (
                np.array(model.output(0.0, tuple(each[:, lane]), u, p))
                for each in (candidates, exact)
            )
            assert np.abs(y - truth).max() < 0.1 * noise
    assert live.method == 'rosenbrock'
    assert live.error < 0.1
    figures = figures_of(live)
    assert figures['integration_error_sd'] == live.error
    assert 1.0 <= figures['integration_steps.rosenbrock'] <= 64.0


def test_a_plant_that_needs_no_more_keeps_the_bits_of_rk4(backend: str) -> None:
    live = LiveStepper(TANKS, backend, np.full(2, 0.1))  # type: ignore[arg-type]
    plain = stepper_for(replace(TANKS, integrator='rk4'), backend)  # type: ignore[arg-type]
    x, p = spread((60.0, 20.0, 40.0), 0.05), spread((1.0, 1.0, 1.0))
    other = x.copy()
    for k in range(60):
        held = path(1.0, (30.0 + k % 7, 20.0), float(k))
        live.propagate(held, x, p)
        plain.propagate(held, other, p)
        assert np.array_equal(x, other)
    assert (live.method, live.steps) == ('rk4', 1)


def test_coarse_samples_of_a_smooth_plant_take_more_steps_of_rk4() -> None:
    """The oscillator in intervals of a third of its period, against steps of 1 ms."""
    model = replace(OSCILLATOR, max_step=np.inf)
    live = stepper(model, 1e-3)
    fine = stepper_for(replace(OSCILLATOR, max_step=1e-3, integrator='rk4'), 'numpy')
    x, p = spread((1.0, -0.5), 0.1), spread((0.8, 0.7))
    other = x.copy()
    live.propagate(path(1.0, (0.3,)), x, p)
    fine.propagate(path(1.0, (0.3,), steps=1000), other, p)
    assert live.method == 'rk4'
    assert 4 <= live.steps <= 64
    assert np.abs(x - other).max() < 1e-5


def test_steps_shrink_before_the_way_is_over_and_grow_again() -> None:
    """The motor is at rest, gets a jump of its voltage, and rests again."""
    live = stepper(MOTOR, 0.1)
    x, p = spread((0.0, 0.0)), spread((0.05,))
    taken = []
    for k in range(80):
        live.propagate(path(0.01, (0.0 if k < 20 else 12.0,), 0.01 * k), x, p)
        taken.append(live.steps)
        if k == 20:
            exact = by_radau(MOTOR, 0.0, 0.01, np.zeros(2), np.array([12.0]), np.array([0.05]))
            assert abs(x[1, 0] - exact[1]) < 0.01
    assert max(taken[20:25]) > taken[19]
    assert taken[-1] < max(taken)


def test_an_input_leaps_while_the_plant_rests() -> None:
    """Rest asks for no steps at all; the first way after a leap is exact all the same."""
    cell = Model(
        name='cell',
        states=(Variable('quick', 'V', -0.3, 0.3), Variable('slow', 'V', -0.3, 0.3)),
        inputs=(Variable('current', 'A'),),
        outputs=(Variable('voltage', 'V'),),
        dynamics=lambda t, x, u, p: ((0.05 * u[0] - x[0]) / 0.05, (0.1 * u[0] - x[1]) / 60.0),
        output=lambda t, x, u, p: (x[0] + x[1],),
    )
    live, levels = stepper(cell, 1e-4), (0.2, -0.3, 1.6, 1.7, 1.5, 4.0)
    x, p = spread((0.01, 0.0), 0.1), np.empty((0, LANES))
    exact, off = x[:, 0].copy(), []
    for k in range(len(levels) * 70):
        u = np.array([levels[k // 70]])
        live.propagate(path(1.0, u, float(k)), x, p)
        exact = by_radau(cell, k, k + 1.0, exact, u, p[:, 0])
        off.append(np.abs(x[:, 0] - exact).sum())
    assert live.method == 'rosenbrock'
    assert max(off) < 0.03e-4 and max(off[::70]) > 0.0


def test_a_gap_is_no_single_step() -> None:
    model = replace(OSCILLATOR, max_step=np.inf)
    live = stepper(model, 1e-3)
    x, p = spread((1.0, -0.5)), spread((0.8, 0.7))
    for k in range(10):
        live.propagate(path(0.02, (0.3,), 0.02 * k), x, p)
    assert live.steps == 1
    live.propagate(path(3.0, (0.3,), 0.2), x, p)
    assert live.steps >= 16


def test_hidden_states_err_by_little_beside_what_is_known_of_them() -> None:
    """The current does not show in the speed of this motor, whose k is 0."""
    x, p = spread((30.0, 0.0)), spread((0.0,))
    blind, seeing = stepper(MOTOR, 0.1), stepper(MOTOR, 0.1, np.array([1e-3, 1.0]))
    errors = []
    for live in (blind, seeing):
        states = x.copy()
        live.propagate(path(2e-4, (0.0,)), states, p)
        errors.append(abs(states[0, 0] - 30.0 * np.exp(-2.0)))
    assert errors[0] > 0.1  # a step of two time constants
    assert errors[1] < 1e-4


def test_a_plant_that_diverges_takes_the_steps_that_it_had() -> None:
    """x' = x^2 from 1 ends at 1 s."""
    live = stepper(replace(BLOW_UP, max_step=np.inf), 0.1)
    x = spread((1.0,))
    live.propagate(path(2.0), x, np.empty((0, LANES)))
    assert not (np.abs(x) < 100.0).any()
    assert live.steps == 1


def test_a_candidate_that_diverges_leaves_the_others_exact() -> None:
    live = stepper(replace(BLOW_UP, max_step=np.inf), 1e-3)
    x = spread((0.4,))
    x[0, 5] = 3.0  # it ends after a third of a second
    live.propagate(path(1.0), x, np.empty((0, LANES)))
    others = np.delete(x[0], 5)
    assert others == pytest.approx(np.full(LANES - 1, 0.4 / 0.6), abs=1e-5)


def test_a_filter_goes_as_one_in_fine_steps_does() -> None:
    """The whole of it: mean, covariance and innovations on the motor, from far off."""
    covariance = np.diag([25.0, 100.0, 4e-4])
    fine = stepper_for(replace(MOTOR, integrator='rosenbrock', max_step=1e-4), 'numpy')
    filters = []
    for steps in (stepper(MOTOR, 0.5), fine):
        kf = LiveFilter.of(
            MOTOR, np.zeros(2), np.array([0.04]), covariance, np.array([0.1, 1.0, 1e-4]),
            np.array([0.5]), np.array([0]),
        )  # fmt: skip
        for k in range(25):
            share = 100 if steps is fine else 1
            way = path(0.01, (10.0 + 5.0 * (k % 2),), 0.01 * k, share)
            steps.filter(kf, way, np.array([40.0 + k]))
        filters.append(kf)
    live, exact = filters
    sd = np.sqrt(np.diag(exact.P))
    assert np.abs(live.x - exact.x).max() < 0.03 * sd[:2].min()
    assert np.abs(live.p - exact.p).max() < 0.03 * sd[2]
    assert np.sqrt(np.diag(live.P)) == pytest.approx(sd, rel=0.03)
    assert pytest.approx(exact.S, rel=0.03) == live.S


def test_the_choice_is_a_function_of_the_ways() -> None:
    found = []
    for _ in range(2):
        live = stepper(MOTOR, 0.1)
        x, p = spread((0.0, 0.0), 0.1), spread((0.05,))
        for k in range(30):
            live.propagate(path(0.01, (10.0 * (k % 3),), 0.01 * k), x, p)
        found.append((x.tobytes(), live.method, live.steps, live.error))
    assert found[0] == found[1]


def test_a_method_that_is_given_chooses_nothing() -> None:
    model = replace(TANKS, integrator='rk4')
    assert live_stepper(model, 'numpy', np.full(2, 0.1)) is stepper_for(model, 'numpy')
    assert figures_of(stepper_for(model, 'numpy')) == {}
    assert figures_of(None) == {}


def test_stiff_models_get_both_methods_beforehand() -> None:
    assert [each.model.method for each in prepare(MOTOR, 'numpy')] == ['rk4', 'rosenbrock']
    assert [each.model.method for each in prepare(TANKS, 'numpy')] == ['rk4']
    given = replace(MOTOR, integrator='rk4')
    assert [each.model.method for each in prepare(given, 'numpy')] == ['rk4']
