"""Stiff plants that are followed sample by sample, none with a longest step."""

from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from obs_ros import Model, Variable
from obs_ros.core.typing import Array

# A DC motor: current and speed, L / R = 1e-4 s, a mechanical time constant of 40 ms.
MOTOR = Model(
    name='stiff_motor',
    states=(Variable('i', 'A', -100.0, 100.0), Variable('w', 'rad/s', -1000.0, 1000.0)),
    inputs=(Variable('v', 'V', -50.0, 50.0),),
    outputs=(Variable('w_measured', 'rad/s'),),
    parameters=(Variable('k', 'V s', 0.01, 0.2, nominal=0.05),),
    dynamics=lambda t, x, u, p: (
        1e4 * (u[0] - x[0] - p[0] * x[1]),
        1e4 * p[0] * x[0] - x[1],
    ),
    output=lambda t, x, u, p: (x[1],),
)


def van_der_pol(mu: float) -> Model:
    """x'' = mu (1 - x^2) x' - x: slow, but for jumps within 1 / mu s."""
    return Model(
        name='van_der_pol',
        states=(Variable('x', lower=-3.0, upper=3.0), Variable('v', '1/s', -2.0 * mu, 2.0 * mu)),
        outputs=(Variable('y'),),
        parameters=(Variable('mu', '1/s', 0.5 * mu, 2.0 * mu, nominal=mu),),
        dynamics=lambda t, x, u, p: (x[1], p[0] * (1.0 - x[0] * x[0]) * x[1] - x[0]),
        output=lambda t, x, u, p: (x[0],),
    )


def chain(count: int) -> Model:
    """Bodies in a row, heated at one end, with rates from 1e-4 to 1e2 1/s."""
    rates = np.logspace(-4.0, 2.0, count).tolist()

    def dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, ...]:
        row = (u[0], *x, p[0])
        return tuple(
            rate * (row[i] - 2.0 * row[i + 1] + row[i + 2]) for i, rate in enumerate(rates)
        )

    return Model(
        name=f'chain_{count}',
        states=tuple(Variable(f'T{i}', 'K', 0.0, 100.0, nominal=20.0) for i in range(count)),
        inputs=(Variable('heater', 'K', 0.0, 100.0, nominal=60.0),),
        outputs=(Variable('first', 'K'), Variable('last', 'K')),
        parameters=(Variable('ambient', 'K', 0.0, 50.0, nominal=20.0),),
        dynamics=dynamics,
        output=lambda t, x, u, p: (x[0], x[-1]),
    )


def by_radau(model: Model, t0: float, t1: float, x: Array, u: Array, p: Array) -> Array:
    """States (n,) at t1 from x (n,) at t0, by SciPy's Radau at rtol 1e-10; u (m,) is held."""
    width = np.array([v.upper - v.lower for v in model.states])
    found = solve_ivp(
        lambda t, x: model.dynamics(t, tuple(x), tuple(u), tuple(p)), (t0, t1), x, 'Radau',
        rtol=1e-10, atol=1e-14 * width,
    )  # fmt: skip
    return np.asarray(found.y[:, -1])
