"""Steps of sensors that round, learned from their values."""

import math

import numpy as np
import pytest

from obs_ros import Variable
from obs_ros.core.typing import Array
from obs_ros.samples.resolution import (
    DEFAULT,
    Resolutions,
    noise_beside,
    repeats_by_chance,
    step_of,
)

rng = np.random.default_rng(3)
CELSIUS = rng.uniform(20.0, 60.0, 400)
FAHRENHEIT = np.round(CELSIUS * 9.0 / 5.0 + 32.0)


@pytest.mark.parametrize(
    ('values', 'step'),
    [
        (np.round(CELSIUS), 1.0),
        (np.array([0.1 * k for k in range(20)] + [0.1 + 0.2, 0.7 + 0.1]), 0.1),
        (np.round(CELSIUS, 1).astype(np.float32).astype(float), 0.1),
        (np.round(CELSIUS / 60.0 * 255.0) * 5.0 / 255.0, 5.0 / 255.0),
        ((FAHRENHEIT - 32.0) * 5.0 / 9.0, 5.0 / 9.0),
        (np.round((FAHRENHEIT - 32.0) * 5.0 / 9.0, 2), 5.0 / 9.0),
        (np.round((FAHRENHEIT - 32.0) * 5.0 / 9.0, 1), 5.0 / 9.0),
        (273.15 + np.round(CELSIUS), 1.0),
        (-1e-6 * np.arange(30) ** 2, 1e-6),
    ],
    ids=['degC', 'tenths', 'float32', '8 bits', 'degF', 'degF, 0.01', 'degF, 0.1', 'K', 'squares'],
)
def test_a_step_is_found_through_conversions_and_floats(values: Array, step: float) -> None:
    assert step_of(values) == pytest.approx(step, rel=2e-3)


@pytest.mark.parametrize(
    'values',
    [
        np.array([]), np.zeros(50), np.tile([0.0, 1.0], 50), np.tile([0.0, 0.25, 0.5, 1.0], 50),
        np.arange(DEFAULT.distinct - 1.0), CELSIUS, np.sort(CELSIUS)[:40], np.geomspace(1, 2, 20),
    ],
    ids=['none', 'one', 'binary', 'four', 'few', 'random', 'some random', 'geometric'],
)  # fmt: skip
def test_no_step_is_seen_in_few_values_or_in_random_ones(values: Array) -> None:
    assert step_of(values) is None


def test_values_whose_differences_overflow_have_no_step() -> None:
    with np.errstate(over='ignore'):
        assert step_of(1.7e308 * np.linspace(-1.0, 1.0, 4 * DEFAULT.distinct)) is None


def test_random_values_hardly_ever_lie_on_a_grid() -> None:
    """Twelve of them, the least number that is looked at: 0.1 % at most."""
    found = [step_of(rng.standard_normal(DEFAULT.distinct)) for _ in range(5000)]
    assert sum(step is not None for step in found) <= 5


def learned(y: Array, **declared: float) -> Resolutions:
    resolutions = Resolutions([Variable(f'y{i}', **declared) for i in range(y.shape[1])])
    resolutions.note(y)
    resolutions.learn()
    return resolutions


def test_steps_are_learned_of_each_output_and_shown_by_name() -> None:
    y = np.column_stack([np.round(CELSIUS), CELSIUS, np.round(CELSIUS) > 40.0])
    y[::7] = math.nan
    assert learned(y).learned == {'y0': 1.0}
    assert learned(y).figures == {'resolution.y0': 1.0}


def test_a_held_signal_of_random_values_is_no_grid() -> None:
    """As of a slow sensor that a fast one is polled with: each value stands five times."""
    assert learned(np.repeat(CELSIUS[:60], 5)[:, None]).learned == {}


def test_it_is_learned_from_several_windows_and_given_up_where_values_are_very_many() -> None:
    resolutions = Resolutions([Variable('y')])
    for part in np.split(np.round(np.sort(CELSIUS)), 40):
        resolutions.note(part[:, None])
    resolutions.learn()
    assert resolutions.learned == {'y': 1.0}
    resolutions.note(rng.standard_normal((2 * DEFAULT.most, 1)))
    resolutions.learn()
    assert resolutions.learned == {}


def test_samples_one_by_one_are_learned_from_too() -> None:
    resolutions = Resolutions([Variable('y')])
    for value in np.round(CELSIUS):
        resolutions.note(np.array([value]))
    assert resolutions.learned == {'y': 1.0}


@pytest.mark.parametrize('noise', [0.3, 1.0, 3.0])
def test_noise_is_told_from_rounding(noise: float) -> None:
    values = np.round(20.0 * np.sin(np.arange(4000) / 50.0) + noise * rng.standard_normal(4000))
    found = noise_beside(1.0, values)
    assert found == pytest.approx(noise, rel=0.35) if noise > 0.5 else found < 0.5


def test_noise_repeats_values_as_often_as_the_step_is_coarse() -> None:
    for noise, repeats in ((0.3, 137.0), (1.0, 14.4), (3.0, 6.8)):
        assert repeats_by_chance(1.0, noise) == pytest.approx(repeats, rel=0.02)
    assert repeats_by_chance(1.0, 0.0) == math.inf == repeats_by_chance(1.0, 0.05)


def test_a_declared_step_repeats_for_ever_unless_the_noise_given_is_larger() -> None:
    resolutions = Resolutions([Variable('y', resolution=1.0)])
    nothing = np.array([])
    assert resolutions.natural_repeats(0, nothing, math.nan) == math.inf
    with_rounding = math.hypot(1.0, 1.0 / math.sqrt(12.0))
    assert resolutions.natural_repeats(0, nothing, with_rounding) == pytest.approx(14.4, rel=0.02)
    assert Resolutions([Variable('y')]).natural_repeats(0, nothing, 1.0) == 0.0


def test_noise_beside_a_learned_step_holds_for_windows_with_few_values() -> None:
    values = np.round(40.0 + 2.0 * rng.standard_normal(400))
    resolutions = learned(values[:, None])
    assert resolutions.natural_repeats(0, values[:5], math.nan) == math.inf
    known = resolutions.natural_repeats(0, values, math.nan)
    assert known < 12.0 and resolutions.natural_repeats(0, values[:5], math.nan) == known
