"""Simulated experiments: a plant, its start, its inputs and its faults."""

from dataclasses import dataclass

from obs_ros.core.estimated_delays import own_parameters
from obs_ros.models import load_model
from plant_sim.signals import Schedule, Signal
from plant_sim.sources import Source, start


@dataclass(frozen=True)
class Scenario:
    """One experiment on `model` (a name, or `module:ATTRIBUTE`).

    `inputs` are a signal, or a source such as a controller, read at every sample and held until the
    next; where `held` is false, a signal runs on in between. `parameters` change exactly on their
    times; they may differ from the model's nominal ones, which is all that an estimator knows.
    Delays that are estimated are none of them: sensors and actuators have those.
    `disturbance` is added to the measured outputs. The noise is white, or an Ornstein-Uhlenbeck
    process with the time constant `noise_correlation`. Times are in s; after `duration` the plant
    runs on.

    Raises ValueError when a vector has not the length that the model wants, or a source is to run
    on between samples.
    """

    name: str
    model: str
    initial_state: tuple[float, ...]
    inputs: Signal | Source
    parameters: Schedule
    sample_period: float
    duration: float
    snr_db: float = 40.0
    noise_correlation: float = 0.0
    held: bool = True
    disturbance: Signal | None = None
    reference: str = ''

    def __post_init__(self) -> None:
        model = load_model(self.model)
        nothing = (0.0,) * len(model.outputs)
        drive = start(self.inputs, self.sample_period, seed=0)
        disturbance = self.disturbance(0.0) if self.disturbance else nothing
        for kind, values, variables in (
            ('initial state', self.initial_state, model.states),
            ('inputs', drive(0.0, nothing), model.inputs),
            ('parameters', self.parameters(0.0), own_parameters(model.parameters)),
            ('disturbance', disturbance, model.outputs),
        ):
            if len(values) != len(variables):
                raise ValueError(
                    f'scenario {self.name!r}: {kind} {values} should have one entry for each of '
                    f'{", ".join(v.name for v in variables) or "no variables"}'
                )
        if not (self.sample_period > 0.0 and self.duration > 0.0):
            raise ValueError(f'scenario {self.name!r}: periods and durations must be positive')
        if not self.noise_correlation >= 0.0:
            raise ValueError(
                f'scenario {self.name!r}: noise_correlation {self.noise_correlation} s is negative'
            )
        if isinstance(self.inputs, Source) and not self.held:
            raise ValueError(f'scenario {self.name!r}: only a signal can run on between samples')

    @property
    def running_inputs(self) -> Signal | None:
        """The inputs as they run on between samples, or None where they are held."""
        return None if self.held or isinstance(self.inputs, Source) else self.inputs
