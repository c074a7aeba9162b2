"""Runs of the heat exchanger and the suspension, and what observers make of them."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from obs_ros import Sample
from obs_ros.core.typing import Array
from obs_ros.models import heat_exchanger as plant
from plant_sim.scenarios import load_scenario
from plant_sim.signals import Noise
from plant_sim.simulation import Instant, Simulation

FLOWS = np.array([4.17e-6, 4.22e-5])  # nominal Fp, Fu
COLD = {'start_flow': 0.0, 'initial': {'Tp': 30.0, 'Tu': 30.0}}  # the paper's start


Fault = tuple[float, str, float]  # from when on (s), parameter, value


def played(
    name: str, seconds: float, x0: tuple[float, ...] | None = None, fault: Fault | None = None
) -> list[Instant]:
    """The scenario without noise, from x0 if given; no instant is computed twice."""
    simulation, instants = recording(name, x0, fault)
    for _ in range(len(instants), round(seconds / simulation.period)):
        if fault and simulation.t >= fault[0]:
            simulation.faults = {fault[1]: fault[2]}
        instants.append(simulation.sample())
    return instants[: round(seconds / simulation.period)]


@cache
def recording(
    name: str, x0: tuple[float, ...] | None, fault: Fault | None
) -> tuple[Simulation, list[Instant]]:
    """A simulation and what came of it so far."""
    scenario = load_scenario(name)
    start = x0 or scenario.initial_state
    return Simulation(replace(scenario, initial_state=start), snr_db=np.inf), []


AT_REST = (24.303, 20.108, 0.029e6 / 6089.0, 0.0, 0.0348e6 / 6089.0, 0.0)


def true_flows(instants: list[Instant]) -> Array:
    """Fp and Fu (K, 2)."""
    return np.array([[plant.flow2(i.p[1], i.x[4]), plant.flow1(i.p[0], i.x[2])] for i in instants])


def coloured(count: int, seed: int, sigma: float = 0.05, outputs: int = 2) -> Array:
    """Noise correlated over 100 samples (count, outputs)."""
    noise = Noise(seed, outputs, np.exp(-0.01))
    return np.array([noise.draw(sigma) for _ in range(count)])


def watched(observer: Any, instants: list[Instant], what: str, noise: Any = None) -> Array:
    """The observer's array of that name after every sample (K, ...)."""
    added = np.zeros(len(instants)) if noise is None else noise
    found = []
    for instant, error in zip(instants, added):
        y = np.array(instant.y) + error
        observer.absorb(Sample(round(instant.t * 1e9), y=y, u=np.array(instant.u)))
        found.append(getattr(observer, what).copy())
    return np.array(found)


def settled(flows: Array, truth: Array, seconds: Array, share: float = 0.02) -> list[float]:
    """When each flow last was further off than that share."""
    off = np.abs(flows / truth - 1.0) > share
    return [float(seconds[np.flatnonzero(column)[-1]]) for column in off.T]


def rms_percent(flows: Array, truth: Array) -> Array:
    return np.asarray(100.0 * np.sqrt(np.mean((flows / truth - 1.0) ** 2, axis=0)))
