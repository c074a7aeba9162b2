"""The built-in scenarios, by name."""

from obs_ros.registry import lookup
from plant_sim.scenario import Scenario

SCENARIOS = {
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
