import numpy as np
import pytest

from plant_sim.scenarios.jet_engine import CASE_1, CASE_2
from plant_sim.simulation import Simulation


def states(scenario):
    simulation = Simulation(scenario)
    return np.array([simulation.sample().x for _ in range(2501)]).T


def test_case_1_runs_clean_and_then_stalls_for_good():
    _, r, phi = states(CASE_1)
    assert r[100:401].max() < 0.01 and phi[:401].min() > 0.5
    assert r[600:].min() > 0.85 and np.abs(phi[600:]).max() < 0.35


def test_case_2_stalls_at_once_and_ends_with_reversed_flow():
    _, r, phi = states(CASE_2)
    assert r[200:400].max() > 0.9
    assert r[600:].max() < 0.01 and phi[700:].max() < -1.6


@pytest.mark.parametrize('scenario', [CASE_1, CASE_2], ids=['case 1', 'case 2'])
def test_the_pressure_follows_its_reference_through_stall(scenario):
    psi, _, _ = states(scenario)
    reference = [scenario.inputs.reference(0.01 * k)[0] for k in range(1000, 2501)]
    assert np.abs(psi[1000:] - reference).max() < 0.1
