"""Tests of obs_ros.integration.graded."""

from dataclasses import replace

import numpy as np
from plants import OSCILLATOR, square_wave

from obs_ros import Record
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.graded import MOST_LEVELS, graded, levels
from obs_ros.integration.grid import Grid

T = np.array([0.0, 0.4, 1.0, 1.2])
RECORD = Record(T, square_wave(T)[:, None], np.arange(8.0).reshape(4, 2))


def grid_of(steps: list[int]) -> Grid:
    plain = Grid.of(replace(OSCILLATOR, max_step=np.inf), RECORD, np.ones(2))
    return plain.stepped(np.array(steps))


def test_halvings_lead_from_the_longest_step_to_the_fastest_mode() -> None:
    assert levels(0.1, 5.0) == 0
    assert levels(0.1, 10.0 * 2.0**5) == 5
    assert levels(0.1, 11.0 * 2.0**5) == 6
    assert levels(1.0, 1e30) == MOST_LEVELS
    assert levels(1.0, np.nan) == levels(1.0, np.inf) == 0


def test_the_first_step_of_each_interval_doubles_from_short_ones() -> None:
    grid = grid_of([1, 3, 2])
    finer, nodes = graded(grid, 2)
    first = [0.0, 0.1, 0.2, 0.4]
    second = [0.45, 0.5, 0.6, 1.0]
    third = [1.025, 1.05, 1.1, 1.2]
    np.testing.assert_allclose(finer.t, first + second + third, atol=1e-15)
    assert finer.steps.tolist() == [1, 1, 1, 1, 1, 1, 2, 1, 1, 1, 1]
    assert nodes.tolist() == [0, 3, 7, 11]
    np.testing.assert_array_equal(finer.t[nodes], T)
    np.testing.assert_array_equal(finer.weight[nodes], grid.weight)
    np.testing.assert_array_equal(finer.y[nodes], grid.y)
    assert not np.delete(finer.measured, nodes).any()


def test_rollouts_in_graded_steps_show_the_same_plant_at_its_nodes() -> None:
    grid = grid_of([40, 40, 40])
    finer, nodes = graded(grid, 6)
    kernels = kernels_for(replace(OSCILLATOR, max_step=np.inf), 'numpy')
    x0, p = np.array([[1.0], [-0.5]]), np.array([[1.5], [0.5]])
    wanted, found = (kernels.trajectories(each, x0, p)[1] for each in (grid, finer))
    np.testing.assert_allclose(found[nodes], wanted, rtol=1e-7)
