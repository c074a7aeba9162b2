"""The model of a spring under forces, for any source tree."""

from typing import Any

from obs_ros import Model, Variable


def dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any]:
    """Return the rates of position and speed."""
    return x[1], u[0] - p[0] * x[0] - p[1] * x[1]


def output(t: Any, x: Any, u: Any, p: Any) -> tuple[Any]:
    """Return the position."""
    return (x[0],)


SPRING = Model(
    name='benchmark_spring',
    states=(
        Variable('position', 'm', lower=-3.0, upper=3.0),
        Variable('speed', 'm/s', lower=-12.0, upper=12.0),
    ),
    inputs=(Variable('force', 'm/s2'),),
    outputs=(Variable('y', 'm'),),
    parameters=(
        Variable('stiffness', '1/s2', lower=1.0, upper=100.0),
        Variable('damping', '1/s', lower=0.0, upper=5.0),
    ),
    dynamics=dynamics,
    output=output,
    max_step=0.02,
)
