"""A DC motor under voltage; current and speed are measured."""

from typing import Any

from obs_ros import Model, Variable


def dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any]:
    """Return the rates of current (A/s) and speed (rad/s2) under the voltage u (V)."""
    current, speed = x
    resistance, inductance, constant, inertia, friction = p
    return (
        (u[0] - resistance * current - constant * speed) / (1e-3 * inductance),
        (constant * current - 1e-3 * friction * speed) / (1e-3 * inertia),
    )


def output(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any]:
    """Return current (A) and speed (rad/s)."""
    return x[0], x[1]


DC_MOTOR = Model(
    name='dc_motor',
    states=(
        Variable('current', 'A', lower=-30.0, upper=30.0),
        Variable('speed', 'rad/s', lower=-250.0, upper=250.0),
    ),
    inputs=(Variable('voltage', 'V'),),
    outputs=(Variable('current', 'A'), Variable('speed', 'rad/s')),
    parameters=(
        Variable('resistance', 'ohm', lower=0.2, upper=5.0),
        Variable('inductance', 'mH', lower=5.0, upper=100.0),
        Variable('constant', 'V s/rad', lower=0.02, upper=0.4),
        Variable('inertia', 'g m2', lower=0.3, upper=10.0),
        Variable('friction', 'mN m s/rad', lower=0.05, upper=10.0),
    ),
    dynamics=dynamics,
    output=output,
    max_step=0.0025,
)
