"""A spring whose friction is any function of its speed, and the functions, in Python and in C."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from obs_ros import Model, Variable
from obs_ros.core.model import Integrator

MASS = 0.7  # kg
STEP = 0.02  # s
TABLE = np.array([-2.0, -1.0, 0.0, 1.0, 2.0]), np.array([-1.0, -0.5, 0.0, 0.6, 1.0])


class Function(NamedTuple):
    """A friction of the speed v, the same in C, and how many plain steps a step may take."""

    python: Callable[[Any], Any]
    c: str
    limit: float = np.inf


PLAIN = Function(lambda v: v, 'v')
FUNCTIONS: dict[str, Function] = {
    'where': Function(lambda v: np.where(v > 0, 1.0, -1.0), 'v > 0 ? 1.0 : -1.0', 1.3),
    'clip': Function(lambda v: np.clip(v, -1, 1), 'fmin(fmax(v, -1.0), 1.0)', 1.3),
    'sign': Function(lambda v: np.sign(v), '(v > 0) - (v < 0)', 1.3),
    'minimum': Function(lambda v: np.minimum(v, 0.5), 'v < 0.5 ? v : 0.5', 1.3),
    'heaviside': Function(lambda v: np.heaviside(v, 0.5), 'v > 0 ? 1.0 : (v < 0 ? 0.0 : 0.5)'),
    'select': Function(
        lambda v: np.select([v < -1, v > 1], [-1.0, 1.0], v), 'v < -1 ? -1.0 : (v > 1 ? 1.0 : v)'
    ),
    'comparisons': Function(lambda v: 1.0 * (v > 0) - 1.0 * (v < 0), '1.0*(v > 0) - 1.0*(v < 0)'),
    'and, or': Function(
        lambda v: v if (v > 0 and v < 1) or v < -1 else 0.5 * v,
        '(v > 0 && v < 1) || v < -1 ? v : 0.5 * v',
    ),
    'interp': Function(lambda v: np.interp(v, *TABLE), 'interp(v)', 3.0),
    'exp': Function(lambda v: np.exp(v), 'exp(v)', 2.0),
    'expm1': Function(lambda v: np.expm1(v), 'expm1(v)'),
    'log': Function(lambda v: np.log(v * v + 1.0), 'log(v * v + 1.0)'),
    'log1p': Function(lambda v: np.log1p(v * v), 'log1p(v * v)'),
    'sin': Function(lambda v: np.sin(v), 'sin(v)', 2.0),
    'cos': Function(lambda v: np.cos(v), 'cos(v)', 2.0),
    'tan': Function(lambda v: np.tan(0.1 * v), 'tan(0.1 * v)'),
    'arctan': Function(lambda v: np.arctan(v), 'atan(v)'),
    'arctan2': Function(lambda v: np.arctan2(v, 1.0 + v * v), 'atan2(v, 1.0 + v * v)', 2.0),
    'tanh': Function(lambda v: np.tanh(v), 'tanh(v)', 2.0),
    'sqrt': Function(lambda v: np.sqrt(v * v + 1.0), 'sqrt(v * v + 1.0)'),
    'hypot': Function(lambda v: np.hypot(v, 1.0), 'hypot(v, 1.0)'),
    '** 3': Function(lambda v: v**3, 'v * v * v'),
    '** 1.5': Function(lambda v: (v * v + 1.0) ** 1.5, 'pow(v * v + 1.0, 1.5)'),
    'power': Function(
        lambda v: np.power(v * v + 1.0, 0.3 + 0.1 * v), 'pow(v*v + 1.0, 0.3 + 0.1*v)', 2.0
    ),
}


def spring(friction: Callable[[Any], Any], method: Integrator = 'rk4') -> Model:
    """A mass on a spring, with viscous and another friction; its position is measured."""

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
        max_step=STEP,
        integrator=method,
    )
