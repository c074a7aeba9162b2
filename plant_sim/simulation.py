"""A scenario played sample by sample: the same numbers live in the node and offline."""

import math
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np

from obs_ros.core.estimated_delays import own_parameters, signal_of
from obs_ros.core.model import Model, Variable, names
from obs_ros.core.periods import periods, within
from obs_ros.core.typing import Array
from obs_ros.models import load_model
from plant_sim.actuators import IDEAL, Actuator, Inputs
from plant_sim.past import Past, Stretch
from plant_sim.plant import Plant
from plant_sim.scenario import Scenario
from plant_sim.sensors import PERFECT, Outliers, Sensor, readings
from plant_sim.signals import Noise, noise_deviation
from plant_sim.sources import start

NoiseReference = Literal['unit', 'measured']


@dataclass(frozen=True)
class Instant:
    """The plant at one sample: time t (s), true x, told inputs u, parameters p, measured y.

    States with a period lie in [-period/2, period/2).
    """

    t: float
    x: tuple[float, ...]
    u: tuple[float, ...]
    p: tuple[float, ...]
    y: tuple[float, ...]


class _Measured(NamedTuple):
    """An instant, and the errors of its outputs: noise with disturbance, outliers in sigmas."""

    instant: Instant
    error: Array
    outliers: tuple[float, ...]


class Simulation:
    """Plays `scenario` with a sample every `period` s (default: the scenario's own).

    `faults` holds parameter values that replace the scheduled ones for as long as they stand there,
    `sensors` and `actuators` by name those of outputs and inputs, perfect where one is missing: at
    first those that the model declares. All may be changed between samples. A controller gets the
    readings at their time: an offset in time is one of the stamps. Where a sensor stamps values
    before they are measured, the plant runs ahead of the samples. `model` is that of the scenario
    with other sensors and actuators; delays among its parameters are those that these have.
    `seed` is that of the noise, of outliers and of inputs drawn at random. `noise_reference` says
    what `snr_db` counts from: a signal of unit power, as in the papers, or the outputs' power
    measured over the scenario's duration.
    """

    def __init__(
        self,
        scenario: Scenario,
        *,
        model: Model | None = None,
        period: float | None = None,
        seed: int = 0,
        snr_db: float | None = None,
        noise_reference: NoiseReference = 'unit',
    ) -> None:
        self.scenario = scenario
        self.model = load_model(scenario.model) if model is None else model
        self.period = scenario.sample_period if period is None else period
        if not self.period > 0.0:
            raise ValueError(f'sample period {self.period} s is not positive')
        self.snr_db = scenario.snr_db if snr_db is None else snr_db
        self.faults: dict[str, float] = {}
        self.sensors: Mapping[str, Sensor] = {v.name: Sensor.of(v) for v in self.model.outputs}
        self.actuators: Mapping[str, Actuator] = {v.name: Actuator.of(v) for v in self.model.inputs}
        known = names(self.model.parameters)
        self._own = names(own_parameters(self.model.parameters))
        self._delayed = tuple(signal_of(name) for name in known[len(self._own) :])
        self._plant = Plant(self.model, scenario.initial_state)
        self._past = Past(self.model)
        self._drive = start(scenario.inputs, self.period, seed)
        self._inputs = Inputs(len(self.model.inputs), scenario.running_inputs)
        tau = scenario.noise_correlation
        correlation = math.exp(-self.period / tau) if tau else 0.0
        self._noise = Noise(seed, len(self.model.outputs), correlation)
        self._outliers = Outliers(seed, len(self.model.outputs))
        self._power: float | Array = 1.0
        if noise_reference == 'measured':
            self._power = _output_power(scenario, self.model, self.period, seed)
        self._samples = 0  # that the plant has run to
        self._waiting: deque[_Measured] = deque()

    @property
    def t(self) -> float:
        """Time of the next sample in s."""
        return self._waiting[0].instant.t if self._waiting else self._samples * self.period

    def sample(self) -> Instant:
        """Run the plant to its next sample, and ahead where a sensor is early, and measure."""
        sensors = [self.sensors.get(name, PERFECT) for name in names(self.model.outputs)]
        delays = [sensor.delay for sensor in sensors]
        ahead = -min(delays)
        while not self._waiting or (ahead > 0.0 and self._plant.t <= self.t + ahead):
            self._waiting.append(self._measure(sensors))
        measured = self._waiting.popleft()
        if not any(delays):
            return measured.instant
        self._past.forget(measured.instant.t - max(delays))
        return self._stamped(measured, sensors)

    def _measure(self, sensors: Sequence[Sensor]) -> _Measured:
        """Run the plant on by one sample and measure there, every sensor in time."""
        t, plant = self._samples * self.period, self._plant
        actuators = [self.actuators.get(name, IDEAL) for name in names(self.model.inputs)]
        if not any(sensor.delay for sensor in sensors):
            self._past.clear()
        if self._samples:
            self._advance(t, actuators, remember=any(sensor.delay for sensor in sensors))
        p, error = self._parameters(t), self._measurement_error(t)
        outliers = self._outliers.draw(sensors, t, self.period)

        def measured() -> tuple[float, ...]:
            exact = plant.output(self._inputs.acting(t, actuators), p)
            return self._read(sensors, _sum(exact, error), outliers)

        # A controller acts on what is measured under the input that it set last.
        u = self._drive(t, measured())
        self._inputs.tell(t, u, actuators)
        self._samples += 1
        x = _within(self.model.states, plant.x)
        return _Measured(Instant(t, x, u, p, measured()), error, outliers)

    def _stamped(self, measured: _Measured, sensors: Sequence[Sensor]) -> Instant:
        """Return the instant with the readings of sensors that are early or late."""
        instant, y = measured.instant, list(measured.instant.y)
        for i, sensor in enumerate(sensors):
            exact = self._past.outputs(instant.t - sensor.delay) if sensor.delay else None
            if exact is not None:
                values = _sum(exact, measured.error)
                y[i] = self._read(sensors, values, measured.outliers)[i]
        return replace(instant, y=tuple(y))

    def _read(
        self, sensors: Sequence[Sensor], values: tuple[float, ...], outliers: tuple[float, ...]
    ) -> tuple[float, ...]:
        """Return what the sensors read of measured values."""
        quiet = math.isinf(self.snr_db)
        sigma = 1.0 if quiet else noise_deviation(self.snr_db, self._power)
        return readings(sensors, values, outliers, np.broadcast_to(sigma, len(values)))

    def _advance(self, to: float, actuators: Sequence[Actuator], *, remember: bool) -> None:
        """Run to time `to`, stopping at each scheduled change on the way."""
        plant, schedule, inputs = self._plant, self.scenario.parameters, self._inputs
        while plant.t < to:
            u, p = inputs.signal(plant.t, actuators), self._parameters(plant.t)
            if remember:
                self._past.add(Stretch(plant.t, plant.x, u, p, plant.following, plant.stiff))
            changes = schedule.next_change(plant.t), inputs.next_change(plant.t, actuators)
            plant.advance(min(to, *changes), u, p)

    def _measurement_error(self, t: float) -> Array:
        """Return noise plus disturbance of the outputs at `t`, each drawn once."""
        error = np.zeros(len(self.model.outputs))
        if not math.isinf(self.snr_db):
            error += self._noise.draw(noise_deviation(self.snr_db, self._power))
        if self.scenario.disturbance:
            error += self.scenario.disturbance(t)
        return error

    def _parameters(self, t: float) -> tuple[float, ...]:
        scheduled = zip(self._own, self.scenario.parameters(t), strict=True)
        values = (self.faults.get(name, value) for name, value in scheduled)
        return *values, *(self._delay(signal) for signal in self._delayed)

    def _delay(self, signal: str) -> float:
        """Return the delay (s) that an input or output has."""
        if signal in names(self.model.inputs):
            return self.actuators.get(signal, IDEAL).delay
        return self.sensors.get(signal, PERFECT).delay


def _within(variables: Sequence[Variable], values: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(within(np.array(values), periods(variables)).tolist())


def _sum(exact: tuple[float, ...], error: Array) -> tuple[float, ...]:
    return tuple(np.add(exact, error).tolist())


def _output_power(scenario: Scenario, model: Model, period: float, seed: int) -> Array:
    """Return the mean square of each output over the scenario, without noise."""
    quiet = Simulation(scenario, model=model, period=period, seed=seed, snr_db=math.inf)
    outputs = [quiet.sample().y for _ in range(math.ceil(scenario.duration / period))]
    return np.asarray(np.mean(np.square(outputs), axis=0))
