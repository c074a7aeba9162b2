"""A scenario played sample by sample: the same numbers live in the node and offline."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from obs_ros.core.model import Variable
from obs_ros.core.periods import periods, within
from obs_ros.core.typing import Array
from obs_ros.models import load_model
from plant_sim.plant import Plant
from plant_sim.scenario import Scenario
from plant_sim.signals import Noise, noise_deviation
from plant_sim.sources import start

NoiseReference = Literal['unit', 'measured']


@dataclass(frozen=True)
class Instant:
    """The plant at one sample: time t (s), true x, applied u, parameters p, measured y.

    States and outputs with a period lie in [-period/2, period/2).
    """

    t: float
    x: tuple[float, ...]
    u: tuple[float, ...]
    p: tuple[float, ...]
    y: tuple[float, ...]


class Simulation:
    """Plays `scenario` with a sample every `period` s (default: the scenario's own).

    `faults` holds parameter values that replace the scheduled ones for as long as they stand there;
    it may be changed between samples. `seed` is that of the noise and of inputs drawn at random.
    `noise_reference` says what `snr_db` counts from: a signal of unit power, as in the papers, or
    the outputs' power measured over the scenario's duration.
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
        self._drive = start(scenario.inputs, self.period, seed)
        self._u = (0.0,) * len(self.model.inputs)
        tau = scenario.noise_correlation
        correlation = math.exp(-self.period / tau) if tau else 0.0
        self._noise = Noise(seed, len(self.model.outputs), correlation)
        self._power: float | Array = 1.0
        if noise_reference == 'measured':
            self._power = _output_power(scenario, self.period, seed)
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
        p, error = self._parameters(t), self._measurement_error(t)
        # A controller acts on what is measured under the input that it set last.
        measured = _sum(plant.output(self._u, p), error)
        self._u = self._drive(t, _within(self.model.outputs, measured))
        self._samples += 1
        y = _within(self.model.outputs, _sum(plant.output(self._u, p), error))
        return Instant(t, _within(self.model.states, plant.x), self._u, p, y)

    def _advance(self, to: float) -> None:
        """Run to time `to`, stopping at each scheduled change on the way."""
        plant, schedule, held = self._plant, self.scenario.parameters, self._u
        u = self.scenario.running_inputs or (lambda t: held)
        while plant.t < to:
            stop = min(to, schedule.next_change(plant.t))
            plant.advance(stop, u, self._parameters(plant.t))

    def _measurement_error(self, t: float) -> Array:
        """Return noise plus disturbance of the outputs at `t`, each drawn once."""
        error = np.zeros(len(self.model.outputs))
        if not math.isinf(self.snr_db):
            error += self._noise.draw(noise_deviation(self.snr_db, self._power))
        if self.scenario.disturbance:
            error += self.scenario.disturbance(t)
        return error

    def _parameters(self, t: float) -> tuple[float, ...]:
        scheduled = zip(self.model.parameters, self.scenario.parameters(t), strict=True)
        return tuple(self.faults.get(variable.name, value) for variable, value in scheduled)


def _within(variables: Sequence[Variable], values: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(within(np.array(values), periods(variables)).tolist())


def _sum(exact: tuple[float, ...], error: Array) -> tuple[float, ...]:
    return tuple(np.add(exact, error).tolist())


def _output_power(scenario: Scenario, period: float, seed: int) -> Array:
    """Return the mean square of each output over the scenario, without noise."""
    quiet = Simulation(scenario, period=period, seed=seed, snr_db=math.inf)
    outputs = [quiet.sample().y for _ in range(math.ceil(scenario.duration / period))]
    return np.asarray(np.mean(np.square(outputs), axis=0))
