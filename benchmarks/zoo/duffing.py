"""Forced Duffing oscillators: Guckenheimer & Holmes 1983, section 2.2.

One has a hardening spring; the other one a double well, between which it mostly moves in chaos.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.zoo.output import first_state
from obs_ros import Model, Variable

FORCING_FREQUENCY = 1.2  # rad/s
PERIOD = 2.0 * np.pi / FORCING_FREQUENCY  # s


def dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any]:
    """Position and speed under damping, a hardening spring and a cosine force."""
    position, speed = x
    damping, linear, cubic, force = p
    pull = linear * position + cubic * position * position * position
    return speed, force * np.cos(FORCING_FREQUENCY * t) - damping * speed - pull


DUFFING = Model(
    name='duffing',
    states=(Variable('position', lower=-2.0, upper=2.0), Variable('speed', lower=-2.0, upper=2.0)),
    outputs=(Variable('position'),),
    parameters=(
        Variable('damping', lower=0.01, upper=0.3, nominal=0.1),
        Variable('linear', lower=0.2, upper=2.0, nominal=1.0),
        Variable('cubic', lower=0.2, upper=2.0, nominal=1.0),
        Variable('force', lower=0.1, upper=2.0, nominal=0.5),
    ),
    dynamics=dynamics,
    output=first_state,
    max_step=0.1,
    reference='Guckenheimer & Holmes 1983, section 2.2',
)
DOUBLE_WELL = replace(
    DUFFING,
    name='double_well',
    parameters=(
        Variable('damping', lower=0.05, upper=0.5, nominal=0.25),
        Variable('linear', lower=-2.0, upper=0.0, nominal=-1.0),
        Variable('cubic', lower=0.2, upper=2.0, nominal=1.0),
        Variable('force', lower=0.05, upper=0.6, nominal=0.3),
    ),
)
