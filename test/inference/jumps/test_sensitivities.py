"""Tests of obs_ros.inference.jumps.sensitivities: one pass backward against rollouts."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from jump_windows import GAIN

from obs_ros import Record
from obs_ros.core.typing import Array
from obs_ros.inference.jumps.hypothesis import Hypothesis, hypothesis_at
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.jumps.screening import values_at
from obs_ros.inference.jumps.sensitivities import jumps_rehearsed, products
from obs_ros.inference.objective import Objective
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.inference.prior import Prior
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid, Injection
from obs_ros.models.three_tank import THREE_TANK

K = 60
POINT = np.array([0.5, 0.4, 0.45, 0.6, 0.5, 0.7])
NODES = (1, 7, 30, 58)


def window(backend: Any, *, injected: bool = False) -> PiecewiseProblem:
    rng = np.random.default_rng(4)
    t = np.cumsum(rng.uniform(0.5, 1.5, K))
    u = np.repeat(rng.uniform(5.0, 40.0, (K // 10, 2)), 10, axis=0)
    unknowns = Unknowns.of(THREE_TANK)
    kernels = kernels_for(THREE_TANK, backend)
    blank = Grid.of(THREE_TANK, Record(t, u, np.zeros((K, 2))), np.ones(2))
    y = kernels.trajectories(blank, *unknowns.values(POINT[None]))[1][:, :, 0]
    y += 0.1 * rng.standard_normal(y.shape)
    y[rng.random(y.shape) < 0.2] = np.nan
    grid = Grid.of(THREE_TANK, Record(t, u, y), np.full(2, 0.1))
    if injected:
        known = grid.weight > 0.0
        gain = np.where(known[:, :, None], rng.uniform(0.0, 0.3, (K, 2, 6)), 0.0)
        gain[:, :, 3:] = 0.0
        cross = np.zeros((K, 2, 2))
        cross[:, 1, 0] = np.where(known.all(axis=1), 0.1, 0.0)
        grid = replace(grid, injection=Injection(gain, cross, np.zeros(0, dtype=np.int64)))
    return PiecewiseProblem(Objective(kernels, grid, unknowns), Prior.box(unknowns))


def rolled_out(base: Hypothesis, node: int, place: int) -> Array:
    """Return the shape (M,) of a jump of one parameter at a node, by two rollouts."""
    t = base.problem.objective.grid.t
    time = (t[node] - t[0]) / (t[-1] - t[0])
    value = values_at(base, place, np.array([time]))[0]
    probe = replace(base.problem, events=(*base.problem.events, (place,)))
    points = np.repeat(np.concatenate([base.point, [time, value]])[None], 2, axis=0)
    points[:, -1] += 1e-6, -1e-6
    for jump in base.layout.jumped(base.point):  # the later values move along
        if jump.parameter == place and base.point[base.layout.times[jump.event]] > time:
            points[:, jump.after] += 1e-6, -1e-6
    rows = probe.rows(points)
    return np.asarray((rows[:, 0] - rows[:, 1]) / 2e-6)


@pytest.mark.parametrize('backend', ['numpy', None])
@pytest.mark.parametrize('injected', [False, True], ids=['free', 'corrected'])
@pytest.mark.parametrize('events', [(), ((4,),), ((3, 5), (4,))], ids=['none', 'one', 'two'])
def test_products_are_those_of_rollouts(backend: Any, injected: bool, events: Any) -> None:
    problem = replace(window(backend, injected=injected), events=events)
    jumps = [[share, *(0.9 * POINT[list(event)])] for share, event in zip((0.33, 0.61), events)]
    base = hypothesis_at(problem, np.concatenate([POINT, *jumps]))
    assert len([*jumps_rehearsed(problem.objective.kernels)]) == 2
    columns = np.column_stack([base.linearisation.residual, base.linearisation.jacobian])
    squares, crossed = products(base, [3, 4, 5], problem.at_nodes(columns))
    assert squares.shape == (K, 3) and crossed.shape == (K, 3, 1 + base.point.size)
    for node in NODES:
        for j, place in enumerate((3, 4, 5)):
            shape = rolled_out(base, node, place)
            assert squares[node, j] == pytest.approx(shape @ shape, rel=1e-6, abs=1e-6)
            size = (1.0 + np.linalg.norm(shape)) * np.linalg.norm(columns, axis=0)
            off = (crossed[node, j] - shape @ columns) / size
            np.testing.assert_allclose(off, 0.0, atol=1e-6)


def test_a_candidate_that_diverges_has_no_shape() -> None:
    problem = window(None)
    base = hypothesis_at(problem, POINT)
    trajectory = base.trajectory[0].copy()
    trajectory[30:] = np.nan
    base.__dict__['trajectory'] = trajectory, base.trajectory[1]
    squares, crossed = products(base, [GAIN + 3], np.ones((K, 2, 1)))
    assert np.isfinite(squares).all() and np.isfinite(crossed).all()
    assert squares[40, 0] == 0.0 and squares[5, 0] > 0.0
