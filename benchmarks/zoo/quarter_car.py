"""A quarter of a car on a road: travel of its suspension and acceleration of its body measured."""

from typing import Any

from obs_ros import Model, Variable

BODY = 300.0  # kg
WHEEL = 40.0  # kg


def dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, ...]:
    """Travel of the suspension, body speed, tyre deflection and wheel speed, over road speed u."""
    travel, body_speed, deflection, wheel_speed = x
    spring, damper, tyre = p
    force = 1e3 * (spring * travel + damper * (body_speed - wheel_speed))
    road = 1e3 * tyre * deflection
    return (body_speed - wheel_speed, -force / BODY, wheel_speed - u[0], (force - road) / WHEEL)


def output(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, ...]:
    """Return suspension travel (m) and body acceleration (m/s2)."""
    spring, damper, _ = p
    return x[0], -1e3 * (spring * x[0] + damper * (x[1] - x[3])) / BODY


QUARTER_CAR = Model(
    name='quarter_car',
    states=(
        Variable('travel', unit='m', lower=-0.1, upper=0.1),
        Variable('body_speed', unit='m/s', lower=-1.0, upper=1.0),
        Variable('deflection', unit='m', lower=-0.05, upper=0.05),
        Variable('wheel_speed', unit='m/s', lower=-2.0, upper=2.0),
    ),
    inputs=(Variable('road_speed', unit='m/s', interpolation='linear'),),
    outputs=(Variable('travel', unit='m'), Variable('acceleration', unit='m/s2')),
    parameters=(
        Variable('spring', unit='kN/m', lower=5.0, upper=40.0, nominal=16.0),
        Variable('damper', unit='kN s/m', lower=0.3, upper=3.0, nominal=1.0),
        Variable('tyre', unit='kN/m', lower=80.0, upper=300.0, nominal=160.0),
    ),
    dynamics=dynamics,
    output=output,
    max_step=0.005,
)
