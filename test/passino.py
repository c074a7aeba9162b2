"""The plants of the genetic observers' papers, played and followed sample by sample."""

from typing import Any

import numpy as np

from obs_ros import Sample
from plant_sim.scenarios import load_scenario
from plant_sim.simulation import Instant, Simulation

PERIOD = 10_000_000  # ns


def played(scenario: str, samples: int) -> list[Instant]:
    simulation = Simulation(load_scenario(scenario))
    return [simulation.sample() for _ in range(samples)]


def follow(observer: Any, instants: list[Instant]) -> Any:
    """Estimates at every sample."""
    found = []
    for k, instant in enumerate(instants):
        assert observer.absorb(Sample(k * PERIOD, y=np.array(instant.y), u=np.array(instant.u)))
        found.append(observer.estimate())
    return found
