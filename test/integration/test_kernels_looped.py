"""Tests of linearly implicit steps with large Jacobians: all lanes together, on both backends."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from obs_ros import Model, Record, Variable
from obs_ros.core.elimination import is_looped
from obs_ros.core.typing import Array
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid
from obs_ros.integration.rosenbrock_source import linear_model, made_for, method_texts

N = 14


def network(t: Any, x: Any, u: Any, p: Any) -> Any:
    """All nodes act on all others, at rates from 1e-1 to 1e4 1/s."""
    total = sum((1.0 + 0.1 * i) * each for i, each in enumerate(x))
    rates = [0.1 * 10.0 ** (5.0 * i / (N - 1)) for i in range(N)]
    return [
        rates[i] * (-p[0] * x[i] + 0.02 * total * x[(i + 1) % N]) + (u[0] if i == 0 else 0.0)
        for i in range(N)
    ]


NETWORK = Model(
    'network', [Variable(f'x{i}', nominal=1.0) for i in range(N)], [Variable('y')], network,
    lambda t, x, u, p: (x[0] + x[N - 1],), [Variable('u', interpolation='linear')],
    [Variable('p', nominal=1.0)], integrator='rosenbrock', max_step=0.02,
)  # fmt: skip
T = 0.04 * np.arange(26)
U = np.sin(3.0 * T)[:, None]


def rolled(model: Model, backend: str, lanes: int = 18) -> Array:
    draw = np.random.default_rng(3)
    x0, p = draw.uniform(0.1, 0.5, (N, lanes)), draw.uniform(0.8, 1.2, (1, lanes))
    if len(model.parameters) > 1:
        p = np.concatenate([p, draw.uniform(-0.05, 0.05, (1, lanes))])
    grid = Grid.of(model, Record(T, U, np.zeros((T.size, 1))), np.ones(1))
    return kernels_for(model, backend).trajectories(grid, x0, p)[0]


def test_large_jacobians_are_factorised_in_loops() -> None:
    linear = linear_model(NETWORK)
    assert linear.exact and len(linear.places) == N * N and is_looped(N, linear.places)
    assert set(made_for(NETWORK)) == {'linearised'}
    assert not any('step_rosenbrock' in text for text in method_texts(NETWORK))


def test_states_are_those_of_an_independent_integrator(backend: str) -> None:
    states = rolled(NETWORK, backend, 1)
    draw = np.random.default_rng(3)
    x0, p = draw.uniform(0.1, 0.5, N), draw.uniform(0.8, 1.2, 1)
    found = solve_ivp(
        lambda t, x: network(t, x, (np.interp(t, T, U[:, 0]),), p), (0.0, T[-1]), x0, 'Radau',
        t_eval=T, rtol=1e-8, atol=1e-11, max_step=0.04,
    )  # fmt: skip
    np.testing.assert_allclose(states[1:, :, 0], found.y.T[1:], atol=1e-2)
    np.testing.assert_allclose(states[10:, :, 0], found.y.T[10:], atol=1e-4)


@pytest.mark.parametrize('delay', [None, pytest.param((-0.1, 0.1), marks=pytest.mark.slow)])
def test_both_backends_agree(delay: Any) -> None:
    pytest.importorskip('numba')
    model = replace(NETWORK, inputs=[replace(v, delay=delay) for v in NETWORK.inputs])
    ours, theirs = (rolled(model, backend) for backend in ('numba', 'numpy'))
    np.testing.assert_allclose(ours, theirs, rtol=1e-9, atol=1e-9 * np.abs(theirs).max())


def test_a_lane_of_nan_disturbs_no_other(backend: str) -> None:
    grid = Grid.of(NETWORK, Record(T, U, np.zeros((T.size, 1))), np.ones(1))
    x0, p = np.full((N, 3), 0.2), np.ones((1, 3))
    kernels = kernels_for(NETWORK, backend)
    clean = kernels.trajectories(grid, x0, p)[0]
    x0[4, 1] = np.nan
    found = kernels.trajectories(grid, x0, p)[0]
    np.testing.assert_array_equal(found[:, :, [0, 2]], clean[:, :, [0, 2]])
    assert np.isnan(found[-1, :, 1]).all()
