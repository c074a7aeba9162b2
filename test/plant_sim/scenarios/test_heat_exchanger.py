import math

import numpy as np
import pytest

from obs_ros.models import heat_exchanger as plant
from plant_sim.scenarios.heat_exchanger import CONSTANT_FLOWS, MOVING_VALVES, VALVE_FAULTS
from plant_sim.simulation import Simulation


def flows(instant):
    """Fp and Fu (m3/s)."""
    dp1, dp2, _, _ = instant.p
    return plant.flow2(dp2, instant.x[4]), plant.flow1(dp1, instant.x[2])


def test_the_valves_start_at_rest_with_the_papers_flows():
    simulation = Simulation(CONSTANT_FLOWS, snr_db=math.inf)
    instants = [simulation.sample() for _ in range(501)]
    assert instants[0].y == (80.0, 20.0)
    assert flows(instants[0]) == flows(instants[-1]) == pytest.approx((4.17e-6, 4.22e-5), rel=1e-6)
    # Above its inlet of 76 degC at first, Tp passes it at 0.04 s: there Fp cannot be seen.
    passing = next(i.t for i in instants if i.x[0] < plant.TPI)
    assert passing == pytest.approx(0.04, abs=0.005)


def test_noise_is_that_of_the_specification():
    simulation = Simulation(CONSTANT_FLOWS, seed=1, period=0.02)
    noise = np.array([np.subtract(i.y, i.x[:2]) for i in (simulation.sample() for _ in range(400))])
    # 80 time constants: 5 standard errors of a deviation are 40 %, of a correlation 0.3.
    assert noise.std(axis=0) == pytest.approx(0.05, rel=0.4)
    lag = (noise[1:] * noise[:-1]).sum(axis=0) / (noise**2).sum(axis=0)
    assert lag == pytest.approx(math.exp(-0.2), abs=0.3)


def test_the_faults_change_one_flow_each():
    before, clogged, worn = (VALVE_FAULTS.parameters(t) for t in (79.999, 80.0, 150.0))
    assert plant.flow1(before[0], 1.0) / plant.flow1(clogged[0], 1.0) - 1.0 == pytest.approx(
        0.2247, abs=1e-4
    )
    assert worn[3] / before[3] - 1.0 == pytest.approx(0.1642, abs=1e-4)
    assert clogged[1:] == before[1:] and worn[:3] == clogged[:3]


def test_moving_pressures_move_the_flows_against_each_other():
    simulation = Simulation(MOVING_VALVES, period=0.5, snr_db=math.inf)
    instants = [simulation.sample() for _ in range(20)]
    assert flows(instants[10]) == pytest.approx(flows(instants[0]), rel=1e-6)
    ratios = np.divide(flows(instants[-1]), flows(instants[0]))
    assert ratios == pytest.approx([0.8, 1.2], abs=1e-5)
