"""Tests of obs_ros.horizon.found_jumps."""

import numpy as np
import pytest

from obs_ros.horizon.announcements import AnnouncementSettings
from obs_ros.horizon.found_jumps import Size, together
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.models import load_model

UNKNOWNS = Unknowns.of(load_model('heat_exchanger_reduced'))
TP, DP1 = 0, 4  # places
CLEAR = AnnouncementSettings().clear


def test_on_a_log_scale_a_ratio_may_be_sure_though_both_values_are_not() -> None:
    """dP1 falls by a tenth of its box, to within a twentieth, from anywhere."""
    ends, common, own = np.array([0.6, 0.5]), 0.3**2, 0.02**2
    covariance = np.full((2, 2), common) + own * np.eye(2)
    found = Size.of(UNKNOWNS, DP1, ends, covariance)
    assert found.clear(CLEAR)
    values = 1e5 * 10.0**ends
    assert found.value == pytest.approx(values[1] - values[0])
    slopes = np.log(10.0) * values * [-1.0, 1.0]
    expected = np.sqrt(common * slopes.sum() ** 2 + own * (slopes**2).sum())
    assert found.stddev == pytest.approx(expected)
    assert abs(found.value) < 2.0 * found.stddev
    assert not Size.of(UNKNOWNS, DP1, ends, covariance + 0.08**2 * np.eye(2)).clear(CLEAR)


def test_on_a_linear_scale_it_is_the_difference() -> None:
    for spread, clear in ((0.049, True), (0.051, False)):
        found = Size.of(UNKNOWNS, TP, np.array([0.3, 0.4]), np.diag([0.0, spread**2]))
        assert found.clear(CLEAR) == clear
        assert found.value == pytest.approx(10.0)
        assert found.stddev == pytest.approx(100.0 * spread)


def test_words_do_not_depend_on_the_order() -> None:
    assert together({'k1', 'dP1'}) == together(['dP1', 'k1']) == 'dP1 and k1'
