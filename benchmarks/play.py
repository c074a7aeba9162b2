"""Scenarios of the simulator played offline, and observers that watch them."""

import time
from collections.abc import Iterator, Mapping, Sequence
from itertools import islice
from typing import Any, NamedTuple

import numpy as np

from obs_ros import Estimate, Sample
from obs_ros.core.typing import Array
from plant_sim.scenario import Scenario
from plant_sim.scenarios import load_scenario
from plant_sim.simulation import Instant, Simulation


class Contestant(NamedTuple):
    """An observer by name, with its settings; `seeded` if it draws random numbers."""

    label: str
    observer: str
    settings: Mapping[str, Any] = {}
    seeded: bool = False


def instants(
    scenario: str | Scenario, faults: Mapping[str, float] = {}, **options: Any
) -> Iterator[Instant]:
    """Yield the instants of a scenario without end; the options are those of `Simulation`.

    `faults` are values of parameters that replace the scheduled ones.
    """
    known = load_scenario(scenario) if isinstance(scenario, str) else scenario
    simulation = Simulation(known, **options)
    simulation.faults = dict(faults)
    while True:
        yield simulation.sample()


def played(scenario: str | Scenario, count: int, **options: Any) -> list[Instant]:
    """Return the first instants of a scenario."""
    return list(islice(instants(scenario, **options), count))


def columns(instants: Sequence[Instant], names: str) -> list[Array]:
    """Return parts of all instants, each (K, ...): `tuyx` are times, inputs, outputs, states."""
    return [np.array([getattr(instant, name) for instant in instants]) for name in names]


def samples_of(instants: Sequence[Instant]) -> list[Sample]:
    """Return the instants as an observer gets them, inputs and outputs together."""
    return [Sample(round(i.t * 1e9), y=np.array(i.y), u=np.array(i.u)) for i in instants]


def followed(observer: Any, samples: Sequence[Sample]) -> tuple[list[Estimate], Array]:
    """Return the estimates, and process times (K, 2) in s: to absorb a sample, to fetch too."""
    observer.prepare()
    estimates, times = [], np.empty((len(samples), 2))
    for k, sample in enumerate(samples):
        begin = time.process_time()
        observer.absorb(sample)
        absorbed = time.process_time()
        estimates.append(observer.estimate())
        times[k] = absorbed - begin, time.process_time() - begin
    return estimates, times
