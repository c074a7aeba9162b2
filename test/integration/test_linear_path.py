"""Tests of obs_ros.integration.linear_path."""

import numpy as np
import pytest
from kalman_reference import CART, NOISE, PRIOR, WALKS, X0, P, cart_window
from plants import OSCILLATOR

from obs_ros import Record
from obs_ros.core.typing import Array
from obs_ros.integration import linear_path
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid
from obs_ros.integration.linear_path import LinearPath


def sets_of_noise(count: int, walks: Array, noise: Array) -> tuple[Array, Array]:
    """Walks (n + q, count) and noise (r, count) up to ten times as large or as small."""
    rng = np.random.default_rng(count)
    return (
        walks[:, None] * 10.0 ** rng.uniform(-1.0, 1.0, (walks.size, count)),
        noise[:, None] * 10.0 ** rng.uniform(-1.0, 1.0, (noise.size, count)),
    )


@pytest.mark.parametrize('count', [1, 3, 17])
def test_on_a_linear_plant_any_noise_has_the_likelihood_of_its_own_pass(
    backend: str, count: int
) -> None:
    grid, kernels = Grid.of(CART, cart_window(), np.ones(3)), kernels_for(CART, backend)
    base = np.array([0.1, 0.3, 0.0, 0.2])
    path = LinearPath.of(kernels.filter(grid, X0, P, base, NOISE, PRIOR))
    walks, noise = sets_of_noise(count, base, NOISE)
    walks[1, 0] = 0.0
    found = path.neg2_log_likelihood(walks, noise)
    assert found.shape == (count,)
    expected = [
        kernels.filter(grid, X0, P, w, s, PRIOR, np.array([1])).neg2_log_likelihood
        for w, s in zip(walks.T, noise.T)
    ]
    np.testing.assert_allclose(found, expected, rtol=1e-8)


def swing(backend: str) -> tuple[Grid, Array, Array]:
    """A nonlinear plant that process noise pushes about: grid, x0, p."""
    t = 0.05 * np.arange(201)
    rng = np.random.default_rng(8)
    x0, p = np.array([1.0, 0.0]), np.array([0.8, 0.3])
    kernels = kernels_for(OSCILLATOR, backend)
    blank = Grid.of(OSCILLATOR, Record(t, np.zeros((201, 1)), np.zeros((201, 2))), np.ones(2))
    y, x = np.empty((201, 2)), x0
    for k in range(201):
        if k > 0:
            x = kernels.trajectories(blank.stretch(k - 1, k), x[:, None], p[:, None])[0][1, :, 0]
            x[1] += 0.1 * np.sqrt(0.05) * rng.standard_normal()
        y[k] = OSCILLATOR.output(t[k], x, (0.0,), p)
    y += 0.02 * rng.standard_normal(y.shape)
    return Grid.of(OSCILLATOR, Record(t, np.zeros((201, 1)), y), np.ones(2)), x0, p


def test_on_a_nonlinear_plant_the_noise_of_the_pass_has_its_likelihood(backend: str) -> None:
    grid, x0, p = swing(backend)
    walks, noise = np.array([0.0, 0.1, 0.0, 0.0]), np.array([0.02, 0.02])
    found = kernels_for(OSCILLATOR, backend).filter(grid, x0, p, walks, noise)
    same = LinearPath.of(found).neg2_log_likelihood(walks[:, None], noise[:, None])
    assert same[0] == pytest.approx(found.neg2_log_likelihood, rel=1e-8)


def test_near_a_pass_the_likelihood_of_other_noise_is_that_of_its_pass(backend: str) -> None:
    """Within a tenth of what decides, whether the walk is half or double."""
    grid, x0, p = swing(backend)
    kernels = kernels_for(OSCILLATOR, backend)
    noise = np.array([0.02, 0.02])
    base = np.array([0.0, 0.1, 0.0, 0.0])
    path = LinearPath.of(kernels.filter(grid, x0, p, base, noise))
    walks = base[:, None] * np.array([0.5, 1.0, 2.0])
    found = path.neg2_log_likelihood(walks, np.repeat(noise[:, None], 3, axis=1))
    expected = [kernels.filter(grid, x0, p, w, noise).neg2_log_likelihood for w in walks.T]
    np.testing.assert_allclose(found, expected, atol=0.1)
    assert found.argmin() == 1


def test_walks_of_what_the_pass_left_constant_do_not_count(backend: str) -> None:
    grid, kernels = Grid.of(CART, cart_window(), np.ones(3)), kernels_for(CART, backend)
    path = LinearPath.of(kernels.filter(grid, X0, P, WALKS, NOISE, PRIOR))
    walks = np.column_stack([WALKS, WALKS + np.array([0.0, 0.0, 1.0, 0.0])])
    one, other = path.neg2_log_likelihood(walks, np.column_stack([NOISE, NOISE]))
    assert one == other


def test_a_likelihood_that_overflows_is_infinite(backend: str) -> None:
    grid, kernels = Grid.of(CART, cart_window(), np.ones(3)), kernels_for(CART, backend)
    path = LinearPath.of(kernels.filter(grid, X0, P, WALKS, NOISE, PRIOR))
    walks = np.column_stack([WALKS, np.full(4, 1e200), WALKS])
    noise = np.column_stack([NOISE, NOISE, np.zeros(3)])
    found = path.neg2_log_likelihood(walks, noise)
    assert np.isfinite(found[0]) and found[1] == np.inf


def test_both_backends_agree() -> None:
    pytest.importorskip('numba')
    paths = {}
    for name in ('numba', 'numpy'):
        grid, x0, p = swing('numpy')
        base = np.array([0.05, 0.1, 0.1, 0.0])
        paths[name] = LinearPath.of(
            kernels_for(OSCILLATOR, name).filter(grid, x0, p, base, np.array([0.02, 0.02]))
        )
    walks, noise = sets_of_noise(20, np.array([0.05, 0.1, 0.1, 0.0]), np.array([0.02, 0.02]))
    a, b = (path.neg2_log_likelihood(walks, noise) for path in paths.values())
    np.testing.assert_allclose(a, b, rtol=1e-8)


def test_loops_and_arrays_agree(monkeypatch: pytest.MonkeyPatch) -> None:
    """The arrays are what runs where there is no Numba."""
    pytest.importorskip('numba')
    grid, kernels = Grid.of(CART, cart_window(), np.ones(3)), kernels_for(CART, 'numpy')
    base = np.array([0.1, 0.3, 0.0, 0.2])
    path = LinearPath.of(kernels.filter(grid, X0, P, base, NOISE, PRIOR))
    walks, noise = sets_of_noise(20, base, NOISE)
    loops = path.neg2_log_likelihood(walks, noise)
    monkeypatch.setattr(linear_path, 'likelihoods', linear_path._likelihoods_on_arrays)
    np.testing.assert_allclose(loops, path.neg2_log_likelihood(walks, noise), rtol=1e-9)


def test_the_walk_that_is_likeliest_is_the_true_one() -> None:
    """A hundred sets of noise a window, twenty windows: within 15 % in the median."""
    kernels, walk, noise = kernels_for(CART), 0.2, 0.01
    t, u = 0.05 * np.arange(201), np.zeros((201, 1))
    walks = np.zeros((4, 100))
    walks[1] = walk * 10.0 ** np.linspace(-1.0, 1.0, 100)
    likeliest = []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        steps = walk * np.sqrt(0.05) * rng.standard_normal((200, 2))
        v = np.concatenate([[0.0], np.cumsum(steps[:, 0])])
        # Position and speed of a Wiener process at the samples: exact in law.
        inside = 0.05 * v[:-1] + 0.05 * (0.5 * steps[:, 0] + steps[:, 1] / np.sqrt(12.0))
        s = np.concatenate([[0.0], np.cumsum(inside)])
        y = np.column_stack([s, v, 0.5 * s - 0.7 * v]) + noise * rng.standard_normal((201, 3))
        y[:, 1:] = np.nan  # the position alone: speed is one integration away
        grid = Grid.of(CART, Record(t, u, y), np.ones(3))
        base = np.array([0.0, 2.0 * walk, 0.0, 0.0])
        found = kernels.filter(grid, np.zeros(2), np.array([1.0, 0.0]), base, np.full(3, noise))
        total = LinearPath.of(found).neg2_log_likelihood(walks, np.full((3, 100), noise))
        likeliest.append(walks[1, total.argmin()])
    assert np.median(likeliest) == pytest.approx(walk, rel=0.15)
    assert min(likeliest) > 0.1 and max(likeliest) < 0.4
