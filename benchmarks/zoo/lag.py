"""A first-order lag, tau x' = k u - x."""

from typing import Any

from benchmarks.zoo.output import first_state
from obs_ros import Model, Variable


def dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any]:
    """Return the rate of the state."""
    return ((p[0] * u[0] - x[0]) / p[1],)


LAG = Model(
    name='lag',
    states=(Variable('x', 'm', lower=-10.0, upper=10.0),),
    inputs=(Variable('u', 'V'),),
    outputs=(Variable('y', 'm'),),
    parameters=(
        Variable('k', 'm/V', lower=0.2, upper=5.0),
        Variable('tau', 's', lower=0.5, upper=20.0),
    ),
    dynamics=dynamics,
    output=first_state,
    max_step=0.1,
)
