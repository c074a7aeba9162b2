"""Tests of obs_ros.horizon.announcements."""

import math
from dataclasses import replace

import numpy as np
import pytest
from exchanger import AT_REST

from obs_ros import Estimate, Sample
from obs_ros.horizon.announcements import AnnouncementSettings, Size, together
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.models import load_model
from obs_ros.observers.sliding_window import SlidingWindowObserver
from plant_sim.scenarios import load_scenario
from plant_sim.scenarios.heat_exchanger import NOMINAL
from plant_sim.signals import Schedule
from plant_sim.simulation import Simulation

UNKNOWNS = Unknowns.of(load_model('heat_exchanger_reduced'))
TP, DP1 = 0, 4  # places
CLEAR = AnnouncementSettings().clear
SIGMA, PERIOD = 0.05, 0.05  # K, s
FAULT, END = 16.0, 22.0  # s


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


def valve_fault(seed: int) -> list[Estimate]:
    """Windows of 4 s, every 0.5 s, of a run in which dP1 falls at 16 s."""
    after = (NOMINAL[0] - 2e5, *NOMINAL[1:])
    scenario = replace(
        load_scenario('heat_exchanger_case1'),
        initial_state=AT_REST,
        parameters=Schedule((0.0, FAULT), (NOMINAL, after)),
        noise_correlation=0.1,
    )
    simulation = Simulation(scenario, period=PERIOD, seed=seed, snr_db=-20.0 * math.log10(SIGMA))
    observer = SlidingWindowObserver(
        'heat_exchanger_reduced', duration=4.0, period=0.5, noise={'Tp': SIGMA, 'Tu': SIGMA},
        process_noise='off',  # which takes correlated noise for walks, and hides the jump there
    )  # fmt: skip
    found = []
    for _ in range(round(END / PERIOD) + 1):
        instant = simulation.sample()
        sample = Sample(round(instant.t * 1e9), y=np.array(instant.y), u=np.array(instant.u))
        if observer.absorb(sample) and (estimate := observer.estimate()):
            found.append(estimate)
    return found


@pytest.mark.parametrize('seed', [102, pytest.param(106, marks=pytest.mark.slow)])
def test_one_jump_is_announced_once_whichever_of_two_names_it_has(seed: int) -> None:
    """With these noises windows after the first call it dP1, k1 and dP1 again."""
    shown = [
        jump for one in valve_fault(seed) for jump in one.jumps if abs(jump.time - FAULT) < 1.0
    ]
    assert {together(jump.sizes) for jump in shown} >= {'dP1', 'k1'}
    assert sum(jump.new for jump in shown) == 1


def test_words_do_not_depend_on_the_order() -> None:
    assert together({'k1', 'dP1'}) == together(['dP1', 'k1']) == 'dP1 and k1'
