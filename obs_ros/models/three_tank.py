"""Three tanks in a row, joined by valves: Yang, Li & Dahhou 2020, eq. 16.

Valve 1 joins tanks 1 and 3, valve 3 joins tanks 3 and 2, valve 2 drains tank 2; the openings
p1, p2, p3 are the parameters. The levels h1 and h2 are measured, h3 is hidden.
"""

from typing import Any

import numpy as np

from obs_ros.core.model import Model, Variable

TANK_AREA = 100.0  # cm2
PIPE_AREA = 0.6  # cm2
FLOW_COEFFICIENT = 0.6
GRAVITY = 981.0  # cm/s2

FLOW = FLOW_COEFFICIENT * PIPE_AREA / TANK_AREA  # cm of level per cm of jet
TWICE_GRAVITY = 2.0 * GRAVITY


def dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any, Any]:
    """Level rates in cm/s from levels (cm), feeds (cm3/s) and valve openings (1)."""
    h1, h2, h3 = x
    feed1, feed2 = u
    p1, p2, p3 = p
    q13 = p1 * FLOW * jet_speed(h1 - h3)
    q32 = p3 * FLOW * jet_speed(h3 - h2)
    q20 = p2 * FLOW * jet_speed(h2)
    return feed1 / TANK_AREA - q13, feed2 / TANK_AREA + q32 - q20, q13 - q32


def output(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any]:
    """Return the measured levels h1 and h2 in cm."""
    return x[0], x[1]


def jet_speed(head: Any) -> Any:
    """Speed in cm/s through a valve under `head` cm, signed: Torricelli, odd through zero."""
    return np.copysign(np.sqrt(TWICE_GRAVITY * np.abs(head)), head)


THREE_TANK = Model(
    name='three_tank',
    states=tuple(Variable(name, unit='cm', lower=0.0, upper=100.0) for name in ('h1', 'h2', 'h3')),
    inputs=tuple(Variable(name, unit='cm3/s', nominal=30.0) for name in ('Q1', 'Q2')),
    outputs=tuple(Variable(name, unit='cm') for name in ('h1', 'h2')),
    parameters=tuple(
        Variable(name, lower=0.0, upper=1.0, nominal=1.0, physical='both')
        for name in ('p1', 'p2', 'p3')
    ),
    dynamics=dynamics,
    output=output,
    max_step=1.0,
    reference='Yang, Li & Dahhou 2020, eq. 16',
)
