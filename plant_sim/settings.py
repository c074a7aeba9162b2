"""The simulator's parameters."""

import math
from typing import get_args

from obs_ros.knob import Knob
from obs_ros.model import Model
from plant_sim.simulation import NoiseReference

CHOICE = (
    Knob(
        'scenario', 'three_tank', 'experiment: a built-in name or package.module:ATTRIBUTE',
        read_only=True,
    ),
)  # fmt: skip

COMMON = (
    Knob(
        'speed', 1.0, 'plant time per wall time; other than 1 publishes /clock', positive=True
    ),
    Knob(
        'publish_clock', False, 'publish /clock at speed 1 too, and stamp with plant time from 0',
        read_only=True,
    ),
    Knob('enabled', True, 'run, or stand still; at start as well'),
    Knob(
        'rate', 0.0, "samples per s of plant time; 0: the scenario's own; taken up by ~/reset",
        'Hz', lower=0.0,
    ),
    Knob('seed', 0, 'seed of the noise and of random inputs; taken up by ~/reset', lower=0),
    Knob(
        'snr_db', math.nan, "signal-to-noise ratio; nan: the scenario's own; inf: no noise", 'dB',
        nan=True,
    ),
    Knob(
        'noise_reference', 'unit',
        'power that snr_db counts from: 1, as in the papers, or that of the outputs; '
        'taken up by ~/reset',
        choices=get_args(NoiseReference),
    ),
)  # fmt: skip


def fault_knobs(model: Model) -> tuple[Knob, ...]:
    """Return one parameter per plant parameter: set it while running to inject a fault."""
    return tuple(
        Knob(
            f'plant.{v.name}', math.nan,
            f'holds {v.name} there, whatever the scenario has scheduled; nan: as scheduled',
            v.unit, lower=v.lower, upper=v.upper, nan=True,
        )
        for v in model.parameters
    )  # fmt: skip
