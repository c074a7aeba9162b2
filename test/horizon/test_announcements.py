"""Tests of obs_ros.horizon.announcements."""

import math
from dataclasses import replace

import numpy as np
import pytest
from exchanger import AT_REST

from obs_ros import Estimate, Sample
from obs_ros.horizon.found_jumps import together
from obs_ros.observers.sliding_window import SlidingWindowObserver
from plant_sim.scenarios import load_scenario
from plant_sim.scenarios.heat_exchanger import NOMINAL
from plant_sim.signals import Schedule
from plant_sim.simulation import Simulation

SIGMA, PERIOD = 0.05, 0.05  # K, s
FAULT, END = 16.0, 22.0  # s


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
    """With these noises windows after the first call it dP1, k1 and dP1 again.

    Later windows may correct it, once the odds are clear: what is taken back is announced anew.
    """
    shown = [
        jump for one in valve_fault(seed) for jump in one.jumps if abs(jump.time - FAULT) < 1.0
    ]
    assert {together(jump.sizes) for jump in shown} >= {'dP1', 'k1'}
    assert sum(jump.new for jump in shown if not jump.retracted) - 1 == sum(
        jump.retracted for jump in shown
    )
    inside = [jump for jump in shown if jump.time > FAULT - 0.5 and not jump.retracted]
    assert all(0.0 < jump.probability <= 1.0 for jump in inside)
