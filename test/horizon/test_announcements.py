"""Tests of obs_ros.horizon.announcements."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.valve_windows import STEADY, estimates, sampled
from obs_ros.horizon.announcements import Sizes, together
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.models import load_model
from plant_sim.scenarios import load_scenario
from plant_sim.scenarios.heat_exchanger import NOMINAL
from plant_sim.signals import Schedule

UNKNOWNS = Unknowns.of(load_model('heat_exchanger_reduced'))
TP, DP1 = 0, 4  # places


def test_on_a_log_scale_a_ratio_may_be_sure_though_both_values_are_not() -> None:
    """dP1 falls by a tenth of its box, to within a twentieth, from anywhere."""
    ends, common, own = np.array([0.6, 0.5]), 0.3**2, 0.02**2
    covariance = np.full((2, 2), common) + own * np.eye(2)
    found = Sizes(3.0, 0.1)
    found.add(UNKNOWNS, DP1, ends, covariance)
    assert found.clear
    values = 1e5 * 10.0**ends
    assert found.sizes == {'dP1': pytest.approx(values[1] - values[0])}
    slopes = np.log(10.0) * values * [-1.0, 1.0]
    expected = np.sqrt(common * slopes.sum() ** 2 + own * (slopes**2).sum())
    assert found.stddev == {'dP1': pytest.approx(expected)}
    assert abs(found.sizes['dP1']) < 2.0 * found.stddev['dP1']
    found = Sizes(3.0, 0.1)
    found.add(UNKNOWNS, DP1, ends, covariance + 0.08**2 * np.eye(2))
    assert not found.clear


def test_on_a_linear_scale_it_is_the_difference() -> None:
    for spread, clear in ((0.049, True), (0.051, False)):
        found = Sizes(3.0, 0.1)
        found.add(UNKNOWNS, TP, np.array([0.3, 0.4]), np.diag([0.0, spread**2]))
        assert found.clear == clear
        assert found.sizes['Tp'] == pytest.approx(10.0)
        assert found.stddev['Tp'] == pytest.approx(100.0 * spread)


@pytest.mark.parametrize('seed', [102, pytest.param(106, marks=pytest.mark.slow)])
def test_one_jump_is_announced_once_whichever_of_two_names_it_has(seed: int) -> None:
    """With these noises windows after the first call it dP1, k1 and dP1 again."""
    after = (NOMINAL[0] - 2e5, *NOMINAL[1:])
    scenario = replace(
        load_scenario('heat_exchanger_case1'),
        initial_state=STEADY,
        parameters=Schedule((0.0, 16.0), (NOMINAL, after)),
    )
    found = estimates(sampled(scenario, seed, 0.05, 0.1, 22.0), 0.05)
    shown = [jump for one in found for jump in one.jumps if abs(jump.time - 16.0) < 1.0]
    assert {together(jump.sizes) for jump in shown} >= {'dP1', 'k1'}
    assert sum(jump.new for jump in shown) == 1


def test_words_do_not_depend_on_the_order() -> None:
    assert together({'k1', 'dP1'}) == together(['dP1', 'k1']) == 'dP1 and k1'
