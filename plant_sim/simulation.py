"""A scenario played sample by sample: the same numbers live in the node and offline."""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from obs_ros.models import load_model
from obs_ros.typing import Array
from plant_sim.plant import Plant
from plant_sim.scenario import Scenario
from plant_sim.signals import Noise, noise_deviation

NoiseReference = Literal['unit', 'measured']


@dataclass(frozen=True)
class Instant:
    """The plant at one sample: time t (s), true x, applied u, parameters p, measured y."""

    t: float
    x: tuple[float, ...]
    u: tuple[float, ...]
    p: tuple[float, ...]
    y: tuple[float, ...]


class Simulation:
    """Plays `scenario` with a sample every `period` s (default: the scenario's own).

    `faults` holds parameter values that replace the scheduled ones for as long as they stand there;
    it may be changed between samples. `noise_reference` says what `snr_db` counts from: a signal of
    unit power, as in the papers, or the outputs' power measured over the scenario's duration.
    """

    def __init__(
        self,
        scenario: Scenario,
        *,
        period: float | None = None,
        seed: int = 0,
        snr_db: float | None = None,
        noise_reference: NoiseReference = 'unit',
    ) -> None:
        self.scenario = scenario
        self.model = load_model(scenario.model)
        self.period = scenario.sample_period if period is None else period
        if not self.period > 0.0:
            raise ValueError(f'sample period {self.period} s is not positive')
        self.snr_db = scenario.snr_db if snr_db is None else snr_db
        self.faults: dict[str, float] = {}
        self._plant = Plant(self.model, scenario.initial_state)
        self._noise = Noise(seed, len(self.model.outputs))
        self._power: float | Array = 1.0
        if noise_reference == 'measured':
            self._power = _output_power(scenario, self.period)
        self._samples = 0

    @property
    def t(self) -> float:
        """Time of the next sample in s."""
        return self._samples * self.period

    def sample(self) -> Instant:
        """Run the plant to its next sample and measure there."""
        if self._samples:
            self._advance(self.t)
        t, plant = self.t, self._plant
        u, p = self.scenario.inputs(t), self._parameters(t)
        exact = plant.output(u, p)
        y = np.asarray(exact)
        if not math.isinf(self.snr_db):
            y = y + self._noise.draw(noise_deviation(self.snr_db, self._power))
        self._samples += 1
        return Instant(t, plant.x, u, p, tuple(y.tolist()))

    def _advance(self, to: float) -> None:
        """Run to time `to`, stopping at each scheduled change on the way."""
        plant, schedule = self._plant, self.scenario.parameters
        u = self.scenario.inputs(plant.t)
        while plant.t < to:
            stop = min(to, schedule.next_change(plant.t))
            plant.advance(stop, u, self._parameters(plant.t))

    def _parameters(self, t: float) -> tuple[float, ...]:
        scheduled = zip(self.model.parameters, self.scenario.parameters(t), strict=True)
        return tuple(self.faults.get(variable.name, value) for variable, value in scheduled)


def _output_power(scenario: Scenario, period: float) -> Array:
    """Return the mean square of each output over the scenario, without noise."""
    quiet = Simulation(scenario, period=period, snr_db=math.inf)
    outputs = [quiet.sample().y for _ in range(math.ceil(scenario.duration / period))]
    return np.asarray(np.mean(np.square(outputs), axis=0))
