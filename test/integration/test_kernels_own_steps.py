"""Tests of the compiled kernels of own steps: NumPy takes the very same ones."""

from dataclasses import replace

import numpy as np
import pytest
from stiff_plants import MOTOR, ROBERTSON, van_der_pol

from obs_ros import Model, Record
from obs_ros.core.typing import Array
from obs_ros.integration.backends import Kernels, kernels_for
from obs_ros.integration.grid import Grid
from obs_ros.integration.own_steps import leaders

pytest.importorskip('numba')
PLANTS = {
    'motor': (MOTOR, 0.01 * np.arange(40), (0.0, 0.0), (1.3, 0.07)),
    'relaxing': (van_der_pol(20.0), np.linspace(0.0, 24.0, 40), (1.5, -0.06), (20.0,)),
    'robertson': (ROBERTSON, np.append(0.0, np.geomspace(1e-4, 1e4, 39)), (1.0, 0.0, 0.0), (0.05,)),
}  # fmt: skip


def case(name: str) -> tuple[tuple[Kernels, Kernels], Grid, Array, Array]:
    """Return both backends, a grid, and 21 candidates about a plant's own."""
    plant, t, x0, p = PLANTS[name]
    model: Model = replace(plant, integrator='rosenbrock')
    u = np.sign(np.sin(0.7 * np.arange(40)))[:, None] * np.ones((1, len(model.inputs)))
    record = Record(t, u, np.full((40, len(model.outputs)), 0.3))
    grid = Grid.of(model, record, np.full(len(model.outputs), 0.1))
    grid = replace(grid, tolerance=1e-5, budget=20_000)
    draw = np.random.default_rng(2)
    lanes = [
        np.array(each)[:, None] * draw.uniform(0.95, 1.05, (len(each), 21)) for each in (x0, p)
    ]
    return (kernels_for(model, 'numba'), kernels_for(model, 'numpy')), grid, lanes[0], lanes[1]


def near(x0: Array, p: Array, width: int) -> tuple[Array, Array]:
    """Return the leaders of groups, and others as near to them as differences need."""
    share = 1.0 + 1e-6 * (np.arange(21) % width)
    return x0[:, leaders(21, width)] * share, p[:, leaders(21, width)] * share


def close(first: Array, second: Array) -> None:
    np.testing.assert_allclose(first, second, rtol=1e-9, atol=1e-9 * np.abs(second).max())


@pytest.mark.parametrize('name', PLANTS)
def test_both_backends_take_the_same_steps(name: str) -> None:
    (compiled, plain), grid, x0, p = case(name)
    counts = compiled.counts(grid, x0, p)
    np.testing.assert_array_equal(counts, plain.counts(grid, x0, p))
    assert counts.min() >= 1
    for width in (1, 7, 21):
        found, expected = (
            k.trajectories(grid, *near(x0, p, width), width) for k in (compiled, plain)
        )
        close(found[0], expected[0])
        close(found[1], expected[1])
    prefixes = np.array([3, 3, 20, 40])
    close(compiled.squares(grid, prefixes, x0, p), plain.squares(grid, prefixes, x0, p))
    for nodes in (1, 13, 40):
        found, expected = (k.grams(grid, nodes, *near(x0, p, 7), 7) for k in (compiled, plain))
        close(found, expected)


@pytest.mark.parametrize('name', PLANTS)
def test_parameters_that_change_are_followed_by_both_backends(name: str) -> None:
    both, grid, x0, p = case(name)
    sets = np.stack([p, 1.1 * p, 0.8 * p])
    along = np.repeat([0, 1, 2], [17, 1, 22])
    there = np.where(along == 2, 2, 0)
    found, expected = (k.scheduled(grid, x0, sets, along, there) for k in both)
    close(found[0], expected[0])
    close(found[1], expected[1])
    # As if candidates went on from there with the new values.
    before = both[0].trajectories(grid.stretch(0, 17), x0, p)[0]
    np.testing.assert_array_equal(found[0][:18], before)
    rest = grid.stretch(18, 39)
    after = both[0].trajectories(rest, found[0][18], sets[2])[0]
    scale = np.abs(after).max(axis=(0, 2), keepdims=True)
    np.testing.assert_allclose(found[0][18:] / scale, after / scale, atol=2e-3)


def test_squares_are_those_of_the_trajectories() -> None:
    (compiled, _), grid, x0, p = case('relaxing')
    off = grid.weight[:, :, None] * (compiled.trajectories(grid, x0, p)[1] - grid.y[:, :, None])
    squares = compiled.squares(grid, np.array([40]), x0, p)
    np.testing.assert_allclose(squares[0], np.sum(off**2, axis=0), rtol=1e-12)


def test_a_candidate_is_the_same_to_the_last_bit_in_any_lane() -> None:
    (compiled, _), grid, x0, p = case('relaxing')
    every = compiled.trajectories(grid, x0, p)[0]
    for lane in (0, 5, 20):
        alone = compiled.trajectories(grid, x0[:, [lane]], p[:, [lane]])[0]
        np.testing.assert_array_equal(alone[..., 0], every[..., lane])


def test_without_a_tolerance_steps_are_those_of_the_grid() -> None:
    (compiled, plain), grid, x0, p = case('motor')
    fixed = replace(grid, tolerance=0.0).stepped(3 * grid.steps)
    assert (compiled.counts(fixed, x0, p) == 3).all()
    close(compiled.trajectories(fixed, x0, p)[0], plain.trajectories(fixed, x0, p)[0])


def test_a_lost_candidate_is_nan_and_the_others_are_as_before() -> None:
    (compiled, plain), grid, x0, p = case('relaxing')
    p = p.copy()
    p[0, 3] = np.nan
    found, expected = (k.trajectories(grid, x0, p)[0] for k in (compiled, plain))
    assert np.isnan(found[1:, :, 3]).all() and np.isfinite(np.delete(found, 3, axis=2)).all()
    close(np.delete(found, 3, axis=2), np.delete(expected, 3, axis=2))
