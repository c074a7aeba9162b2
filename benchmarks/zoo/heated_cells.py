"""Six heated cells in a row, which conduct to each other and lose heat to a room."""

from typing import Any

from obs_ros import Model, Variable

ROOM = 20.0  # degC


def dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, ...]:
    """Return the temperatures' rates (K/s); u are the heaters (W) of the first and fourth cell."""
    t1, t2, t3, t4, t5, t6 = x
    left, bridge, right, loss, c_left, c_right = p
    q12, q23 = left * (t1 - t2), left * (t2 - t3)
    q34 = bridge * (t3 - t4)
    q45, q56 = right * (t4 - t5), right * (t5 - t6)
    return (
        (u[0] - q12 - loss * (t1 - ROOM)) / c_left,
        (q12 - q23 - loss * (t2 - ROOM)) / c_left,
        (q23 - q34 - loss * (t3 - ROOM)) / c_left,
        (u[1] + q34 - q45 - loss * (t4 - ROOM)) / c_right,
        (q45 - q56 - loss * (t5 - ROOM)) / c_right,
        (q56 - loss * (t6 - ROOM)) / c_right,
    )


def output(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any, Any]:
    """Return the temperatures of the first, third and sixth cell (degC)."""
    return x[0], x[2], x[5]


HEATED_CELLS = Model(
    name='heated_cells',
    states=tuple(Variable(f'T{i}', 'degC', lower=0.0, upper=100.0) for i in range(1, 7)),
    inputs=(Variable('Q1', 'W'), Variable('Q4', 'W')),
    outputs=tuple(Variable(f'T{i}', 'degC') for i in (1, 3, 6)),
    parameters=(
        *(Variable(k, 'W/K', lower=0.1, upper=4.0) for k in ('left', 'bridge', 'right')),
        Variable('loss', 'W/K', lower=0.01, upper=1.0),
        *(Variable(c, 'J/K', lower=8.0, upper=150.0) for c in ('c_left', 'c_right')),
    ),
    dynamics=dynamics,
    output=output,
    max_step=1.0,
)
