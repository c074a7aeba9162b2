"""The simulator's parameters."""

import math
from collections.abc import Mapping
from typing import Any, get_args

from obs_ros.core.model import Model
from obs_ros.core.parameter_spec import LARGEST_SEED, ParameterSpec
from obs_ros.interface.usage import node_usage
from plant_sim.fault_settings import actuator_parameters, sensor_parameters
from plant_sim.scenario import Scenario
from plant_sim.scenarios import SCENARIOS
from plant_sim.simulation import NoiseReference

MOST_STEPS = 1e5  # of the plant, from one sample to the next: a second
MOST_NAMES = 100  # that are nobody's, in one message
MOST_SAMPLES = 3e5  # of the run that measures the power of the outputs: some seconds

CHOICE = (
    ParameterSpec('scenario', 'three_tank',
        'experiment: a built-in name or package.module:ATTRIBUTE', read_only=True),
)  # fmt: skip

COMMON = (
    ParameterSpec('speed', 1.0, 'plant time per wall time; other than 1 publishes /clock',
        lower=1e-3, upper=1e6),
    ParameterSpec('publish_clock', False,
        'publish /clock at speed 1 too, and stamp with plant time from 0', read_only=True),
    ParameterSpec('enabled', True, 'run, or stand still; at start as well'),
    ParameterSpec('rate', 0.0,
        "samples per s of plant time; 0: the scenario's own; taken up by ~/reset", 'Hz',
        lower=0.0, upper=1e5),
    ParameterSpec('seed', 0, 'seed of the noise and of random inputs; taken up by ~/reset',
        lower=0, upper=LARGEST_SEED),
    ParameterSpec('snr_db', math.nan,
        "signal-to-noise ratio; nan: the scenario's own; inf: no noise", 'dB',
        lower=-200.0, nan=True),
    ParameterSpec('noise_reference', 'unit',
        'power that snr_db counts from: 1, as in the papers, or that of the outputs; '
        'taken up by ~/reset',
        choices=get_args(NoiseReference)),
    ParameterSpec('further_names', 0,
        'names that messages on plant/output and plant/input carry beside those of the model',
        lower=0, upper=MOST_NAMES),
)  # fmt: skip


def usage() -> str:
    """Return what `simulator --help` prints."""
    return node_usage(
        'simulator',
        'Plays a plant live: publishes plant/output and plant/input, and the truth on plant/state '
        'and plant/parameters.',
        (*CHOICE, *COMMON),
        {
            'plant.NAME': 'holds that parameter there, to inject a fault; nan: as scheduled',
            **{spec.name: spec.describe() for spec in sensor_parameters('OUTPUT')},
            **{spec.name: spec.describe() for spec in actuator_parameters('INPUT')},
        },
        (
            f'Scenarios: {", ".join(SCENARIOS)}.',
            'Each parameter with a comment: share/obs_ros/config/three_tank.yaml. Names and '
            'topics: README.md.',
        ),
    )


def check_rate(scenario: Scenario, model: Model, values: Mapping[str, Any]) -> None:
    """Raise ValueError for a rate at which one sample, or a restart, would block the node."""
    rate = values['rate']
    if rate and 1.0 / rate > MOST_STEPS * model.max_step:
        raise ValueError(
            f'raise rate: from one sample to the next at {rate:g} Hz the plant takes '
            f'{1.0 / rate / model.max_step:.2g} steps, at most {MOST_STEPS:g}'
        )
    samples = scenario.duration * (rate or 1.0 / scenario.sample_period)
    if values['noise_reference'] == 'measured' and samples > MOST_SAMPLES:
        raise ValueError(
            f'lower rate, or let noise_reference be unit: the {scenario.duration:g} s of '
            f'{scenario.name} would take {samples:.2g} samples to measure, at most {MOST_SAMPLES:g}'
        )
