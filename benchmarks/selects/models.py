"""Plants whose functions choose, each beside a like one that does not: dry friction, overflows."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from obs_ros import Model, Variable
from obs_ros.models import three_tank
from obs_ros.models.three_tank import THREE_TANK

Choice = Callable[[Any], Any]

MASS = 0.7  # kg
BRIM = 60.0  # cm
SPILL = 0.02  # 1/s, of the height above the brim

FRICTIONS: dict[str, Choice] = {
    'np.sign': lambda v: np.sign(v),
    'np.where': lambda v: np.where(v > 0, 1.0, np.where(v < 0, -1.0, 0.0)),
    'np.clip': lambda v: np.clip(50.0 * v, -1.0, 1.0),
    'comparisons': lambda v: 1.0 * (v > 0) - 1.0 * (v < 0),
}
OVERFLOWS: dict[str, Choice] = {
    'np.where': lambda h: np.where(h > BRIM, h - BRIM, 0.0),
    'np.clip': lambda h: np.clip(h - BRIM, 0, None),
    'np.maximum': lambda h: np.maximum(h - BRIM, 0),
    'np.minimum': lambda h: h - np.minimum(h, BRIM),
    'np.heaviside': lambda h: (h - BRIM) * np.heaviside(h - BRIM, 0.0),
    'comparison': lambda h: (h > BRIM) * (h - BRIM),
    'logical_and': lambda h: np.logical_and(h > BRIM, h < 1e3) * (h - BRIM),
    '&': lambda h: ((h > BRIM) & (h < 1e3)) * (h - BRIM),
}


def spring(friction: Choice) -> Model:
    """A mass on a spring, with viscous and dry friction; its position is measured."""

    def dynamics(t: Any, x: Any, u: Any, p: Any) -> Any:
        position, speed = x
        stiffness, viscous, dry = p
        force = u[0] - stiffness * position - viscous * speed - dry * friction(speed)
        return speed, force / MASS

    return Model(
        name='spring',
        states=(Variable('position', 'm', -2, 2), Variable('speed', 'm/s', -3, 3)),
        inputs=(Variable('force', 'N', nominal=0.0),),
        outputs=(Variable('position', 'm'),),
        parameters=(
            Variable('stiffness', 'N/m', 1, 5),
            Variable('viscous', 'N s/m', 0, 1),
            Variable('dry', 'N', 0, 1),
        ),
        dynamics=dynamics,
        output=lambda t, x, u, p: (x[0],),
        max_step=0.02,
    )


def tanks(overflow: Choice) -> Model:
    """Three tanks that lose the water above their brims."""

    def dynamics(t: Any, x: Any, u: Any, p: Any) -> Any:
        rates = three_tank.dynamics(t, x, u, p)
        return (
            rates[0] - SPILL * overflow(x[0]),
            rates[1] - SPILL * overflow(x[1]),
            rates[2] - SPILL * overflow(x[2]),
        )

    return replace(THREE_TANK, name='overflowing_tanks', dynamics=dynamics)


# By plant: the like one without a choice, and those that choose.
PLANTS: dict[str, tuple[Model, dict[str, Model]]] = {
    'spring': (
        spring(lambda v: v),
        {name: spring(friction) for name, friction in FRICTIONS.items()},
    ),
    'tanks': (
        tanks(lambda h: h - BRIM),
        {name: tanks(overflow) for name, overflow in OVERFLOWS.items()},
    ),
}
