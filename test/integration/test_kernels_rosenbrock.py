"""Tests of linearly implicit steps in all kernels: against scipy, and of both backends."""

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from plants import BLOW_UP, LAG, NAN, OSCILLATOR, exact, with_interpolation
from scipy.integrate import solve_ivp

from obs_ros import Model, Record, Variable
from obs_ros.core.model import inside
from obs_ros.core.typing import Array
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid
from obs_ros.integration.rosenbrock_source import linear_model
from obs_ros.models import MODELS, load_model

rng = np.random.default_rng(1)


def motor_dynamics(t: Any, x: Any, u: Any, p: Any) -> Any:
    current, speed = x
    R, L, k, J, friction = p
    return (u[0] - R * current - k * speed) / L, (k * current - friction * speed) / J


def first(t: Any, x: Any, u: Any, p: Any) -> Any:
    return (x[0],)


# Time constants of 0.1 and 40 ms, sampled at 10 ms.
MOTOR = Model(
    'motor', [Variable('current', 'A'), Variable('speed', 'rad/s')], [Variable('y', 'A')],
    motor_dynamics, first, [Variable('voltage', 'V')],
    [Variable(name) for name in ('R', 'L', 'k', 'J', 'friction')], integrator='rosenbrock',
)  # fmt: skip
MOTOR_P = (1.0, 1e-4, 0.05, 1e-4, 1e-5)


def robertson(t: Any, x: Any, u: Any, p: Any) -> Any:
    a, b, c = x
    slow, back, apart = p[0] * a, p[1] * b * c, p[2] * b * b
    return back - slow, slow - back - apart, apart


ROBERTSON = Model(
    'robertson', [Variable('a'), Variable('b'), Variable('c')], [Variable('y')], robertson, first,
    parameters=[Variable('k1'), Variable('k2'), Variable('k3')], integrator='rosenbrock',
)  # fmt: skip
ROBERTSON_P = (0.04, 1e4, 3e7)
VAN_DER_POL = Model(
    'van_der_pol', [Variable('x'), Variable('v')], [Variable('y')],
    lambda t, x, u, p: (x[1], p[0] * (1.0 - x[0] * x[0]) * x[1] - x[0]), first,
    parameters=[Variable('mu')], integrator='rosenbrock',
)  # fmt: skip


def rolled(model: Model, backend: str, t: Array, u: Any, x0: Any, p: Any, steps: int) -> Array:
    """States (K, n) of one candidate, with so many steps to each interval."""
    model = replace(model, max_step=1.0001 * float(np.diff(t).max()) / steps)
    grid = Grid.of(
        model, Record(t, u, np.zeros((t.size, len(model.outputs)))), np.ones(len(model.outputs))
    )
    x0, p = (np.array(v, dtype=np.float64)[:, None] for v in (x0, p))
    return kernels_for(model, backend).trajectories(grid, x0, p)[0][:, :, 0]


def truth(model: Model, t: Array, x0: Any, p: Any, u: Any = None) -> Array:
    """States (K, n) by scipy's Radau at rtol 1e-10, inputs held."""
    states = [np.array(x0, dtype=np.float64)]
    for k in range(t.size - 1):
        inputs = () if u is None else tuple(u[k])
        found = solve_ivp(
            lambda s, x, held=inputs: model.dynamics(s, tuple(x), held, p), t[k : k + 2],
            states[-1], 'Radau', rtol=1e-10, atol=1e-13,
        )  # fmt: skip
        states.append(found.y[:, -1])
    return np.array(states)


@pytest.mark.parametrize('interpolation', ['hold', 'linear', 'mean'])
def test_order_of_convergence(backend: str, interpolation: str) -> None:
    t = np.array([0.0, 0.8, 1.6])
    plant = replace(with_interpolation(OSCILLATOR, interpolation), integrator='rosenbrock')
    u = np.array([[0.5], [-1.0], [0.25]])

    def applied(k: int, s: float) -> tuple[float]:
        here, after = u[k, 0], u[min(k + 1, 2), 0]
        if interpolation == 'mean':
            return (0.5 * (here + after),)
        return (here + (after - here) * s / 0.8 if interpolation == 'linear' else here,)

    expected, _ = exact(plant, t, applied, (1.0, -0.5), (0.8, 0.7))
    errors = [
        np.abs(
            rolled(plant, backend, t, u, (1.0, -0.5), (0.8, 0.7), steps)[-1] - expected[-1]
        ).max()
        for steps in (16, 32, 64, 128)
    ]
    for coarse, fine in pairwise(errors):
        assert coarse / fine == pytest.approx(8.0, rel=0.2)


def test_a_motor_is_right_with_steps_a_hundred_times_its_fast_time_constant(backend: str) -> None:
    t = 0.01 * np.arange(60)
    u = np.sign(np.sin(20.0 * t))[:, None] * 12.0
    expected = truth(MOTOR, t, (0.0, 0.0), MOTOR_P, u)
    size = np.abs(expected).max(axis=0)
    for steps, error in ((1, 5e-2), (4, 2e-3), (16, 1e-4)):
        found = rolled(MOTOR, backend, t, u, (0.0, 0.0), MOTOR_P, steps)
        assert (np.abs(found - expected)[1:] / size).max() < error


def test_robertsons_kinetics_from_the_slow_manifold(backend: str) -> None:
    start = truth(ROBERTSON, np.array([0.0, 0.4]), (1.0, 0.0, 0.0), ROBERTSON_P)[-1]
    t = 0.4 * np.arange(100)
    expected = truth(ROBERTSON, t, start, ROBERTSON_P)
    size = np.abs(expected).max(axis=0)
    for steps, error in ((1, 1e-3), (4, 2e-5), (16, 1e-6)):
        found = rolled(ROBERTSON, backend, t, np.zeros((100, 0)), start, ROBERTSON_P, steps)
        assert (np.abs(found - expected) / size).max() < error


def test_van_der_pol_between_and_through_its_jumps(backend: str) -> None:
    slow = np.linspace(0.0, 600.0, 61)
    expected = truth(VAN_DER_POL, slow, (2.0, 0.0), (1000.0,))
    found = rolled(VAN_DER_POL, backend, slow, np.zeros((61, 0)), (2.0, 0.0), (1000.0,), 20)
    np.testing.assert_allclose(found[:, 0], expected[:, 0], atol=1e-4)
    start = expected[-1]
    jump = solve_ivp(
        lambda t, x: VAN_DER_POL.dynamics(t, tuple(x), (), (1000.0,)), (600.0, 900.0), start,
        'Radau', rtol=1e-7, atol=1e-10,
    ).t  # fmt: skip
    expected = truth(VAN_DER_POL, jump, start, (1000.0,))
    found = rolled(VAN_DER_POL, backend, jump, np.zeros((jump.size, 0)), start, (1000.0,), 1)
    assert expected[:, 0].min() < -1.9
    np.testing.assert_allclose(found[-1, 0], expected[-1, 0], atol=1e-3)


def implicit(name: str) -> Model:
    model = load_model(name)
    return replace(model, integrator='rosenbrock')


@pytest.mark.parametrize('name', MODELS)
def test_both_backends_agree_on_every_built_in_model(name: str) -> None:
    pytest.importorskip('numba')
    model = implicit(name)
    draw = np.random.default_rng(2)
    t = min(model.max_step, 0.5) * np.cumsum(draw.uniform(0.5, 1.5, 30))
    u = np.array([[inside(v) for v in model.inputs]] * 30).reshape(30, -1)
    u = u * draw.uniform(0.9, 1.1, u.shape)
    grid = Grid.of(
        model, Record(t, u, np.zeros((30, len(model.outputs)))), np.ones(len(model.outputs))
    )
    x0 = np.array([[inside(v)] for v in model.states]) * draw.uniform(0.9, 1.1, 19)
    p = np.array([[inside(v)] for v in model.parameters]).reshape(-1, 1) * draw.uniform(
        0.98, 1.02, 19
    )
    ours, theirs = (kernels_for(model, b).trajectories(grid, x0, p) for b in ('numba', 'numpy'))
    for a, b in zip(ours, theirs, strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-9 * np.nanmax(np.abs(b)))


def oscillator_grid(model: Model) -> Grid:
    draw = np.random.default_rng(3)
    t = np.concatenate([[0.0], np.cumsum(draw.uniform(0.02, 0.3, 80))])
    y = draw.standard_normal((81, 2))
    y[draw.random((81, 2)) < 0.4] = NAN
    return Grid.of(model, Record(t, draw.standard_normal((81, 1)), y), np.array([0.5, 3.0]))


def test_both_backends_agree_in_every_kernel() -> None:
    pytest.importorskip('numba')
    model = replace(with_interpolation(OSCILLATOR, 'linear'), integrator='rosenbrock')
    ours, theirs = kernels_for(model, 'numba'), kernels_for(model, 'numpy')
    grid = oscillator_grid(model)
    draw = np.random.default_rng(4)
    x0, p = draw.uniform(-2.0, 2.0, (2, 12)), draw.uniform(0.2, 2.0, (2, 12))
    walks, noise = np.array([0.1, 0.2, 0.05, 0.0]), np.array([0.1, 0.3])
    prefixes = np.array([7, 81])
    passes = [k.filter(grid, x0[:, 0], p[:, 0], walks, noise) for k in (ours, theirs)]
    assert passes[0].neg2_log_likelihood == pytest.approx(passes[1].neg2_log_likelihood, rel=1e-9)
    injected = grid.injected(passes[1].injection, passes[1].S)
    for each in (grid, injected):
        for a, b in (
            (ours.squares(each, prefixes, x0, p), theirs.squares(each, prefixes, x0, p)),
            (ours.grams(each, 81, x0, p, 4), theirs.grams(each, 81, x0, p, 4)),
            (ours.paths(each, x0, p)[0], theirs.paths(each, x0, p)[0]),
        ):
            np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-9 * np.abs(b).max())


def test_models_with_delays_take_linearly_implicit_steps(backend: str) -> None:
    late = [replace(v, delay=(-0.5, 0.5)) for v in LAG.inputs]
    t = 0.2 * np.arange(31)
    u = np.sin(t)[:, None]
    found = []
    for integrator, longest in (('rosenbrock', 0.02), ('rk4', 0.02)):
        model = replace(LAG, inputs=late, integrator=integrator, max_step=longest)  # type: ignore[arg-type]
        grid = Grid.of(model, Record(t, u, np.zeros((31, len(model.outputs)))), np.ones(1))
        p = np.array([[2.0] * 3, [1.5] * 3, [-0.33, 0.0, 0.2]])
        found.append(kernels_for(model, backend).trajectories(grid, np.full((1, 3), 0.3), p)[1])
    np.testing.assert_allclose(found[0], found[1], atol=2e-7)


def test_a_candidate_that_blows_up_disturbs_no_other(backend: str) -> None:
    model = replace(BLOW_UP, integrator='rosenbrock')
    t = 0.1 * np.arange(16)
    grid = Grid.of(model, Record(t, np.zeros((16, 0)), np.zeros((16, 1))), np.ones(1))
    x0 = np.array([[0.2, 3.0, NAN, -0.5, 0.1, NAN, 0.3]])
    states, _ = kernels_for(model, backend).trajectories(grid, x0, np.zeros((0, 7)))
    whole = np.array([0, 3, 4, 6])
    np.testing.assert_allclose(
        states[:, 0, whole], x0[0, whole] / (1.0 - x0[0, whole] * t[:, None]), rtol=1e-5
    )
    assert np.isnan(states[-1, 0, [2, 5]]).all()


def nodes_in_a_row(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Heat between twenty nodes whose own rates reach from 1e-4 to 1e2 1/s."""
    flow = [p[0] * (a - b) for a, b in pairwise(x)]
    into = [u[0] - x[0], *flow]
    out = [*flow, p[1] * x[-1]]
    return [(a - b) * 10.0 ** (6.0 * i / 19 - 4.0) for i, (a, b) in enumerate(zip(into, out))]


def test_a_thermal_network_of_twenty_nodes(backend: str) -> None:
    model = Model(
        'chain', [Variable(f'T{i}', 'K', nominal=0.0) for i in range(20)], [Variable('y', 'K')],
        nodes_in_a_row, lambda t, x, u, p: (x[19],), [Variable('power', 'W')],
        [Variable('coupling', nominal=1.0), Variable('loss', nominal=0.1)], integrator='rosenbrock',
    )  # fmt: skip
    t = 10.0 * np.arange(31)
    u = np.where(np.arange(31) % 10 < 5, 1.0, 0.2)[:, None]
    x0 = tuple(np.linspace(1.0, 0.5, 20))
    expected = truth(model, t, x0, (1.0, 0.1), u)
    for steps, error in ((1, 3e-2), (4, 1e-3)):
        found = rolled(model, backend, t, u, x0, (1.0, 0.1), steps)
        assert np.abs(found - expected).max() < error


def test_functions_that_cannot_be_recorded_are_differenced(backend: str) -> None:
    """An option of nan_to_num compiles, but is no recorded operation."""

    def dynamics(t: Any, x: Any, u: Any, p: Any) -> Any:
        return u[0] * t - p[0] * np.nan_to_num(x[0], nan=0.5), x[0] ** 2 - 1e4 * x[1]

    model = Model(
        'plain', [Variable('a'), Variable('b')], [Variable('y')], dynamics, first,
        [Variable('u', interpolation='linear')], [Variable('k')], integrator='rosenbrock',
    )  # fmt: skip
    assert not linear_model(model).exact
    exactly = replace(
        model, dynamics=lambda t, x, u, p: (u[0] * t - p[0] * x[0], x[0] ** 2 - 1e4 * x[1])
    )
    assert linear_model(exactly).exact
    t = 0.1 * np.arange(20)
    ours, theirs = (
        rolled(each, backend, t, np.sin(t)[:, None], (0.5, 1.0), (1.0,), 2)
        for each in (model, exactly)
    )
    np.testing.assert_allclose(ours, theirs, atol=1e-5)


def test_a_plant_that_runs_candidate_by_candidate_takes_linearly_implicit_steps() -> None:
    def dynamics(t: Any, x: Any, u: Any, p: Any) -> Any:
        return [float(f'{-1e3 * (x[0] - p[0])!r}')]

    model = Model('odd', [Variable('a')], [Variable('y')], dynamics, first,
                  parameters=[Variable('goal')], integrator='rosenbrock')  # fmt: skip
    assert not linear_model(model).exact
    t = 0.1 * np.arange(5)
    states = rolled(model, 'numpy', t, np.zeros((5, 0)), (0.0,), (2.0,), 1)
    assert states[-1, 0] == pytest.approx(2.0, abs=1e-5)
