"""Tests of obs_ros.integration.delayed: against exact solutions, and of estimates by it."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from late_inputs import INTERVAL, TRUTH, VALVE, exact, steps_of_input
from late_inputs import measured as measured_late
from offset_spring import measured, plain_window, spring
from plants import LAG, lag_outputs, square_wave

from obs_ros import Model, Record, Variable, solve_window
from obs_ros.core.typing import Array
from obs_ros.integration.backends import Kernels, kernels_for
from obs_ros.integration.delayed import DelayedKernels, delay_names
from obs_ros.integration.grid import Grid

BACKENDS = ['numba', 'numpy']


IMU = Model(
    name='imu',
    states=(Variable('position', 'm', -50.0, 50.0), Variable('velocity', 'm/s', -10.0, 10.0)),
    inputs=(Variable('acceleration', 'm/s2', interpolation='linear'),),
    outputs=(Variable('pose', 'm', delay=(-0.1, 0.2)),),
    parameters=(Variable('bias', 'm/s2', -1.0, 1.0),),
    dynamics=lambda t, x, u, p: (x[1], u[0] - p[0]),
    output=lambda t, x, u, p: (x[0],),
    max_step=0.0025,
)


@pytest.fixture(params=BACKENDS)
def backend(request: Any) -> Any:
    if request.param == 'numba':
        pytest.importorskip('numba')
    return request.param


def lag_kernels(backend: Any, **delay: Any) -> tuple[Model, Kernels]:
    model = replace(
        LAG,
        inputs=[replace(v, delay=delay.get('u')) for v in LAG.inputs],
        outputs=[replace(v, delay=delay.get('y')) for v in LAG.outputs],
    )
    return model, kernels_for(model, backend)


def test_outputs_are_those_at_the_times_of_their_measurement(backend: Any) -> None:
    model, kernels = lag_kernels(backend, y=(-0.5, 0.5))
    t = 0.2 * np.arange(31)
    u = square_wave(t)
    grid = Grid.of(model, Record(t, u, np.zeros(31)), np.ones(1))
    delays = np.array([-0.33, 0.0, 0.07, 0.5])
    p = np.array([[2.0] * 4, [1.5] * 4, delays])
    _, outputs = kernels.trajectories(grid, np.full((1, 4), 0.3), p)
    for lane, delay in enumerate(delays):
        inside = (t - delay >= 0.0) & (t - delay <= t[-1])
        fine = np.unique(np.concatenate([t, t[inside] - delay]))
        exact = lag_outputs(fine, square_wave(fine), 0.3, np.tile([2.0, 1.5], (fine.size, 1)))
        expected = exact[np.searchsorted(fine, t[inside] - delay)]
        assert outputs[inside, 0, lane] == pytest.approx(expected, abs=2e-6)
    assert grid.measured.tolist() == [0.5 - 1e-6 <= s <= 5.5 + 1e-6 for s in t]


def test_inputs_act_late_by_the_delay(backend: Any) -> None:
    model, kernels = lag_kernels(backend, u=(0.0, 1.0))
    t = 0.2 * np.arange(31)
    grid = Grid.of(model, Record(t, square_wave(t), np.zeros(31)), np.ones(1))
    delays = np.array([0.0, 0.13, 0.9])
    p = np.array([[2.0] * 3, [1.5] * 3, delays])
    _, outputs = kernels.trajectories(grid, np.full((1, 3), 0.3), p)
    for lane, delay in enumerate(delays):
        fine = np.unique(np.concatenate([t, t + delay]))
        held = square_wave(np.maximum(fine - delay, 0.0))
        exact = lag_outputs(fine, held, 0.3, np.tile([2.0, 1.5], (fine.size, 1)))
        assert outputs[:, 0, lane] == pytest.approx(exact[np.searchsorted(fine, t)], abs=2e-6)


def test_inputs_that_act_late_and_not_linearly_are_integrated_from_leap_to_leap(
    backend: Any,
) -> None:
    t = INTERVAL * np.arange(81)
    u = steps_of_input(np.random.default_rng(1), t.size)
    grid = Grid.of(VALVE, Record(t, u, np.zeros(81)), np.ones(1))
    delays = INTERVAL * np.array([0.0, 0.1, 0.5, 1.0, 2.7, 8.0])
    p = np.array([*np.tile(TRUTH, (delays.size, 1)).T, delays])
    _, outputs = kernels_for(VALVE, backend).trajectories(grid, np.ones((1, delays.size)), p)
    for lane, delay in enumerate(delays):
        # A tenth of the noise at 40 dB is 1e-3.
        assert outputs[:, 0, lane] == pytest.approx(exact(VALVE, t, u, delay)[:, 0], abs=1e-6)


@pytest.mark.parametrize('intervals', [0.1, 1.0, 2.5])
def test_the_dead_time_of_a_valve_is_found(intervals: float) -> None:
    for seed in (2, 3):
        record, sigma = measured_late(VALVE, intervals, seed)
        estimate = solve_window(VALVE, record, seed=1, noise={'y0': float(sigma[0])})
        assert estimate.outcome == 'converged'
        deviations, off = errors(estimate, 'u.delay', intervals * INTERVAL, INTERVAL)
        assert deviations < 3.0 and off < 0.05


def test_squares_of_the_first_nodes_are_those_of_the_whole_window(backend: Any) -> None:
    rng = np.random.default_rng(6)
    model = spring((-0.1, 0.1), (0.0, 0.1))
    record, sigma = measured(rng, -0.05, 0.03)
    kernels = kernels_for(model, backend)
    grid = Grid.of(model, plain_window(record), sigma)
    x0, p = np.zeros((2, 3)), np.array([[40.0] * 3, [0.8] * 3, [0.03, 0.0, 0.1], [-0.1, 0.05, 0.0]])
    _, outputs = kernels.trajectories(grid, x0, p)
    squares = (grid.weight[:, :, None] * (outputs - grid.y[:, :, None])) ** 2
    found = kernels.squares(grid, np.array([30, 31, 90]), x0, p)
    blocks = [squares[a:b].sum(axis=0) for a, b in ((0, 30), (30, 31), (31, 90))]
    np.testing.assert_allclose(found, blocks, rtol=1e-9)


def test_a_model_without_estimated_delays_has_the_kernels_of_before(backend: Any) -> None:
    known = replace(LAG, outputs=[replace(v, delay=0.3) for v in LAG.outputs])
    assert not isinstance(kernels_for(known, backend), DelayedKernels)
    assert delay_names(known) == () and delay_names(IMU) == ('pose.delay',)


def errors(estimate: Any, name: str, truth: float, interval: float) -> tuple[float, float]:
    """The error in standard deviations, and in sample intervals."""
    off = abs(estimate.parameters[name] - truth)
    return off / estimate.stddev[name], off / interval


@pytest.mark.parametrize('intervals', [0.1, 0.5, 1.3, 5.0, -1.7])
def test_an_offset_of_an_output_is_found_in_one_window_of_a_spring(intervals: float) -> None:
    for seed in range(3):
        record, _ = measured(np.random.default_rng(seed), 0.02 * intervals, 0.0)
        estimate = solve_window(spring((-0.05, 0.12)), plain_window(record), seed=1)
        assert estimate.outcome == 'converged'
        deviations, off = errors(estimate, 'speed.delay', 0.02 * intervals, 0.02)
        assert deviations < 3.0 and off < 0.05
        assert errors(estimate, 'k', 40.0, 1.0)[0] < 3.0


@pytest.mark.parametrize('intervals', [0.1, 1.0, 2.5, 5.0])
def test_a_dead_time_of_an_input_is_found(intervals: float) -> None:
    for seed in range(3):
        record, _ = measured(np.random.default_rng(seed), 0.0, 0.02 * intervals)
        estimate = solve_window(spring(force=(0.0, 0.15)), record, seed=1)
        assert estimate.t0 == pytest.approx(0.0, abs=1e-9)
        deviations, off = errors(estimate, 'force.delay', 0.02 * intervals, 0.02)
        assert deviations < 3.0 and off < 0.05


def test_a_dead_time_and_an_offset_are_found_together() -> None:
    record, _ = measured(np.random.default_rng(1), -0.03, 0.057)
    estimate = solve_window(spring((-0.1, 0.1), (0.0, 0.15)), record, seed=1)
    for name, truth in (('force.delay', 0.057), ('speed.delay', -0.03)):
        deviations, off = errors(estimate, name, truth, 0.02)
        assert deviations < 3.0 and off < 0.05
        lower, upper = estimate.interval[name]
        assert lower < estimate.parameters[name] < upper


def test_a_pose_at_10_hz_stamped_50_ms_late_beside_an_imu_at_400_hz() -> None:
    rng = np.random.default_rng(2)
    t = 0.0025 * np.arange(2001)
    w, phase, size = rng.uniform(1.0, 8.0, 4), rng.uniform(0.0, 6.0, 4), rng.uniform(0.5, 2.0, 4)

    def position(s: Array) -> Array:
        return np.asarray((size / w**2 * np.sin(np.outer(s, w) + phase)).sum(axis=1) + 0.3 * s)

    u = 0.1 - (size * np.sin(np.outer(t, w) + phase)).sum(axis=1)
    y, k = np.full((t.size, 1), np.nan), np.arange(0, t.size, 40)
    y[k, 0] = position(t[k] - 0.05)
    y[k, 0] += 0.01 * np.std(y[k, 0]) * rng.standard_normal(k.size)
    estimate = solve_window(IMU, Record(t, u, y), seed=1)
    deviations, off = errors(estimate, 'pose.delay', 0.05, 0.1)
    assert deviations < 3.0 and off < 0.05
    assert errors(estimate, 'bias', 0.1, 1.0)[0] < 3.0


def test_the_dead_time_of_a_slow_plant_is_found() -> None:
    rng = np.random.default_rng(4)
    fine = 0.01 * np.arange(-100, 6001)
    u = np.where(np.sin(fine // 1.0 * 1.7) > 0.0, 1.0, 0.0)  # new every second at most
    late = np.interp(fine - 0.34, fine, np.arange(fine.size))
    x = lag_outputs(fine, u[np.floor(late + 1e-9).astype(int)], 0.0,
                    np.tile([2.0, 3.0], (fine.size, 1)))  # fmt: skip
    at = np.arange(0, fine.size, 10)
    y = x[at] + 0.01 * x.std() * rng.standard_normal(at.size)
    y[:10] = np.nan
    model = replace(LAG, inputs=[replace(v, delay=(0.0, 1.0)) for v in LAG.inputs])
    estimate = solve_window(model, Record(fine[at], u[at], y), seed=1)
    deviations, off = errors(estimate, 'u.delay', 0.34, 0.1)
    assert deviations < 3.0 and off < 0.05
