"""Tests of obs_ros.models.three_tank, against Yang et al. 2020 and numbers checked with Radau."""

from dataclasses import replace

import numpy as np
import pytest

from obs_ros import Record
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid
from obs_ros.models.three_tank import THREE_TANK

# Valve openings in three windows of 1000 s, and the levels (cm) at their ends.
WINDOWS = (
    ((1.0, 1.0, 1.0), (21.25897, 14.17197, 17.71669)),
    ((0.7, 0.5, 1.0), (59.53719, 49.96477, 52.93330)),
    ((0.4, 0.5, 0.5), (86.27335, 52.72873, 65.42825)),
)


@pytest.mark.parametrize(('step', 'error'), [(1.0, 2e-5), (0.1, 1e-5)])
def test_levels_at_the_ends_of_the_three_windows(backend: str, step: float, error: float) -> None:
    if backend == 'numpy' and step < 1.0:
        pytest.skip('slow, and the other step says the same')
    model = replace(THREE_TANK, max_step=step)
    t = np.arange(1001.0)
    grid = Grid.of(model, Record(t, np.full((1001, 2), 30.0), np.zeros((1001, 2))), np.ones(2))
    levels = np.array([[0.0], [0.0], [60.0]])
    for openings, end in WINDOWS:
        p = np.array(openings).reshape(3, 1)
        levels = kernels_for(model, backend).trajectories(grid, levels, p)[0][-1]
        np.testing.assert_allclose(levels[:, 0], end, atol=error)


def test_volume_is_what_flows_in_less_what_flows_out() -> None:
    levels, openings = (31.0, 17.0, 22.0), (0.4, 0.9, 0.6)
    rates = THREE_TANK.dynamics(0.0, levels, (12.0, 7.0), openings)
    out = 0.9 * 0.6 * 0.6 * np.sqrt(2 * 981.0 * 17.0)  # Torricelli, eq. 16
    assert 100.0 * sum(rates) == pytest.approx(12.0 + 7.0 - out, rel=1e-12)


def test_flow_turns_round_with_the_heads_and_stops_when_they_are_equal() -> None:
    def h3_rate(h1: float, h2: float, h3: float) -> float:
        return float(THREE_TANK.dynamics(0.0, (h1, h2, h3), (0.0, 0.0), (1.0, 1.0, 1.0))[2])

    assert h3_rate(20.0, 20.0, 20.0) == 0.0
    assert h3_rate(30.0, 20.0, 20.0) == -h3_rate(10.0, 20.0, 20.0) > 0.0


def test_outputs_are_the_outer_levels() -> None:
    assert THREE_TANK.output(0.0, (1.0, 2.0, 3.0), (0.0, 0.0), (1.0, 1.0, 1.0)) == (1.0, 2.0)
