"""Plants with many unknowns: masses on springs in a row, and rooms that heat each other."""

from typing import Any

from obs_ros import Model, Variable

MASS = 1.0  # kg, of each
HEAT = 50.0  # kJ/K, of each room
STEP = 0.02  # s, of the masses: their fastest mode has 24 rad/s
AMBIENT = 10.0  # degC


def masses(count: int) -> Model:
    """Return a row of masses on a wall: 2 states, a spring and a damper each are unknown.

    The last one is pushed, and all positions are measured.
    """

    def dynamics(t: Any, x: Any, u: Any, p: Any) -> Any:
        tension = [p[0] * x[0]]
        for i in range(1, count):
            tension.append(p[i] * (x[i] - x[i - 1]))
        tension.append(u[0])
        rates = []
        for i in range(count):
            rates.append(x[count + i])
        for i in range(count):
            force = tension[i + 1] - tension[i] - p[count + i] * x[count + i]
            rates.append(force / MASS)
        return rates

    def output(t: Any, x: Any, u: Any, p: Any) -> Any:
        return x[:count]

    return Model(
        name=f'masses_{count}',
        states=(
            *(Variable(f'x{i}', 'm', lower=-2.0, upper=2.0) for i in range(count)),
            *(Variable(f'v{i}', 'm/s', lower=-20.0, upper=20.0) for i in range(count)),
        ),
        inputs=(Variable('force', 'N'),),
        outputs=tuple(Variable(f'x{i}', 'm') for i in range(count)),
        parameters=(
            *(Variable(f'k{i}', 'N/m', lower=20.0, upper=150.0) for i in range(count)),
            *(Variable(f'd{i}', 'N s/m', lower=0.0, upper=2.0) for i in range(count)),
        ),
        dynamics=dynamics,
        output=output,
        max_step=STEP,
    )


def rooms(count: int) -> Model:
    """Return a row of rooms: the temperature of each and its way to the next one are unknown.

    The last one loses heat to the outside. The first one and that in the middle are heated; every
    other one has a sensor.
    """

    def dynamics(t: Any, x: Any, u: Any, p: Any) -> Any:
        flows = [u[0]]
        for i in range(count - 1):
            flows.append(p[i] * (x[i] - x[i + 1]))
        flows.append(p[count - 1] * (x[count - 1] - AMBIENT))
        rates = []
        for i in range(count):
            heat = u[1] if i == count // 2 else 0.0
            rates.append((flows[i] - flows[i + 1] + heat) / HEAT)
        return rates

    def output(t: Any, x: Any, u: Any, p: Any) -> Any:
        return x[::2]

    return Model(
        name=f'rooms_{count}',
        states=tuple(Variable(f'T{i}', 'degC', lower=0.0, upper=50.0) for i in range(count)),
        inputs=(Variable('first', 'kW'), Variable('middle', 'kW')),
        outputs=tuple(Variable(f'T{i}', 'degC') for i in range(0, count, 2)),
        parameters=tuple(Variable(f'g{i}', 'kW/K', lower=0.05, upper=1.0) for i in range(count)),
        dynamics=dynamics,
        output=output,
        max_step=1.0,
    )
