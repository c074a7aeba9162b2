"""What a simulated experiment is: a plant, how it starts, what drives it and what breaks."""

from dataclasses import dataclass

from obs_ros.models import load_model
from plant_sim.signals import Schedule, Signal


@dataclass(frozen=True)
class Scenario:
    """One experiment on `model` (a name, or `module:ATTRIBUTE`).

    `inputs` are read at every sample and held until the next; `parameters` change exactly on their
    times. `sample_period` and `duration` are in s; after `duration` the plant runs on.

    Raises ValueError when a vector has not the length that the model wants.
    """

    name: str
    model: str
    initial_state: tuple[float, ...]
    inputs: Signal
    parameters: Schedule
    sample_period: float
    duration: float
    snr_db: float = 40.0
    reference: str = ''

    def __post_init__(self) -> None:
        model = load_model(self.model)
        for kind, values, variables in (
            ('initial state', self.initial_state, model.states),
            ('inputs', self.inputs(0.0), model.inputs),
            ('parameters', self.parameters(0.0), model.parameters),
        ):
            if len(values) != len(variables):
                raise ValueError(
                    f'scenario {self.name!r}: {kind} {values} should have one entry for each of '
                    f'{", ".join(v.name for v in variables) or "no variables"}'
                )
        if not (self.sample_period > 0.0 and self.duration > 0.0):
            raise ValueError(f'scenario {self.name!r}: periods and durations must be positive')
