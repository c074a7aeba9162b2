"""A spring under random forces, as its sensors and actuators show it: 50 Hz, windows of 3 s."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from benchmarks.sensors.spring_model import SPRING
from obs_ros import Model, Record
from obs_ros.core.typing import Array
from plant_sim.actuators import Actuator
from plant_sim.scenario import Scenario
from plant_sim.sensors import Sensor
from plant_sim.signals import Signal, constant
from plant_sim.simulation import Instant, Simulation

INTERVAL, SAMPLES = 0.02, 150  # s, in a window
NOISE = 0.004  # m: 40 dB below the positions
FORCE = 8.0  # m/s2, at most
HELD = (0.2, 0.8)  # s that a force stays
STIFFNESS, DAMPING = (10.0, 30.0), (0.4, 1.5)  # 1/s2, 1/s


class Run(NamedTuple):
    """A run of a plant: what was recorded, its true parameters by name, and states x (K, n)."""

    record: Record
    truth: Mapping[str, float]
    x: Array

    def windows(self, samples: int = SAMPLES) -> list[Record]:
        """Return windows that abut."""
        t, u, y = self.record.t, self.record.u, self.record.y
        starts = range(0, t.size - samples + 1, samples)
        return [Record(*(each[i : i + samples] for each in (t, u, y))) for i in starts]

    def later(self, samples: int) -> 'Run':
        """Return the run without its first samples."""
        t, u, y = (each[samples:] for each in (self.record.t, self.record.u, self.record.y))
        return Run(Record(t, u, y), self.truth, self.x[samples:])

    def spoiled(self, y: Array) -> 'Run':
        """Return the run with other outputs (K, r)."""
        return self._replace(record=self.record.with_outputs(y))


def declared(output: Mapping[str, Any] = {}, input: Mapping[str, Any] = {}) -> Model:
    """Return the spring whose output and input have further properties."""
    return replace(
        SPRING,
        outputs=[replace(v, **output) for v in SPRING.outputs],
        inputs=[replace(v, **input) for v in SPRING.inputs],
    )


def run(
    seed: int,
    samples: int = SAMPLES,
    sensor: Sensor | None = None,
    actuator: Actuator | None = None,
) -> Run:
    """Return the run of that seed by the simulator; faults change neither plant nor noise."""
    rng = np.random.default_rng([seed, samples])
    p = rng.uniform(*zip(STIFFNESS, DAMPING, strict=True))
    scenario = Scenario(
        name='spring',
        model='benchmarks.sensors.spring_model:SPRING',
        initial_state=tuple(rng.uniform((-0.5, -1.0), (0.5, 1.0)).tolist()),
        inputs=forces(rng, INTERVAL * samples),
        parameters=constant(*p.tolist()),
        sample_period=INTERVAL,
        duration=INTERVAL * samples,
        snr_db=-20.0 * np.log10(NOISE),
    )
    simulation = Simulation(scenario, seed=seed)
    simulation.sensors = {} if sensor is None else {'y': sensor}
    simulation.actuators = {} if actuator is None else {'force': actuator}
    instants = [simulation.sample() for _ in range(samples)]
    return run_of(instants, dict(zip(('stiffness', 'damping'), p.tolist(), strict=True)))


def run_of(instants: Sequence[Instant], truth: Mapping[str, float]) -> Run:
    """Return instants as a run."""
    t, u, y, x = (np.array([getattr(one, name) for one in instants]) for name in 'tuyx')
    return Run(Record(t, u, y), truth, x)


def forces(rng: np.random.Generator, duration: float) -> Signal:
    """Return random forces, each held for a while; the samples of a run see every change."""
    lengths = rng.uniform(*HELD, size=int(duration / HELD[0]) + 2)
    ends = INTERVAL * np.round(np.cumsum(lengths) / INTERVAL)
    levels = rng.uniform(-FORCE, FORCE, size=ends.size)
    slack = 0.5 * INTERVAL
    return lambda t: (float(levels[np.searchsorted(ends, t + slack, side='right')]),)
