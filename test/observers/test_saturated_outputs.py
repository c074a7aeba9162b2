"""Observers that go sample by sample, beside saturated sensors."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from obs_ros import Model, Sample, Variable
from obs_ros.core.typing import Array
from obs_ros.integration.path import Path
from obs_ros.integration.stepper import stepper_for
from obs_ros.models import MODELS, load_model
from obs_ros.observers.base import OBSERVERS, load_observer
from obs_ros.observers.innovation_gate import expected_outputs
from obs_ros.observers.saturated_outputs import SaturatedOutputs

TANK = Model(
    name='leaking_tank',
    states=(Variable('level', 'V', lower=0.0, upper=30.0),),
    inputs=(Variable('inflow', 'V/s'),),
    outputs=(Variable('y', 'V', range=(0.0, 10.0)),),
    parameters=(Variable('leak', '1/s', lower=0.01, upper=2.0, nominal=0.3),),
    dynamics=lambda t, x, u, p: (u[0] - p[0] * x[0],),
    output=lambda t, x, u, p: (x[0],),
    max_step=0.1,
)
BLIND = replace(TANK, outputs=(replace(TANK.outputs[0], range=None),))
PERIOD = 0.1  # s


def told(level: float, shown: float, **settings: Any) -> float:
    """What is left of an output after 1 s without inflow."""
    saturated = SaturatedOutputs(TANK, **settings)
    path = Path(1, np.array([0.0, 1.0]), np.ones(1), np.array([20]), np.zeros((2, 1)),
                np.zeros((2, 1)))  # fmt: skip
    y, x, p = np.array([shown]), np.array([level]), np.array([0.3])
    stepper = stepper_for(TANK, 'numpy')
    return float(
        saturated.told(y, lambda: expected_outputs(stepper, path, 1.0, np.zeros(1), x, p))[0]
    )


def test_a_saturated_sensor_says_something_where_the_model_is_inside_only() -> None:
    assert told(12.0, 10.0) == 10.0  # the model falls to 8.9
    assert np.isnan(told(14.0, 10.0))  # to 10.4
    assert told(14.0, 9.0) == 9.0 and told(12.0, 10.0 + 1e-8) == 10.0


def test_the_model_stands_in_for_a_silent_sensor_where_that_is_wanted() -> None:
    assert told(14.0, 10.0, stand_in=True) == pytest.approx(14.0 * np.exp(-0.3), rel=1e-6)
    assert told(12.0, 10.0, stand_in=True) == 10.0


def filled(rows: int = 600) -> tuple[Array, Array]:
    """Inflows that take the level beyond the sensor's range half of the time, and the levels."""
    u = np.where(np.arange(rows) // 75 % 2, 1.0, 5.0)
    x = np.empty(rows)
    x[0] = 3.0
    for k in range(rows - 1):
        rest = u[k] / 0.3
        x[k + 1] = rest + (x[k] - rest) * np.exp(-0.3 * PERIOD)
    return u, x


def errors(name: str, model: Model, noise: float = 0.05) -> tuple[float, Any]:
    """Root mean square error of the level in the second half, and the observer."""
    u, x = filled()
    rng = np.random.default_rng(0)
    y = np.clip(x + noise * rng.standard_normal(x.size), 0.0, 10.0)
    observer = load_observer(name)(model, noise={'y': noise}, parameters=(), backend='numpy')
    found = []
    for k in range(x.size):
        observer.absorb(Sample(round(k * PERIOD * 1e9), u=u[k : k + 1], y=y[k : k + 1]))
        estimate = observer.estimate()
        found.append(estimate.state['level'])
        if model is TANK:
            assert estimate.outcome == 'converged', estimate.message
    return float(np.sqrt(np.mean((np.array(found) - x)[300:] ** 2))), observer


@pytest.mark.parametrize('name', ['ekf', 'ukf'])
def test_kalman_filters_go_on_beyond_the_range(name: str) -> None:
    """Told of the range, they follow to within 0.15 V; not told, it seems stuck to them."""
    aware, observer = errors(name, TANK)
    naive, other = errors(name, BLIND)
    assert aware < 0.15 and np.isnan(naive)
    _, x = filled()
    assert observer.counts['saturated.y'] == pytest.approx((x >= 10.0).sum(), abs=15)
    assert observer.counts['stuck'] == 0 < other.counts['stuck']
    assert 'saturated.y' not in other.counts


def test_a_filter_that_is_too_low_is_corrected_by_the_end_of_the_range() -> None:
    observer = load_observer('ekf')(TANK, noise={'y': 0.05}, parameters=(), initial={'level': 2.0})
    for k in range(40):
        y, u = np.array([10.0]), np.array([6.0])
        observer.absorb(Sample(round(k * PERIOD * 1e9), u=u, y=y))
    estimate = observer.estimate()
    assert estimate.state['level'] > 9.9
    assert np.isnan(estimate.innovation['y']) or estimate.innovation['y'] >= 0.0


def suited() -> list[tuple[str, str]]:
    """Each immediate observer with the first model that suits it."""
    pairs = {}
    for name in OBSERVERS:
        observer: Any = load_observer(name)
        for model in MODELS if observer.immediate else ():
            try:
                getattr(observer, 'suits', lambda model: None)(load_model(model))
            except ValueError:
                continue
            pairs.setdefault(name, model)
    return list(pairs.items())


@pytest.mark.parametrize(('name', 'plant'), suited())
def test_every_observer_goes_on_beside_saturated_sensors(name: str, plant: str) -> None:
    """All outputs at the ends of their ranges for a while, from there on and back again."""
    model = load_model(plant)
    start: Any = load_observer(name)(model, backend='numpy')
    x, p = np.split(start.initial, [len(model.states)])
    u = np.array([v.nominal or 0.0 for v in model.inputs])
    y = np.array(model.output(0.0, tuple(x), tuple(u), tuple(p)))
    y = np.where(np.isfinite(y), y, 0.0)
    high = y + 0.05 * (np.abs(y) + 0.1)
    outputs = [
        replace(v, range=(-np.inf, float(end))) for v, end in zip(model.outputs, high, strict=True)
    ]
    observer: Any = load_observer(name)(replace(model, outputs=outputs), backend='numpy')
    period = min(model.max_step, 0.05)
    for k in range(30):
        shown = high if 10 <= k < 20 else y
        observer.absorb(Sample(round(k * period * 1e9), u=u, y=shown))
        estimate = observer.estimate()
        assert estimate is not None and estimate.usable, (k, estimate)
    saturated = {f'saturated.{v.name}': 10 for v in model.outputs}
    assert saturated.items() <= observer.counts.items()
