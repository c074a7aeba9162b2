"""Tests of both ways to roll candidates out: against scipy, and against each other."""

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from arx import ARX, A, B, course, pushes
from arx import X0 as ARX_START
from plants import BLOW_UP, NAN, OSCILLATOR, exact, with_interpolation
from spinner import SHAFT, TURN, UNWRAPPED, window

from obs_ros import Model, Record
from obs_ros.core.typing import Array
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid

rng = np.random.default_rng(1)
IRREGULAR = np.concatenate([[0.0], np.cumsum(rng.uniform(0.02, 0.3, 40))])
FORCE = rng.standard_normal((41, 1))
X0, P = (1.0, -0.5), (0.8, 0.7)


def grid_of(model: Model, t: Array, u: Any, y: Any = None, scale: Any = None) -> Grid:
    count = len(model.outputs)
    y = np.zeros((t.size, count)) if y is None else y
    return Grid.of(model, Record(t, u, y), np.ones(count) if scale is None else scale)


def column(*values: float) -> Array:
    return np.array(values, dtype=np.float64)[:, None]


def force(interpolation: str) -> Any:
    """The input of the exact solution, s seconds after node k."""

    def u(k: int, s: float) -> tuple[float]:
        here, after = FORCE[k, 0], FORCE[min(k + 1, 40), 0]
        if interpolation == 'hold':
            return (here,)
        if interpolation == 'mean':
            return (0.5 * (here + after),)
        gap = IRREGULAR[min(k + 1, 40)] - IRREGULAR[k]
        return (here + (after - here) * s / gap if gap else here,)

    return u


@pytest.mark.parametrize('interpolation', ['hold', 'linear', 'mean'])
def test_rk4_follows_the_exact_solution_with_every_kind_of_input(
    backend: str, interpolation: str
) -> None:
    model = replace(with_interpolation(OSCILLATOR, interpolation), max_step=0.02)
    grid = grid_of(model, IRREGULAR, FORCE)
    states, outputs = kernels_for(model, backend).trajectories(grid, column(*X0), column(*P))
    x, y = exact(model, IRREGULAR, force(interpolation), X0, P)
    np.testing.assert_allclose(states[:, :, 0], x, atol=2e-7)
    np.testing.assert_allclose(outputs[:, :, 0], y, atol=2e-7)


@pytest.mark.parametrize(('integrator', 'order'), [('rk4', 4), ('euler', 1)])
@pytest.mark.parametrize('interpolation', ['hold', 'linear'])
def test_order_of_convergence(
    backend: str, interpolation: str, integrator: Any, order: int
) -> None:
    t = np.array([0.0, 0.8, 1.6])
    plant = replace(with_interpolation(OSCILLATOR, interpolation), integrator=integrator)
    u = np.array([[0.5], [-1.0], [0.25]])

    def applied(k: int, s: float) -> tuple[float]:
        slope = (u[min(k + 1, 2), 0] - u[k, 0]) / 0.8 if interpolation == 'linear' else 0.0
        return (u[k, 0] + slope * s,)

    truth, _ = exact(plant, t, applied, X0, P)
    errors = []
    for steps in (8, 16, 32, 64):
        model = replace(plant, max_step=0.8 / steps)
        kernels = kernels_for(model, backend)
        states, _ = kernels.trajectories(grid_of(model, t, u), column(*X0), column(*P))
        errors.append(np.abs(states[-1, :, 0] - truth[-1]).max())
    for coarse, fine in pairwise(errors):
        assert coarse / fine == pytest.approx(2.0**order, rel=0.25)


def test_substeps_end_where_single_steps_end(backend: str) -> None:
    """Ten sub-steps of one interval are ten intervals."""
    model = replace(OSCILLATOR, max_step=0.1)
    kernels = kernels_for(model, backend)
    coarse = grid_of(model, np.array([0.0, 1.0]), np.full((2, 1), 0.3))
    fine = grid_of(model, np.linspace(0.0, 1.0, 11), np.full((11, 1), 0.3))
    a, b = (kernels.trajectories(grid, column(*X0), column(*P))[0] for grid in (coarse, fine))
    np.testing.assert_allclose(a[-1], b[-1], rtol=1e-12)


def missing_record(model: Model) -> Grid:
    draw = np.random.default_rng(3)
    y = draw.standard_normal((41, 2))
    y[draw.random((41, 2)) < 0.4] = NAN
    u = FORCE.copy()
    u[5:9] = NAN
    return grid_of(model, IRREGULAR, u, y, np.array([0.5, 3.0]))


def candidates(count: int, seed: int = 4) -> tuple[Array, Array]:
    draw = np.random.default_rng(seed)
    return draw.uniform(-2.0, 2.0, (2, count)), draw.uniform(0.2, 2.0, (2, count))


def test_squares_are_those_of_the_measured_residuals_between_prefixes(backend: str) -> None:
    kernels, grid = kernels_for(OSCILLATOR, backend), missing_record(OSCILLATOR)
    x0, p = candidates(5)
    _, outputs = kernels.trajectories(grid, x0, p)
    terms = (grid.weight[..., None] * (outputs - grid.y[..., None])) ** 2
    prefixes = np.array([1, 7, 8, 30, 41])
    squares = kernels.squares(grid, prefixes, x0, p)
    assert squares.shape == (5, 2, 5)
    for g, (first, last) in enumerate(pairwise([0, *prefixes])):
        np.testing.assert_allclose(squares[g], terms[first:last].sum(axis=0), rtol=1e-12)
    short = kernels.squares(grid, np.array([20]), x0, p)
    np.testing.assert_allclose(short[0], terms[:20].sum(axis=0), rtol=1e-12)


@pytest.mark.parametrize('count', [1, 2, 7, 8, 9, 15, 16, 17, 24, 33])
def test_both_kernels_agree_for_any_number_of_candidates(count: int) -> None:
    pytest.importorskip('numba')
    for interpolation in ('hold', 'linear', 'mean'):
        model = with_interpolation(OSCILLATOR, interpolation)
        grid, prefixes = missing_record(model), np.array([3, 11, 41])
        x0, p = candidates(count)
        a, b = kernels_for(model, 'numba'), kernels_for(model, 'numpy')
        for left, right in zip(
            (*a.trajectories(grid, x0, p), a.squares(grid, prefixes, x0, p)),
            (*b.trajectories(grid, x0, p), b.squares(grid, prefixes, x0, p)),
            strict=True,
        ):
            assert left.shape == right.shape
            np.testing.assert_allclose(left, right, rtol=1e-9, atol=1e-12)
        grams = [k.grams(grid, 41, x0, p, count) for k in (a, b)]
        np.testing.assert_allclose(*grams, rtol=1e-9, atol=1e-9)


def test_a_candidate_does_not_depend_on_its_neighbours(backend: str) -> None:
    kernels, grid = kernels_for(OSCILLATOR, backend), missing_record(OSCILLATOR)
    x0, p = candidates(40)
    together = kernels.squares(grid, np.array([41]), x0, p)
    for i in (0, 7, 8, 15, 16, 39):
        alone = kernels.squares(grid, np.array([41]), x0[:, [i]], p[:, [i]])
        np.testing.assert_array_equal(alone[..., 0], together[..., i])


def test_without_inputs_and_parameters(backend: str) -> None:
    t = np.linspace(0.0, 1.0, 21)
    grid = grid_of(BLOW_UP, t, None)
    x0 = np.array([[0.5, -1.0, 0.0]])
    states, _ = kernels_for(BLOW_UP, backend).trajectories(grid, x0, np.empty((0, 3)))
    np.testing.assert_allclose(states[:, 0], x0 / (1.0 - np.outer(t, x0)), atol=1e-8)


def test_a_candidate_that_diverges_harms_no_other(backend: str) -> None:
    kernels = kernels_for(BLOW_UP, backend)
    t = np.linspace(0.0, 1.0, 21)
    grid = grid_of(BLOW_UP, t, None)
    tame = np.random.default_rng(5).uniform(-1.0, 0.5, (1, 20))
    wild = tame.copy()
    wild[0, [3, 17]] = 1e3, np.nan
    none = np.empty((0, 20))
    others = np.delete(np.arange(20), [3, 17])
    expected = kernels.squares(grid, np.array([21]), tame, none)[0, 0]
    found = kernels.squares(grid, np.array([21]), wild, none)[0, 0]
    assert not np.isfinite(found[[3, 17]]).any()
    np.testing.assert_array_equal(found[others], expected[others])
    grams = kernels.grams(grid, 21, wild, none, 2)
    # Lane 3 is the perturbed one of start 1, lane 17 of start 8.
    assert not np.isfinite(grams[[1, 8], 1, 1]).any()
    assert np.isfinite(np.delete(grams, [1, 8], axis=0)).all()


def test_nan_where_nothing_was_measured_does_not_count(backend: str) -> None:
    kernels = kernels_for(BLOW_UP, backend)
    t = np.linspace(0.0, 1.0, 21)
    y = np.zeros((21, 1))
    y[1:] = NAN
    late = kernels.squares(grid_of(BLOW_UP, t, None, y), np.array([21]), column(1e3), column())
    assert late[0, 0, 0] == 1e6


def shafts(count: int = 24) -> tuple[Array, Array]:
    """Initial states and parameters of candidates, some of which turn much too fast."""
    draw = np.random.default_rng(5).uniform
    x0 = np.array([draw(-4.0, 4.0, count), draw(-30.0, 30.0, count)])
    return x0, np.array([draw(0.1, 20.0, count), draw(0.01, 5.0, count)])


def test_residuals_of_angles_go_by_the_shortest_way_on_both_backends() -> None:
    """NumPy has the residuals of a record without wraps, less whole turns."""
    pytest.importorskip('numba')
    record, unwrapped, _ = window(torque=4.0)
    scale, prefixes = np.array([0.02, 0.1]), np.array([7, 30, 61])
    grid, x0, p = Grid.of(SHAFT, record, scale), *shafts()
    other = Grid.of(UNWRAPPED, unwrapped, scale)
    off = kernels_for(UNWRAPPED, 'numpy').trajectories(other, x0, p)[1] - other.y[:, :, None]
    off = other.weight[:, :, None] * (off - TURN * np.round(off / TURN))
    for backend in ('numpy', 'numba'):
        kernels = kernels_for(SHAFT, backend)
        found = kernels.squares(grid, prefixes, x0, p)
        blocks = [off[a:b] for a, b in pairwise([0, *prefixes])]
        expected = np.array([np.sum(block**2, axis=0) for block in blocks])
        np.testing.assert_allclose(found, expected, rtol=1e-7, atol=1e-9)
        outputs = grid.nearest(kernels.trajectories(grid, x0, p)[1])
        residuals = grid.weight[:, :, None] * (outputs - grid.y[:, :, None])
        np.testing.assert_allclose(residuals, off, atol=1e-7)
        gram = kernels.grams(grid, 61, x0, p, 4)
        np.testing.assert_allclose(gram[:, 0, 0], expected.sum(axis=(0, 1))[::4], rtol=1e-7)


def test_differences_of_angles_do_not_see_where_a_residual_is_half_a_turn() -> None:
    """Candidates on either side of that: their outputs differ by little, not by a turn."""
    pytest.importorskip('numba')
    t = 0.05 * np.arange(20)
    record = Record(t, np.zeros(20), np.c_[np.full(20, 0.5), np.full(20, NAN)])
    grid = Grid.of(SHAFT, record, np.array([1.0, 1.0]))
    x0 = np.array([[0.5 + np.pi - 1e-6, 0.5 + np.pi + 1e-6], [0.0, 0.0]])
    p = np.array([[3.0, 3.0], [0.5, 0.5]])
    for backend in ('numpy', 'numba'):
        gram = kernels_for(SHAFT, backend).grams(grid, 20, x0, p, 2)
        np.testing.assert_allclose(gram[0, 0, 0], 20.0 * np.pi**2, rtol=1e-5)
        np.testing.assert_allclose(gram[0, 1, 1], 20.0 * 4e-12, rtol=1e-5)


def test_straight_residuals_are_those_of_the_same_numbers_without_a_period() -> None:
    record = window(torque=4.0)[1]
    x0, p = shafts()
    grids = [Grid.of(model, record, np.ones(2)) for model in (SHAFT, UNWRAPPED)]
    found, expected = (
        kernels_for(SHAFT, 'numpy').squares(grid, np.array([61]), x0, p)
        for grid in (grids[0].straight, grids[1])
    )
    np.testing.assert_array_equal(found, expected)


def test_a_discrete_model_goes_from_node_to_node(backend: str) -> None:
    """Nodes with jitter, under inputs of their own, and intervals of several periods."""
    rng, u = np.random.default_rng(5), pushes(40)
    t = 0.1 * np.arange(40) + rng.uniform(-0.01, 0.01, 40)
    expected, _ = course(u)
    x0, p = column(*ARX_START), column(*A, B)
    states, outputs = kernels_for(ARX, backend).trajectories(grid_of(ARX, t, u), x0, p)
    np.testing.assert_allclose(states[:, :, 0], expected, rtol=1e-12)
    np.testing.assert_allclose(outputs[:, 0, 0], expected[:, 0], rtol=1e-12)
    held = np.repeat(u[::4], 4)
    grid = grid_of(ARX, t[::4], held[::4])
    np.testing.assert_array_equal(grid.steps, 4)
    states, _ = kernels_for(ARX, backend).trajectories(grid, x0, p)
    np.testing.assert_allclose(states[:, :, 0], course(held)[0][::4], rtol=1e-12)
