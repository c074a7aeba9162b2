"""Tests of obs_ros.integration.filter_step: the pass output by output, and across backends."""

from typing import Any

import numpy as np
import pytest
from arx import ARX, B, course, kalman_filter, pushes
from arx import A as WEIGHTS
from kalman_reference import CART, NOISE, PRIOR, WALKS, X0, P, cart_window, considered_filter
from plants import BLOW_UP, NAN, OSCILLATOR
from spinner import SHAFT, UNWRAPPED, window

from obs_ros import Model, Record
from obs_ros.core.model import inside
from obs_ros.core.typing import Array
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.filter_step import LiveFilter
from obs_ros.integration.grid import Grid
from obs_ros.integration.path import Path
from obs_ros.integration.stepper import stepper_for
from obs_ros.integration.vectorised import NumpyKernels
from obs_ros.models import MODELS, load_model

BOTH = np.array([0, 1])
JOINT = np.array([[0.1, 0.05, 0.0, 0.02], [0.05, 0.2, 0.03, 0.0], [0.0, 0.03, 0.1, 0.01],
                  [0.02, 0.0, 0.01, 0.3]])  # fmt: skip


def path_of(model: Model, record: Record, first: int, last: int) -> Path:
    """The inputs of a record from one node to another, held."""
    grid = Grid.of(model, record, np.ones(record.y.shape[1])).stretch(first, last)
    return Path(last - first, grid.t, np.diff(grid.t), grid.steps, grid.u, 0.0 * grid.u)


def cart(P0: Array, walks: Array, moving: Array) -> LiveFilter:
    return LiveFilter.of(CART, X0, P, P0, walks, NOISE, moving)


def test_parameters_that_walk_are_filtered_as_in_the_pass(backend: str) -> None:
    record = cart_window()
    record = Record(record.t, record.u, np.vstack([np.full(3, NAN), record.y[1:]]))
    walks = np.array([0.1, 0.3, 0.0, 0.2])
    grid = Grid.of(CART, record, np.ones(3))
    found = kernels_for(CART, backend).filter(grid, X0, P, walks, NOISE, PRIOR)
    live, stepper = cart(PRIOR, walks, np.array([1])), stepper_for(CART, backend)
    for k in range(60):
        stepper.filter(live, path_of(CART, record, k, k + 1), record.y[k + 1])
        np.testing.assert_allclose(live.x, found.states[k + 1], rtol=1e-8, atol=1e-10)
        np.testing.assert_allclose(live.p, found.parameters[k + 1], rtol=1e-8)
        np.testing.assert_allclose(live.P, found.covariances[k + 1], rtol=1e-8, atol=1e-12)


def test_parameters_without_a_walk_are_considered(backend: str) -> None:
    record = cart_window()
    live, stepper = cart(JOINT, WALKS, BOTH), stepper_for(CART, backend)
    dense = considered_filter(record, JOINT)
    for k in range(60):
        stepper.filter(live, path_of(CART, record, k, k + 1), record.y[k + 1])
        np.testing.assert_allclose(live.x, dense.states[k + 1], rtol=1e-7, atol=1e-8)
        np.testing.assert_allclose(live.P, dense.covariances[k + 1], rtol=1e-6, atol=1e-9)
        np.testing.assert_allclose(live.innovation, dense.innovations[k + 1], rtol=1e-6, atol=1e-8)
        np.testing.assert_allclose(live.S, dense.S[k + 1], rtol=1e-6)
    np.testing.assert_array_equal(live.p, P)
    np.testing.assert_allclose(live.P[2:, 2:], JOINT[2:, 2:], rtol=1e-12)


@pytest.mark.parametrize('moving', [[], [0], [1, 0]])
def test_both_backends_agree_on_a_nonlinear_plant(moving: Any) -> None:
    """Paths of one to three pieces, outputs missing, one parameter walking, one considered."""
    pytest.importorskip('numba')
    rng = np.random.default_rng(4)
    t = np.concatenate([[0.0], np.cumsum(rng.uniform(0.02, 0.2, 60))])
    y = rng.standard_normal((61, 2))
    y[rng.random((61, 2)) < 0.3] = NAN
    record = Record(t, rng.standard_normal((61, 1)), y)
    lives = []
    for backend in ('numpy', 'numba'):
        live = LiveFilter.of(
            OSCILLATOR, np.array([1.0, -0.5]), np.array([0.8, 0.7]), JOINT,
            np.array([0.1, 0.2, 0.05, 0.0]), np.array([0.1, 0.3]), np.array(moving, np.int64),
        )  # fmt: skip
        lives.append(live)
        stepper, first = stepper_for(OSCILLATOR, backend), 0
        for last in np.cumsum(np.resize([1, 2, 3], 30)):
            stepper.filter(live, path_of(OSCILLATOR, record, first, last), y[last])
            first = last
    for name in ('x', 'p', 'P', 'innovation', 'S'):
        numpy, numba = (getattr(live, name) for live in lives)
        np.testing.assert_allclose(numba, numpy, rtol=1e-9, atol=1e-12, err_msg=name)
    assert lives[0].p[1] == 0.7


@pytest.mark.slow  # a compilation for each
@pytest.mark.parametrize('name', MODELS)
def test_every_built_in_model_has_a_filter_that_both_backends_agree_on(name: str) -> None:
    pytest.importorskip('numba')
    model = load_model(name)
    n, q, r = len(model.states), len(model.parameters), len(model.outputs)
    rng = np.random.default_rng(3)
    t = min(model.max_step, 0.5) * np.cumsum(rng.uniform(0.5, 1.5, 30))
    u = np.array([[inside(v) for v in model.inputs]] * 30).reshape(30, -1)
    record = Record(t, u, np.zeros((30, r)))
    x0 = np.array([inside(v) for v in model.states])
    p = np.array([inside(v) for v in model.parameters])
    clean = NumpyKernels(model).trajectories(
        Grid.of(model, record, np.ones(r)), x0[:, None], p[:, None]
    )[1][:, :, 0]
    noise = 1e-2 * np.maximum(np.abs(clean).max(axis=0), 1e-3)
    y = clean + noise * rng.standard_normal(clean.shape)
    spread = 1e-2 * np.maximum(np.abs(np.append(x0, p)), 0.1)
    walks = np.append(spread[:n], np.zeros(q))
    lives = []
    for backend in ('numpy', 'numba'):
        live = LiveFilter.of(model, x0, p, np.diag(spread**2), walks, noise, np.arange(q))
        for k in range(29):
            stepper_for(model, backend).filter(live, path_of(model, record, k, k + 1), y[k + 1])
        lives.append(live)
    np.testing.assert_allclose(lives[1].x, lives[0].x, rtol=1e-7, atol=1e-9)
    np.testing.assert_allclose(lives[1].S, lives[0].S, rtol=1e-6)
    np.testing.assert_array_equal(lives[1].p, p)


def test_what_diverges_is_not_finite_and_raises_nothing(backend: str) -> None:
    live = LiveFilter.of(
        BLOW_UP, np.array([1e3]), np.empty(0), np.eye(1), np.ones(1), np.ones(1), BOTH[:0]
    )  # fmt: skip
    empty = np.empty((2, 0))
    path = Path(1, np.zeros(2), np.ones(1), np.array([50]), empty, empty)
    stepper_for(BLOW_UP, backend).filter(live, path, np.zeros(1))
    assert not np.isfinite(live.x).any()


def test_a_wrapped_angle_corrects_like_one_without_wraps(backend: str) -> None:
    record, unwrapped, states = window(torque=4.0)
    lives = []
    for model, measured, kind in ((SHAFT, record, backend), (UNWRAPPED, unwrapped, 'numpy')):
        live = LiveFilter.of(
            model, states[0] + 0.2, np.array([3.2, 0.6]), np.diag([0.1, 1.0, 0.3, 0.1]),
            np.array([0.1, 0.5, 0.1, 0.0]), np.array([0.02, 0.1]), np.array([0, 1]),
        )  # fmt: skip
        for k in range(60):
            stepper_for(model, kind).filter(
                live, path_of(model, measured, k, k + 1), measured.y[k + 1]
            )
        lives.append(live)
    for name in ('x', 'p', 'P', 'innovation', 'S'):
        wrapped, plain = (getattr(live, name) for live in lives)
        np.testing.assert_allclose(wrapped, plain, rtol=1e-5, atol=1e-6, err_msg=name)
    assert abs(lives[0].x[0]) > 4.0, 'the shaft has turned on'


def test_a_discrete_model_is_filtered_node_by_node(backend: str) -> None:
    """Paths of three nodes; the noise of each goes through the nodes that follow."""
    u = pushes(61)
    y = course(u, walk=0.5, noise=0.02)[1]
    y[np.arange(61) % 3 > 0] = NAN
    y[0] = NAN
    walks, P0 = np.array([0.5, 0.1, 0.0, 0.0, 0.0]), np.diag([0.1, 0.3, 0.0, 0.0, 0.0])
    expected = kalman_filter(u, y, [0.8, 0.6], P0[:2, :2], [0.5, 0.1], 0.02)
    live = LiveFilter.of(
        ARX, np.array([0.8, 0.6]), np.array([*WEIGHTS, B]), P0, walks, np.array([0.02]),
        np.array([], np.int64),
    )  # fmt: skip
    record = Record(0.1 * np.arange(61), u, y)
    for k in range(3, 61, 3):
        stepper_for(ARX, backend).filter(live, path_of(ARX, record, k - 3, k), y[k : k + 1])
        np.testing.assert_allclose(live.x, expected.means[k], rtol=1e-8, atol=1e-10)
        np.testing.assert_allclose(live.P, expected.covariances[k], rtol=1e-6, atol=1e-11)
