"""Four and eight tanks in a row, fed at the first, drained at the last; odd levels are measured.

Every valve's opening and every level is unknown: 8 and 16 unknowns, with a long flat valley.
"""

from typing import Any

from obs_ros import Model, Variable
from obs_ros.models.three_tank import FLOW, TANK_AREA, jet_speed


def dynamics4(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, ...]:
    """Level rates in cm/s."""
    q0 = p[0] * FLOW * jet_speed(x[0] - x[1])
    q1 = p[1] * FLOW * jet_speed(x[1] - x[2])
    q2 = p[2] * FLOW * jet_speed(x[2] - x[3])
    q3 = p[3] * FLOW * jet_speed(x[3])
    return u[0] / TANK_AREA - q0, q0 - q1, q1 - q2, q2 - q3


def dynamics8(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, ...]:
    """Level rates in cm/s."""
    q0 = p[0] * FLOW * jet_speed(x[0] - x[1])
    q1 = p[1] * FLOW * jet_speed(x[1] - x[2])
    q2 = p[2] * FLOW * jet_speed(x[2] - x[3])
    q3 = p[3] * FLOW * jet_speed(x[3] - x[4])
    q4 = p[4] * FLOW * jet_speed(x[4] - x[5])
    q5 = p[5] * FLOW * jet_speed(x[5] - x[6])
    q6 = p[6] * FLOW * jet_speed(x[6] - x[7])
    q7 = p[7] * FLOW * jet_speed(x[7])
    feed = u[0] / TANK_AREA
    return feed - q0, q0 - q1, q1 - q2, q2 - q3, q3 - q4, q4 - q5, q5 - q6, q6 - q7


def output4(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, ...]:
    """Return every other level in cm."""
    return x[0], x[2]


def output8(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, ...]:
    """Return every other level in cm."""
    return x[0], x[2], x[4], x[6]


def _chain(n: int, dynamics: Any, output: Any) -> Model:
    return Model(
        name=f'tank_chain_{n}',
        states=tuple(Variable(f'h{i}', unit='cm', lower=0.0, upper=100.0) for i in range(n)),
        inputs=(Variable('Q', unit='cm3/s', nominal=30.0),),
        outputs=tuple(Variable(f'h{i}', unit='cm') for i in range(0, n, 2)),
        parameters=tuple(Variable(f'p{i}', lower=0.0, upper=1.0, nominal=0.5) for i in range(n)),
        dynamics=dynamics,
        output=output,
        max_step=1.0,
    )


TANK_CHAIN_4 = _chain(4, dynamics4, output4)
TANK_CHAIN_8 = _chain(8, dynamics8, output8)
