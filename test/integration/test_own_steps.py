"""Tests of obs_ros.integration.own_steps."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from stiff_plants import MOTOR, truth, van_der_pol

from obs_ros import Model, Record, Variable
from obs_ros.core.typing import Array
from obs_ros.integration.grid import Grid
from obs_ros.integration.own_steps import CONTROL, Layout, floors, followed, leaders

RELAXING = replace(van_der_pol(100.0), integrator='rosenbrock')
T = np.linspace(0.0, 120.0, 41)


def laid(model: Model, t: Array = T, u: Any = None, **changes: Any) -> Grid:
    record = Record(t, u, np.zeros((t.size, len(model.outputs))))
    grid = Grid.of(model, record, np.ones(len(model.outputs)))
    return replace(grid, **{'tolerance': 1e-5, 'budget': 100_000, **changes})


def column(*values: float) -> Array:
    return np.array(values)[:, None]


@pytest.mark.parametrize(('count', 'width'), [(1, 1), (21, 1), (21, 7), (21, 21), (48, 24), (3, 3)])
def test_every_group_has_its_leader_in_each_of_its_chunks(count: int, width: int) -> None:
    layout = Layout.of(count, width)
    lanes = layout.order.reshape(layout.lead.shape)
    np.testing.assert_array_equal(layout.order[layout.place], np.arange(count))
    led = np.take_along_axis(lanes, layout.lead, axis=1)
    np.testing.assert_array_equal(led, leaders(count, width)[lanes])
    assert len(lanes) <= -(-count // 15) + 1


def test_errors_fall_with_the_tolerance() -> None:
    start = (1.5, -1.5 / 125.0)
    exact = truth(RELAXING, T, np.empty((41, 0)), start, (100.0,))[:, 0]
    errors = []
    for tolerance in (1e-4, 1e-6, 1e-8):
        grid = laid(RELAXING, tolerance=tolerance)
        track, _ = followed(RELAXING, grid, 41, column(*start), column(100.0), leaders(1, 1))
        errors.append(np.abs(track[:, 0, 0] - exact).max())
    assert errors[0] < 2e-3 and errors[1] < 1e-4 and errors[2] < 5e-6


def test_steps_are_many_where_the_candidate_itself_jumps() -> None:
    x0 = np.array([[1.5, 1.9], [-1.5 / 125.0, -1.9 / 261.0]])
    grid = laid(RELAXING)
    track, counts = followed(RELAXING, grid, 41, x0, np.full((1, 2), 100.0), leaders(2, 1))
    jumps = np.argmax(track[:, 0] < 0.0, axis=0) - 1
    assert jumps[1] > jumps[0] + 5
    for lane, jump in enumerate(jumps):
        elsewhere = np.delete(counts[1:, lane], [jump - 2, jump - 1, jump])
        assert counts[jump, lane] > 10 * np.median(elsewhere)


def test_differences_of_a_group_are_derivatives() -> None:
    """Of x at the end by mu, past a jump: by candidates 1e-7 apart as by those 1e-4 apart."""
    grid, slopes = laid(RELAXING, tolerance=1e-7), []
    for step in (1e-7, 1e-4):
        p = np.array([[100.0, 100.0 + step, 100.0 - step]])
        x0 = np.repeat(column(1.5, -1.5 / 125.0), 3, axis=1)
        end = followed(RELAXING, grid, 41, x0, p, leaders(3, 3))[0][-1, 0]
        slopes.append((end[1] - end[2]) / (2.0 * step))
    assert slopes[0] == pytest.approx(slopes[1], rel=1e-3) and abs(slopes[0]) > 1e-3


def test_a_fast_start_is_resolved_that_long_steps_would_pass_over() -> None:
    """A rate of 1500 1/s dies within .5 ms and yet moves x by .4, in intervals of 12 s."""
    model = replace(van_der_pol(1000.0), integrator='rosenbrock')
    t = np.linspace(0.0, 240.0, 21)
    exact = truth(model, t, np.empty((21, 0)), (-1.9, 1500.0), (1000.0,))[:, 0]
    track, _ = followed(
        model, laid(model, t), 21, column(-1.9, 1500.0), column(1000.0), leaders(1, 1)
    )
    assert np.abs(track[:, 0, 0] - exact).max() < 1e-3


def test_inputs_that_leap_begin_with_short_steps() -> None:
    t = 0.01 * np.arange(30)
    u = np.where(np.arange(30) < 15, 5.0, -5.0)[:, None]
    model = replace(MOTOR, integrator='rosenbrock')
    grid = laid(model, t, u)
    np.testing.assert_array_equal(np.flatnonzero(grid.fresh), [0, 15])
    track, counts = followed(model, grid, 30, column(0.0, 0.0), column(1.0, 0.05), leaders(1, 1))
    exact = truth(model, t, u, (0.0, 0.0), (1.0, 0.05))
    assert np.abs(track[:, 1, 0] - exact[:, 0]).max() < 1e-4 * np.abs(exact).max()
    assert counts[15, 0] > 3 * np.median(counts[5:15, 0])


def test_no_step_is_longer_than_the_grid_allows() -> None:
    grid = laid(RELAXING, longest=0.5)
    _, counts = followed(RELAXING, grid, 41, column(1.9, 0.0), column(100.0), leaders(1, 1))
    assert counts.min() >= 6


def test_who_blows_up_or_spends_the_budget_is_lost_and_no_one_else() -> None:
    model = Model(
        'growing', (Variable('x', lower=0.0, upper=10.0),), (Variable('x'),),
        lambda t, x, u, p: (p[0] * x[0],), lambda t, x, u, p: (x[0],),
        parameters=(Variable('p'),), integrator='rosenbrock',
    )  # fmt: skip
    t = np.linspace(0.0, 1.0, 11)
    p, x0 = np.array([[0.5, 5e3]]), np.ones((1, 2))
    grid = laid(model, t, tolerance=1e-3)
    track, counts = followed(model, grid, 11, x0, p, leaders(2, 1))
    np.testing.assert_allclose(track[:, 0, 0], np.exp(0.5 * t), rtol=1e-3)
    lost = np.isnan(track[:, 0, 1])  # e^710 is no number any more
    assert lost[2:].all() and not lost[:2].any() and counts[:, 1].sum() < 10_000
    cheap, counts = followed(model, replace(grid, budget=100), 11, x0, p, leaders(2, 1))
    assert np.isnan(cheap[1:, 0, 1]).all() and counts[:, 1].sum() == 100
    np.testing.assert_array_equal(cheap[:, 0, 0], track[:, 0, 0])


def test_states_have_sizes_where_their_ranges_are_open_too() -> None:
    model = replace(RELAXING, states=(Variable('x', lower=-3.0, upper=3.0), Variable('rate')))
    np.testing.assert_allclose(floors(model), CONTROL.floor * np.array([6.0, 1.0]))
