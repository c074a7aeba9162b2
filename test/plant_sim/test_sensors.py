"""Sensors that are none of the best."""

import math

import numpy as np
import pytest

from obs_ros import Variable
from plant_sim.sensors import PERFECT, Outliers, Sensor, clipped

INTERVAL = 0.1  # s


def outliers(*sensors: Sensor, count: int = 4000, seed: int = 1) -> np.ndarray:
    drawn = Outliers(seed, len(sensors))
    return np.array([drawn.draw(sensors, k * INTERVAL, INTERVAL) for k in range(count)])


def test_a_perfect_sensor_reads_what_is_measured() -> None:
    values = [0.0, -0.0, 1e-300, 12.3456789, math.pi, -1e100]
    assert [PERFECT.reading(v, 0.0, 1.0).hex() for v in values] == [v.hex() for v in values]
    assert not outliers(PERFECT).any()


def test_outliers_come_as_often_as_asked_with_sizes_and_signs_drawn() -> None:
    found = outliers(Sensor(outlier_rate=0.05, outlier_size=(5.0, 100.0)))
    hit = found[found != 0.0]
    # 5 standard errors of a share, of the mean of an even draw, and of a sign.
    assert hit.size / found.size == pytest.approx(0.05, abs=5 * math.sqrt(0.05 * 0.95 / 4000))
    assert np.abs(hit).min() >= 5.0 and np.abs(hit).max() <= 100.0
    error = 5 / math.sqrt(hit.size)
    assert np.abs(hit).mean() == pytest.approx(52.5, abs=error * 95 / math.sqrt(12))
    assert abs(np.sign(hit).mean()) < error


def test_outliers_of_a_period_come_on_time_and_not_at_the_start() -> None:
    found = outliers(Sensor(outlier_period=2.0), count=100)[:, 0]
    assert np.flatnonzero(found).tolist() == [20, 40, 60, 80]
    np.testing.assert_array_equal(np.abs(found[found != 0.0]), 10.0)


def test_a_burst_is_off_by_one_size_for_its_length() -> None:
    found = outliers(Sensor(outlier_period=2.0, outlier_length=5), count=60)[:, 0]
    assert np.flatnonzero(found).tolist() == [*range(20, 25), *range(40, 45)]
    assert len(set(found[20:25])) == len(set(found[40:45])) == 1


def test_a_burst_that_is_shortened_while_it_lasts_ends_sooner() -> None:
    long = Sensor(outlier_period=1.0, outlier_length=1000)
    drawn = Outliers(1, 1)
    found = [drawn.draw([long], k * INTERVAL, INTERVAL) for k in range(12)]
    off = Sensor(outlier_length=2)
    found += [drawn.draw([off], k * INTERVAL, INTERVAL) for k in range(12, 20)]
    assert np.flatnonzero(found).tolist() == [10, 11, 12, 13]


def test_the_seed_makes_the_outliers_whatever_other_sensors_do_and_since_when() -> None:
    bad, other = Sensor(outlier_rate=0.1), Sensor(outlier_rate=0.5, outlier_length=7)
    alone, beside = outliers(bad, PERFECT), outliers(bad, other)
    np.testing.assert_array_equal(alone[:, 0], beside[:, 0])
    np.testing.assert_array_equal(alone, outliers(bad, PERFECT))
    assert not np.array_equal(alone, outliers(bad, PERFECT, seed=2))
    drawn = Outliers(1, 2)
    late = [
        drawn.draw([bad if k >= 1000 else PERFECT, PERFECT], k * INTERVAL, INTERVAL)
        for k in range(4000)
    ]
    np.testing.assert_array_equal(late[1000:], alone[1000:])


def test_an_outlier_is_off_by_its_size_or_reads_its_value() -> None:
    assert Sensor().reading(1.0, -3.0, 0.5) == -0.5
    dropout = Sensor(outlier_value=0.0, range=(1.0, 2.0), resolution=0.3)
    assert dropout.reading(1.7, 10.0, 0.5) == 0.0
    assert dropout.reading(1.7, 0.0, 0.5) == pytest.approx(1.8)


@pytest.mark.parametrize(
    ('sensor', 'value', 'reading'),
    [
        (Sensor(range=(0.0, 10.0)), 11.0, 10.0),
        (Sensor(range=(0.0, 10.0)), -1.0, 0.0),
        (Sensor(range=(0.0, 10.0)), 4.2, 4.2),
        (Sensor(resolution=0.25), 4.2, 4.25),
        (Sensor(resolution=0.25), -4.2, -4.25),
        (Sensor(period=360.0), 190.0, -170.0),
        (Sensor(period=360.0), 180.0, -180.0),
        (Sensor(period=360.0), -180.0, -180.0),
        (Sensor(period=360.0), -3700.0, -100.0),
        (Sensor(period=360.0, resolution=90.0), 200.0, -180.0),
        (Sensor(range=(0.0, 10.0), resolution=4.0), 11.0, 8.0),
    ],
)
def test_readings(sensor: Sensor, value: float, reading: float) -> None:
    assert sensor.reading(value, 0.0, 1.0) == pytest.approx(reading, abs=1e-12)


def test_wrapped_angles_lie_in_their_period() -> None:
    sensor, angles = Sensor(period=2.0 * math.pi), np.linspace(-50.0, 50.0, 4001)
    wrapped = np.array([sensor.reading(a, 0.0, 1.0) for a in [*angles, math.pi, -math.pi]])
    assert wrapped.min() >= -math.pi and wrapped.max() < math.pi
    np.testing.assert_allclose(np.cos(wrapped[:-2]), np.cos(angles), atol=1e-12)
    np.testing.assert_allclose(np.sin(wrapped[:-2]), np.sin(angles), atol=1e-12)


def test_a_sensor_is_as_its_output_declares() -> None:
    assert Sensor.of(Variable('y')) == PERFECT
    declared = Variable('y', period=6.0, range=(-2.0, 2.0), resolution=0.5, delay=-0.1)
    assert Sensor.of(declared) == Sensor(delay=-0.1, range=(-2.0, 2.0), resolution=0.5, period=6.0)
    assert Sensor.of(Variable('y', delay=(0.0, 1.0))) == PERFECT
    half = Sensor.of(Variable('y', range=(0.0, math.inf))).range
    assert [clipped(value, half) for value in (-1.0, 0.0, 1e99)] == [0.0, 0.0, 1e99]
