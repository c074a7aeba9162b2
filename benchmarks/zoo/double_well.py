"""Forced Duffing oscillator with a double well, mostly chaotic: Guckenheimer & Holmes 1983."""

from dataclasses import replace

from benchmarks.zoo.duffing import DUFFING
from obs_ros import Variable

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
