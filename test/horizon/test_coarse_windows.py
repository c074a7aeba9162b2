"""Windows measured by saturated and by coarse sensors."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from obs_ros import Estimate, Model, Outcome, Record, Variable, solve_window
from obs_ros.core.deadline import Deadline
from obs_ros.core.rng import random_generator
from obs_ros.core.typing import Array
from obs_ros.horizon.moving_horizon import MovingHorizon
from obs_ros.horizon.settings import EstimationSettings
from obs_ros.horizon.solver import Solver

TANK = Model(
    name='leaking_tank',
    states=(Variable('level', 'V', lower=0.0, upper=30.0),),
    inputs=(Variable('inflow'),),
    outputs=(Variable('y', 'V'),),
    parameters=(
        Variable('gain', lower=0.1, upper=10.0),
        Variable('leak', '1/s', lower=0.01, upper=2.0),
    ),
    dynamics=lambda t, x, u, p: (p[0] * u[0] - p[1] * x[0],),
    output=lambda t, x, u, p: (x[0],),
    max_step=0.1,
)
TRUTH = {'gain': 1.0, 'leak': 0.3}
NODES, WINDOWS, PERIOD = 200, 6, 0.1
NOISE = 0.05  # V


def with_output(**changes: Any) -> Model:
    return replace(TANK, outputs=(replace(TANK.outputs[0], **changes),))


def driven(seed: int, most: float = 6.0) -> tuple[Array, Array, Array]:
    """Times, inflows that change every 4 s, and the exact levels."""
    rng = np.random.default_rng(seed)
    t = PERIOD * np.arange(NODES * WINDOWS)
    u = np.repeat(rng.uniform(0.0, most, t.size // 40 + 1), 40)[: t.size]
    x = np.empty(t.size)
    x[0] = 5.0
    for k in range(t.size - 1):
        rest = u[k] / 0.3
        x[k + 1] = rest + (x[k] - rest) * np.exp(-0.3 * PERIOD)
    return t, u, x


def solved(model: Model, y: Array, u: Array, t: Array, **settings: Any) -> list[Estimate]:
    """The estimates of abutting windows, in sequence."""
    horizon = MovingHorizon(Solver.of(model, EstimationSettings(**settings)))
    parts = [slice(w * NODES, (w + 1) * NODES) for w in range(WINDOWS)]
    return [
        horizon.solve(Record(t[part], u[part], y[part]), random_generator(1, w), Deadline())
        for w, part in enumerate(parts)
    ]


def misses(estimates: list[Estimate]) -> Array:
    """Errors of the parameters in units of their deviations, where these are told."""
    off = np.array([
        [(e.parameters[name] - value) / e.stddev[name] for name, value in TRUTH.items()]
        for e in estimates
    ])  # fmt: skip
    return off[np.isfinite(off)]


@pytest.mark.parametrize('noise', [{'y': NOISE}, None], ids=['given', 'learned'])
def test_a_sensor_that_saturates_half_of_the_time_tells_parameters_without_bias(noise: Any) -> None:
    """Not told of the range, the same windows are stale, or 30 % off and more."""
    found: list[Estimate] = []
    rng = np.random.default_rng(5)
    for seed in range(3):
        t, u, x = driven(seed)
        y = np.clip(x + NOISE * rng.standard_normal(x.size), 0.0, 10.0)
        assert 0.4 < np.mean(y == 10.0) < 0.7
        found += solved(with_output(range=(0.0, 10.0)), y, u, t, noise=noise)
    assert not any(e.outcome is Outcome.STALE_OUTPUT or e.jumps for e in found)
    converged = [e for e in found if e.outcome is Outcome.CONVERGED]
    assert len(converged) >= 15
    off = misses(converged)
    assert off.size == 2 * len(converged) and np.abs(off).max() < 4.0
    assert np.mean(np.abs(off) < 1.96) >= 0.85
    for e in converged:
        assert all(abs(e.parameters[n] / value - 1.0) < 0.03 for n, value in TRUTH.items())


def test_a_window_that_is_saturated_all_along_says_that_it_tells_nothing() -> None:
    t, u, _ = driven(0)
    record = Record(t[:NODES], u[:NODES], np.full(NODES, 10.0))
    estimate = solve_window(with_output(range=(0.0, 10.0)), record, seed=1, noise={'y': NOISE})
    assert estimate.outcome is Outcome.TOO_FEW_SAMPLES and '0 measured values' in estimate.message


def test_a_mean_noise_below_a_tenth_of_the_step_is_raised_by_that_of_rounding() -> None:
    """A spring seen by a converter of 8 bits, its noise given as a sixteenth of the step."""
    step, found, plain = 4.0 / 255.0, [], []
    spring = Model(
        name='spring',
        states=(Variable('s', 'm', -5.0, 5.0), Variable('v', 'm/s', -20.0, 20.0)),
        inputs=(Variable('force'),),
        outputs=(Variable('y', 'm', resolution=step),),
        parameters=(Variable('gain', lower=1.0, upper=40.0), Variable('leak', upper=5.0, lower=0)),
        dynamics=lambda t, x, u, p: (x[1], u[0] - p[0] * x[0] - p[1] * x[1]),
        output=lambda t, x, u, p: (x[0],),
        max_step=0.02,
    )
    blind = replace(spring, outputs=(replace(spring.outputs[0], resolution=None),))
    rng = np.random.default_rng(2)
    for seed in range(4):
        t = 0.02 * np.arange(150)
        start = rng.uniform(0.5, 1.5)
        w, d = np.sqrt(16.0 - 0.09), 0.3
        x = start * np.exp(-d * t) * (np.cos(w * t) + d / w * np.sin(w * t))
        y = np.round((x + 0.001 * rng.standard_normal(t.size)) / step) * step
        for model, into in ((spring, found), (blind, plain)):
            into.append(
                solve_window(
                    model, Record(t, 0.0 * t, y), seed=seed, noise={'y': 0.001}, process_noise='off'
                )
            )
    truth = {'gain': 16.0, 'leak': 0.6}
    assert [e.outcome for e in found] == [Outcome.CONVERGED] * 4
    assert Outcome.CONVERGED not in [e.outcome for e in plain]
    for e in found:
        assert all(abs(e.parameters[n] - v) < 4.0 * e.stddev[n] for n, v in truth.items())
        assert e.stddev['gain'] < 0.005 * 16.0


@pytest.mark.parametrize('declared', [True, False])
def test_a_coarse_sensor_loses_no_window_as_stuck(declared: bool) -> None:
    """Levels in whole volts, with long runs of equal values, beside a second sensor."""
    t, u, x = driven(1)
    rng = np.random.default_rng(1)
    output = replace(TANK.outputs[0], resolution=1.0 if declared else None)
    model = replace(
        TANK,
        outputs=(output, Variable('z', 'V')),
        output=lambda t, x, u, p: (x[0], x[0] + 0.0 * u[0]),
    )
    y = np.column_stack([np.round(x), x + NOISE * rng.standard_normal(x.size)])
    runs = np.diff(np.flatnonzero(np.diff(y[:, 0], prepend=np.nan) != 0.0))
    assert runs.max() > 30
    found = solved(model, y, u, t)
    assert not any('repeats the same value' in e.message for e in found)
    learned = [e.figures.get('resolution.y') for e in found]
    assert learned[-1] == (None if declared else 1.0)
    assert all(abs(e.parameters['leak'] / 0.3 - 1.0) < 0.1 for e in found if e.usable)


def test_an_actuator_s_range_clips_what_the_plant_gets() -> None:
    t, u, x = driven(2)
    commanded = np.where(u > 4.0, 9.0, u)
    _, applied, _ = t, np.minimum(commanded, 4.0), x
    y = np.empty(t.size)
    y[0] = 5.0
    for k in range(t.size - 1):
        rest = applied[k] / 0.3
        y[k + 1] = rest + (y[k] - rest) * np.exp(-0.3 * PERIOD)
    y += NOISE * np.random.default_rng(0).standard_normal(y.size)
    model = replace(TANK, inputs=(replace(TANK.inputs[0], range=(0.0, 4.0)),))
    record = Record(t[:NODES], commanded[:NODES], y[:NODES])
    clipped = solve_window(model, record, seed=1, noise={'y': NOISE}, process_noise='off')
    naive = solve_window(TANK, record, seed=1, noise={'y': NOISE}, process_noise='off')
    assert clipped.outcome is Outcome.CONVERGED and naive.outcome is not Outcome.CONVERGED
    assert clipped.parameters['gain'] == pytest.approx(1.0, abs=4.0 * clipped.stddev['gain'])
