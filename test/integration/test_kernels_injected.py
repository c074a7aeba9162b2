"""Tests of rollouts that measurements correct, on both backends."""

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from plants import BLOW_UP, NAN, OSCILLATOR
from spinner import SHAFT, UNWRAPPED, window

from obs_ros import Record
from obs_ros.core.typing import Array
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.filter_pass import FilterPass
from obs_ros.integration.grid import Grid, Injection

X0, P = np.array([1.0, -0.5]), np.array([0.8, 0.7])
WALKS, NOISE = np.array([0.1, 0.2, 0.05, 0.0]), np.array([0.1, 0.3])
NODES = 81


def plain_grid() -> Grid:
    rng = np.random.default_rng(3)
    t = np.concatenate([[0.0], np.cumsum(rng.uniform(0.02, 0.3, NODES - 1))])
    y = rng.standard_normal((NODES, 2))
    y[rng.random((NODES, 2)) < 0.4] = NAN
    y[7] = NAN
    return Grid.of(OSCILLATOR, Record(t, rng.standard_normal((NODES, 1)), y), np.array([0.5, 3.0]))


def filtered() -> FilterPass:
    prior = np.diag([0.1, 0.2, 0.0, 0.0])
    return kernels_for(OSCILLATOR, 'numpy').filter(plain_grid(), X0, P, WALKS, NOISE, prior)


def injected_grid() -> Grid:
    found = filtered()
    return plain_grid().injected(found.injection, found.S)


def candidates(count: int, seed: int = 4) -> tuple[Array, Array]:
    draw = np.random.default_rng(seed)
    return draw.uniform(-2.0, 2.0, (2, count)), draw.uniform(0.2, 2.0, (2, count))


def innovations(grid: Grid, outputs: Array) -> Array:
    """Scaled innovations (K, r, B), 0 where nothing was measured."""
    return np.asarray(grid.weight[..., None] * (outputs - grid.y[..., None]))


def test_along_the_nominal_they_repeat_the_pass(backend: str) -> None:
    kernels = kernels_for(OSCILLATOR, backend)
    found = kernels.filter(plain_grid(), X0, P, WALKS, NOISE, np.diag([0.1, 0.2, 0.0, 0.0]))
    grid = plain_grid().injected(found.injection, found.S)
    states, parameters, outputs = kernels.paths(grid, X0[:, None], P[:, None])
    np.testing.assert_allclose(states[:, :, 0], found.states, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(parameters[:, :, 0], found.parameters, rtol=1e-12)
    e = np.where(found.measured, grid.y - outputs[:, :, 0], NAN)
    np.testing.assert_allclose(e, found.innovations, rtol=1e-12, atol=1e-12)
    total = kernels.squares(grid, np.array([NODES]), X0[:, None], P[:, None]).sum()
    expected = found.neg2_log_likelihood - np.nansum(np.log(found.S))
    assert total == pytest.approx(expected, rel=1e-12)


def test_corrections_are_those_of_the_equations() -> None:
    """One node after the other, in the words of `Injection`."""
    grid, kernels = injected_grid(), kernels_for(OSCILLATOR, 'numpy')
    states, parameters, outputs = kernels.paths(grid, X0[:, None], P[:, None])
    injection = grid.injection
    assert injection is not None and injection.moving.tolist() == [0]
    for k in range(1, 30):
        one = plain_grid().stretch(k - 1, k)
        before, h = kernels.trajectories(one, states[k - 1], parameters[k - 1])
        z = np.array([*before[1, :, 0], *parameters[k - 1, :, 0]])
        e = np.zeros(2)
        for i in np.flatnonzero(grid.weight[k]):
            e[i] = grid.y[k, i] - h[1, i, 0] - injection.cross[k, i] @ e
            z = z + injection.gain[k, i] * e[i]
            assert outputs[k, i, 0] == pytest.approx(grid.y[k, i] - e[i], rel=1e-12)
        np.testing.assert_allclose([*states[k, :, 0], *parameters[k, :, 0]], z, rtol=1e-12)
        for i in np.flatnonzero(grid.weight[k] == 0.0):
            assert outputs[k, i, 0] == h[1, i, 0]


@pytest.mark.parametrize('count', [1, 15, 16, 17, 33])
def test_both_backends_agree_for_any_number_of_candidates(count: int) -> None:
    pytest.importorskip('numba')
    grid, prefixes = injected_grid(), np.array([3, 11, NODES])
    x0, p = candidates(count)
    a, b = kernels_for(OSCILLATOR, 'numba'), kernels_for(OSCILLATOR, 'numpy')
    for left, right in zip(
        (*a.paths(grid, x0, p), a.squares(grid, prefixes, x0, p), a.grams(grid, 70, x0, p, 1)),
        (*b.paths(grid, x0, p), b.squares(grid, prefixes, x0, p), b.grams(grid, 70, x0, p, 1)),
        strict=True,
    ):
        assert left.shape == right.shape
        np.testing.assert_allclose(left, right, rtol=1e-9, atol=1e-12)


def test_squares_are_those_of_the_innovations_between_prefixes(backend: str) -> None:
    kernels, grid = kernels_for(OSCILLATOR, backend), injected_grid()
    x0, p = candidates(5)
    terms = innovations(grid, kernels.trajectories(grid, x0, p)[1]) ** 2
    prefixes = np.array([1, 7, 8, 30, NODES])
    squares = kernels.squares(grid, prefixes, x0, p)
    for g, (first, last) in enumerate(pairwise([0, *prefixes])):
        np.testing.assert_allclose(squares[g], terms[first:last].sum(axis=0), rtol=1e-12)


@pytest.mark.parametrize(('starts', 'width'), [(3, 4), (17, 5)])
@pytest.mark.parametrize('nodes', [NODES, 17])
def test_grams_are_products_of_innovations_and_their_differences(
    backend: str, nodes: int, starts: int, width: int
) -> None:
    kernels, grid = kernels_for(OSCILLATOR, backend), injected_grid()
    x0, p = candidates(starts * width)
    rows = innovations(grid, kernels.trajectories(grid, x0, p)[1])[:nodes]
    rows = rows.reshape(-1, starts, width)
    gram = kernels.grams(grid, nodes, x0, p, width)
    for start in range(starts):
        columns = rows[:, start] - rows[:, start, :1]
        columns[:, 0] = rows[:, start, 0]
        np.testing.assert_allclose(gram[start], columns.T @ columns, rtol=1e-11, atol=1e-11)


def test_a_gram_holds_the_gradient_of_the_squares(backend: str) -> None:
    kernels, grid = kernels_for(OSCILLATOR, backend), injected_grid()
    step = 1e-6
    theta = np.concatenate([X0, P])
    points = np.repeat(theta[:, None], 5, axis=1)
    points[range(4), range(1, 5)] += step
    gram = kernels.grams(grid, NODES, points[:2], points[2:], 5)[0]
    for i in range(4):
        both = np.repeat(theta[:, None], 2, axis=1)
        both[i] += [-1e-4, 1e-4]
        low, high = kernels.squares(grid, np.array([NODES]), both[:2], both[2:])[0].sum(axis=0)
        assert 2.0 * gram[0, 1 + i] / step == pytest.approx((high - low) / 2e-4, rel=1e-4)


def test_with_gains_of_zero_the_rollouts_are_the_plain_ones(backend: str) -> None:
    kernels, plain = kernels_for(OSCILLATOR, backend), plain_grid()
    none = Injection(np.zeros((NODES, 2, 4)), np.zeros((NODES, 2, 2)), np.array([0]))
    grid = plain.injected(none, np.where(plain.weight > 0.0, plain.scale**2, NAN))
    np.testing.assert_allclose(grid.weight, plain.weight, rtol=1e-15)
    x0, p = candidates(20)
    prefixes = np.array([5, NODES])
    for found, expected in (
        (kernels.trajectories(grid, x0, p), kernels.trajectories(plain, x0, p)),
        (kernels.squares(grid, prefixes, x0, p), kernels.squares(plain, prefixes, x0, p)),
        (kernels.grams(grid, NODES, x0, p, 5), kernels.grams(plain, NODES, x0, p, 5)),
    ):
        for a, b in zip(found, expected):
            if backend == 'numpy':
                np.testing.assert_array_equal(a, b)
            np.testing.assert_allclose(a, b, rtol=1e-12, atol=1e-12)


def test_a_candidate_that_diverges_harms_no_other(backend: str) -> None:
    kernels = kernels_for(BLOW_UP, backend)
    t = np.linspace(0.0, 1.0, 21)
    plain = Grid.of(BLOW_UP, Record(t, None, np.zeros((21, 1))), np.ones(1))
    nothing = np.empty(0)
    found = kernels.filter(plain, np.array([0.2]), nothing, np.array([0.1]), np.ones(1))
    grid = plain.injected(found.injection, found.S)
    tame = np.random.default_rng(5).uniform(-1.0, 0.5, (1, 20))
    wild = tame.copy()
    wild[0, [3, 17]] = 1e30, NAN
    none = np.empty((0, 20))
    others = np.delete(np.arange(20), [3, 17])
    expected = kernels.squares(grid, np.array([21]), tame, none)[0, 0]
    squares = kernels.squares(grid, np.array([21]), wild, none)[0, 0]
    assert not np.isfinite(squares[[3, 17]]).any()
    np.testing.assert_array_equal(squares[others], expected[others])
    grams = kernels.grams(grid, 21, wild, none, 2)
    assert not np.isfinite(grams[[1, 8], 1, 1]).any()
    assert np.isfinite(np.delete(grams, [1, 8], axis=0)).all()


@pytest.mark.parametrize('last', [7, 20, 21])
def test_a_stretch_takes_the_injection_along(backend: str, last: int) -> None:
    """A rollout may stop at a node and go on."""
    kernels, grid = kernels_for(OSCILLATOR, backend), injected_grid()
    x0, p = candidates(3)
    states, parameters, outputs = kernels.paths(grid, x0, p)
    first = kernels.paths(grid.stretch(0, last), x0, p)
    for found, whole in zip(first, (states, parameters, outputs)):
        np.testing.assert_allclose(found, whole[: last + 1], rtol=1e-12)
    # From a corrected node on, without its own correction, then with those of the next ones.
    between = grid.uncorrected.stretch(last - 1, last)
    before = (np.ascontiguousarray(path[last - 1]) for path in (states, parameters))
    predicted = kernels.trajectories(between, *before)[0][-1]
    rest = kernels.paths(grid.stretch(last, NODES - 1), predicted, parameters[last - 1])
    for found, whole in zip(rest, (states, parameters, outputs)):
        np.testing.assert_allclose(found, whole[last:], rtol=1e-9, atol=1e-12)


def test_rescaled_leaves_the_gains_and_divides_the_weights(backend: str) -> None:
    kernels, grid = kernels_for(OSCILLATOR, backend), injected_grid()
    again = grid.rescaled(np.array([2.0, 4.0]))
    assert again.injection is grid.injection
    x0, p = candidates(2)
    squares = kernels.squares(grid, np.array([NODES]), x0, p)
    np.testing.assert_allclose(
        kernels.squares(again, np.array([NODES]), x0, p),
        squares / np.array([4.0, 16.0])[:, None],
        rtol=1e-12,
    )


def test_paths_of_a_plain_grid_hold_the_parameters(backend: str) -> None:
    kernels = kernels_for(OSCILLATOR, backend)
    x0, p = candidates(3)
    states, parameters, outputs = kernels.paths(plain_grid(), x0, p)
    expected: Any = kernels.trajectories(plain_grid(), x0, p)
    np.testing.assert_array_equal(states, expected[0])
    np.testing.assert_array_equal(outputs, expected[1])
    np.testing.assert_array_equal(parameters, np.broadcast_to(p, (NODES, 2, 3)))


def test_innovations_of_angles_go_by_the_shortest_way_on_both_backends() -> None:
    """A wrapped record corrects candidates as the same without wraps does, as far as they fit."""
    pytest.importorskip('numba')
    record, unwrapped, states = window(torque=4.0)
    x0, p = states[0] + np.array([0.3, -0.5]), np.array([3.5, 0.7])
    walks, noise = np.array([0.1, 0.5, 0.0, 0.0]), np.array([0.02, 0.1])
    plain = Grid.of(UNWRAPPED, unwrapped, noise)
    along = kernels_for(UNWRAPPED, 'numpy').filter(plain, x0, p, walks, noise)
    lanes = np.tile(x0, (16, 1)).T.copy(), np.tile(p, (16, 1)).T.copy()
    lanes[0][1, 1:] += np.linspace(-1e-3, 1e-3, 15)
    corrected = plain.injected(along.injection, along.S)
    expected = kernels_for(UNWRAPPED, 'numpy').trajectories(corrected, *lanes)
    prefixes = np.array([20, 61])
    for backend in ('numpy', 'numba'):
        kernels, grid = kernels_for(SHAFT, backend), Grid.of(SHAFT, record, noise)
        found = kernels.filter(grid, x0, p, walks, noise)
        for name in ('innovations', 'S', 'means', 'covariances', 'gain'):
            np.testing.assert_allclose(
                getattr(found, name), getattr(along, name), rtol=1e-6, atol=1e-6, err_msg=name
            )
        grid = grid.injected(along.injection, along.S)
        states, outputs = kernels.trajectories(grid, *lanes)
        np.testing.assert_allclose(states, expected[0], atol=1e-8)
        e = innovations(grid, outputs)
        np.testing.assert_allclose(e, innovations(corrected, expected[1]), atol=1e-6)
        np.testing.assert_allclose(
            kernels.squares(grid, prefixes, *lanes).sum(axis=0), np.sum(e**2, axis=0), rtol=1e-7
        )
        gram = kernels.grams(grid, 61, *lanes, 4)
        np.testing.assert_allclose(gram[:, 0, 0], np.sum(e**2, axis=(0, 1))[::4], rtol=1e-7)
