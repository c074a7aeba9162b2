import numpy as np
import pytest

from plant_sim.scenarios.observer_form_third_order import MINIMUM_PHASE, NON_MINIMUM_PHASE
from plant_sim.simulation import Simulation


@pytest.mark.parametrize(
    ('scenario', 'sums'),
    [(MINIMUM_PHASE, (269, 283)), (NON_MINIMUM_PHASE, (402, 388))],
)
def test_an_euler_model_with_mid_range_parameters_errs_by_what_was_found_elsewhere(scenario, sums):
    """Sums of squared errors of x2 and x3 over 100 s, from an independent simulation."""
    simulation = Simulation(scenario)
    model, x, error = simulation.model, np.zeros(3), np.zeros(3)
    p = [0.5 * (v.lower + v.upper) for v in model.parameters]
    instant = simulation.sample()
    for _ in range(10000):
        x = x + 0.01 * np.array(model.dynamics(instant.t, x, instant.u, p))
        instant = simulation.sample()
        error += (x - instant.x) ** 2
    assert error[1:] == pytest.approx(sums, abs=0.6)
