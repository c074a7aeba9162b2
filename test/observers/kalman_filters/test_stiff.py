"""Kalman filters on stiff plants without a step given, beside filters in a hundred times more."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from sampled_stiff_plants import MOTOR, chain, van_der_pol

from obs_ros import Sample
from obs_ros.core.model import Model
from obs_ros.core.typing import Array
from obs_ros.observers.base import load_observer
from plant_sim.plant import Plant
from plant_sim.signals import constant

# Model, start, inputs in turn, parameters, interval (s), outputs, noise; fine steps an interval.
MOTOR_RUN = MOTOR, (0.0, 0.0), (12.0, -20.0, 5.0, 5.0), (0.05,), 0.01, 60, 0.5, 100
# It begins near a jump.
JUMP = van_der_pol(100.0), (1.1, -0.04), (), (100.0,), 2.0, 14, 0.01, 1000
CHAIN = chain(6), (20.0,) * 6, (60.0, 60.0, 80.0), (20.0,), 10.0, 40, 0.1, 100


def played(model: Model, x: Any, u: Any, p: Any, dt: float, count: int, sd: float) -> list[Sample]:
    """Return samples of the true plant, with noise of deviation sd."""
    rng, plant, samples = np.random.default_rng(1), Plant(model, x), []
    held: tuple[float, ...] = ()
    for k in range(count):
        plant.advance(k * dt, constant(*held), p)
        held = (u[k % len(u)],) if u else ()
        y = np.array(plant.output(held, p))
        y += sd * rng.standard_normal(y.size)
        samples.append(Sample(round(1e9 * k * dt), y=y, u=np.array(held)))
    return samples


def followed(observer: Any, samples: Sequence[Sample]) -> tuple[Array, Array]:
    """Return estimates and their deviations, both (K, n + q)."""
    found = []
    for sample in samples:
        assert sample.y is not None
        observer.absorb(replace(sample, y=sample.y.copy()))
        found.append((np.concatenate([observer.x, observer.p]), observer.stddev.copy()))
    values, deviations = zip(*found, strict=True)
    return np.array(values), np.array(deviations)


@pytest.mark.parametrize('name', ['ekf', 'ukf'])
@pytest.mark.parametrize('run', [MOTOR_RUN, JUMP, CHAIN], ids=lambda run: run[0].name)
def test_a_filter_is_where_one_of_a_hundred_times_finer_steps_is(name: str, run: Any) -> None:
    """Within .15 of its standard deviations, 95 % of them within .05."""
    model, x, _, p, dt, _, sd, steps = run
    samples = played(*run[:-1])
    given = {
        'noise': {v.name: sd for v in model.outputs},
        'initial': {v.name: value for v, value in zip(model.states, x, strict=True)},
        'backend': 'numpy',
    }
    observer = load_observer(name)(model, **given)  # type: ignore[call-arg]
    fine = load_observer(name)(  # type: ignore[call-arg]
        replace(model, integrator='rosenbrock', max_step=dt / steps), **given
    )
    (values, deviations), (exact, _) = followed(observer, samples), followed(fine, samples)
    off = np.abs(values - exact)[5:] / deviations[5:]
    assert np.nanquantile(off, 0.95) < 0.05
    assert np.nanmax(off) < 0.15
    assert observer.counts['reset_non_finite'] == 0
    estimate = observer.estimate()
    assert estimate is not None
    assert estimate.figures['integration_error_sd'] < 0.1
    assert any(key.startswith('integration_steps.') for key in estimate.figures)
    assert abs(values[-1, -1] - p[0]) < 4.0 * deviations[-1, -1]
