"""The built-in scenarios, by name."""

from obs_ros.core.registry import lookup
from plant_sim.scenario import Scenario

SCENARIOS = {
    'glycolytic_oscillator': 'plant_sim.scenarios.glycolytic_oscillator:BASE',
    'glycolytic_oscillator_chaotic': 'plant_sim.scenarios.glycolytic_oscillator:CHAOTIC',
    'glycolytic_oscillator_disturbed': 'plant_sim.scenarios.glycolytic_oscillator:DISTURBED',
    'glycolytic_oscillator_gaussian': 'plant_sim.scenarios.glycolytic_oscillator:GAUSSIAN',
    'glycolytic_oscillator_mismatch': 'plant_sim.scenarios.glycolytic_oscillator:MISMATCH',
    'heat_exchanger_case1': 'plant_sim.scenarios.heat_exchanger:CONSTANT_FLOWS',
    'heat_exchanger_case2': 'plant_sim.scenarios.heat_exchanger:VALVE_FAULTS',
    'heat_exchanger_case3': 'plant_sim.scenarios.heat_exchanger:MOVING_VALVES',
    'jet_engine_case1': 'plant_sim.scenarios.jet_engine:CASE_1',
    'jet_engine_case2': 'plant_sim.scenarios.jet_engine:CASE_2',
    'linear_second_order': 'plant_sim.scenarios.linear_second_order:TWO_COSINES',
    'observer_form_third_order': 'plant_sim.scenarios.observer_form_third_order:MINIMUM_PHASE',
    'observer_form_third_order_nmp': (
        'plant_sim.scenarios.observer_form_third_order:NON_MINIMUM_PHASE'
    ),
    'suspension_cos': 'plant_sim.scenarios.suspension:COSINES',
    'suspension_kt_step': 'plant_sim.scenarios.suspension:SOFT_TYRE',
    'suspension_rect': 'plant_sim.scenarios.suspension:RECTANGLES',
    'suspension_trap': 'plant_sim.scenarios.suspension:TRAPEZOIDS',
    'three_tank': 'plant_sim.scenarios.three_tank:THREE_TANK_FAULTS',
}


def load_scenario(name: str) -> Scenario:
    """Return the scenario of that name, or at that `module:ATTRIBUTE`.

    Raises ValueError when there is none, or what stands there is not a Scenario.
    """
    found = lookup('scenario', name, SCENARIOS)
    if not isinstance(found, Scenario):
        raise ValueError(
            f'scenario {name!r} is a {type(found).__name__}, not a plant_sim.scenario.Scenario'
        )
    return found
