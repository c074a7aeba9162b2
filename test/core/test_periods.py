"""Tests of obs_ros.core.periods."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from obs_ros import Model, Variable
from obs_ros.core.periods import (
    continuous,
    has_period,
    lasting_bounds,
    nearest,
    periods,
    shortest,
    shortest_way,
    together,
    within,
)

TURN = 2.0 * np.pi
ANGLES = st.floats(-1e6, 1e6)
PERIODS = st.sampled_from([TURN, 360.0, 1.0, 0.3])


def test_variables_have_their_period_or_none() -> None:
    variables = (Variable('yaw', period=TURN), Variable('speed'), Variable('heading', period=360))
    np.testing.assert_array_equal(periods(variables), [TURN, 0.0, 360.0])


def test_bounds_of_a_periodic_variable_hold_at_first_only() -> None:
    assert lasting_bounds(Variable('speed', lower=-1, upper=2)) == (-1.0, 2.0)
    assert lasting_bounds(Variable('yaw', lower=-1, upper=2, period=TURN)) == (-math.inf, math.inf)


@given(ANGLES, PERIODS)
def test_a_difference_goes_the_shortest_way(difference: float, period: float) -> None:
    found = float(shortest(np.array([difference]), np.array([period]))[0])
    assert abs(found) <= 0.5 * period * (1.0 + 1e-9)
    assert math.cos(TURN * (found - difference) / period) == pytest.approx(1.0)
    assert shortest_way(difference, period) == pytest.approx(found, abs=1e-9)


@given(ANGLES, PERIODS)
def test_what_is_published_lies_in_one_period_that_is_open_above(
    value: float, period: float
) -> None:
    found = float(within(np.array([value]), np.array([period]))[0])
    assert -0.5 * period <= found < 0.5 * period
    assert found == float(within(np.array([found]), np.array([period]))[0])


@pytest.mark.parametrize(
    ('value', 'expected'),
    [
        (np.pi, -np.pi),
        (-np.pi, -np.pi),
        (math.nextafter(np.pi, 0.0), math.nextafter(np.pi, 0.0)),
        (math.nextafter(-np.pi, -4.0), np.pi),
        (3.0 + TURN, 3.0),
        (-0.0, 0.0),
    ],
)
def test_the_ends_of_the_period(value: float, expected: float) -> None:
    (found,) = within(np.array([value]), np.array([TURN]))
    assert -np.pi <= found < np.pi
    assert found == pytest.approx(expected, abs=2e-15)


def test_what_has_no_period_passes_bit_by_bit() -> None:
    values, none = np.array([1e9, np.nan, -np.inf]), np.zeros(3)
    assert shortest(values, none) is values
    assert within(values, none) is values and nearest(values, values, none) is values
    np.testing.assert_array_equal(
        continuous(np.arange(3.0), values[:, None], none[:1]), values[:, None]
    )
    mixed = within(np.array([[4.0, 4.0]]), np.array([TURN, 0.0]))
    np.testing.assert_allclose(mixed, [[4.0 - TURN, 4.0]])


def test_values_come_nearest_to_others_and_nan_stays() -> None:
    values, to = np.array([3.0, np.nan, 1.0, -9.0]), np.array([-3.0, 0.0, np.nan, 90.0])
    found = nearest(values, to, np.full(4, TURN))
    np.testing.assert_allclose(found[[0, 2]], [3.0 - TURN, 1.0])
    assert np.isnan(found[1]) and abs(found[3] - 90.0) <= np.pi


@pytest.mark.parametrize('rate', [0.0, 3.0, -40.0])
def test_many_turns_become_one_line(rate: float) -> None:
    """With gaps, from any turn on: steps stay below half a period."""
    rng = np.random.default_rng(1)
    true = 0.4 + 0.05 * rate * np.arange(200) + 0.1 * rng.standard_normal(200)
    y = np.c_[within(true[:, None], np.array([TURN]))[:, 0], true]
    y[rng.random(200) < (0.2 if abs(rate) < 10.0 else 0.0), 0] = np.nan
    found = continuous(0.05 * np.arange(200), y, np.array([TURN, 0.0]))
    known = np.isfinite(y[:, 0])
    np.testing.assert_allclose(found[known, 0], true[known], atol=1e-12)
    np.testing.assert_array_equal(found[:, 1], true)
    np.testing.assert_array_equal(np.isnan(found[:, 0]), ~known)


def test_an_angle_that_hovers_at_half_a_turn_is_one_line() -> None:
    true = np.pi + 0.3 * np.random.default_rng(2).standard_normal((500, 1))
    period = np.array([TURN])
    found = continuous(np.arange(500.0), within(true, period), period)
    assert np.ptp(found) == pytest.approx(np.ptp(true)) and np.ptp(found) < 2.5


@pytest.mark.parametrize('size', [2.0, 3.0, 3.14, -3.1])
@pytest.mark.parametrize('length', [1, 2])
def test_outliers_of_half_a_turn_lead_no_other_value_astray(size: float, length: int) -> None:
    t = 0.05 * np.arange(200)
    true = 3.0 * t + np.sin(t)
    y = true + 0.02 * np.random.default_rng(3).standard_normal(200)
    off = np.zeros(200, dtype=bool)
    for first in (0, 40, 90, 198):
        off[first : first + length] = True
    y[off] += size
    period = np.array([TURN])
    found = continuous(t, within(y[:, None], period), period)[:, 0]
    turns = (found - true)[~off]
    np.testing.assert_allclose(turns, turns[0] * np.ones(turns.size), atol=0.2)


def test_in_a_gap_an_angle_turns_on_at_its_pace() -> None:
    t = np.delete(0.05 * np.arange(100), slice(40, 70))
    true = 20.0 * t
    period = np.array([TURN])
    found = continuous(t, within(true[:, None], period), period)[:, 0]
    np.testing.assert_allclose(np.diff(found), np.diff(true), atol=1e-9)


def test_a_column_without_values_stays() -> None:
    assert np.isnan(continuous(np.arange(4.0), np.full((4, 1), np.nan), np.array([TURN]))).all()


def test_quantiles_about_half_a_turn_mean_something() -> None:
    values = np.array([3.1, -3.1, 3.0, np.nan, -3.0])
    found = together(values, TURN)
    assert np.nanmedian(found) % TURN == pytest.approx(np.pi, abs=0.05)
    assert np.nanmax(found) - np.nanmin(found) == pytest.approx(TURN - 6.0)
    assert together(values, 0.0) is values


@pytest.mark.parametrize(('gain', 'expected'), [(1.0, True), (2.0, True), (0.5, False)])
def test_a_model_has_a_period_or_not(gain: float, expected: bool) -> None:
    """A pendulum, seen directly, geared up and geared down."""
    model = Model(
        'pendulum', states=(Variable('angle', 'rad', -4.0, 4.0), Variable('rate')),
        outputs=(Variable('sensor', 'rad', period=TURN),),
        dynamics=lambda t, x, u, p: (x[1], -9.81 * np.sin(x[0])),
        output=lambda t, x, u, p: (gain * x[0],),
    )  # fmt: skip
    assert has_period(model, 0, TURN) is expected
    assert not has_period(model, 0, 1.0) and not has_period(model, 1, TURN)


def test_the_next_state_of_a_discrete_model_is_as_many_periods_on() -> None:
    def wheel(gain: float) -> Model:
        return Model(
            'wheel', states=(Variable('angle', period=TURN), Variable('speed', lower=0, upper=1)),
            outputs=(Variable('angle', period=TURN),), output=lambda t, x, u, p: (x[0],),
            dynamics=lambda t, x, u, p: (gain * x[0] + x[1], x[1]), kind='discrete', period=0.1,
        )  # fmt: skip

    assert has_period(wheel(1.0), 0, TURN)
    assert not has_period(wheel(0.9), 0, TURN)
