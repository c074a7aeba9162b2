"""A van der Pol oscillator pushed by a force; its position is measured: van der Pol 1926."""

from typing import Any

from benchmarks.zoo.output import first_state
from obs_ros import Model, Variable


def dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any]:
    """Return the rates of position (m/s) and speed (m/s2)."""
    position, speed = x
    damping, stiffness, gain = p
    swing = damping * (1.0 - position * position) * speed
    return speed, swing - stiffness * position + gain * u[0]


VAN_DER_POL = Model(
    name='van_der_pol',
    states=(
        Variable('position', 'm', lower=-5.0, upper=5.0),
        Variable('speed', 'm/s', lower=-10.0, upper=10.0),
    ),
    inputs=(Variable('force', 'N'),),
    outputs=(Variable('position', 'm'),),
    parameters=(
        Variable('damping', '1/s', lower=0.05, upper=4.0),
        Variable('stiffness', '1/s2', lower=0.1, upper=5.0),
        Variable('gain', '1/kg', lower=0.05, upper=4.0),
    ),
    dynamics=dynamics,
    output=first_state,
    max_step=0.05,
    reference='van der Pol 1926',
)
