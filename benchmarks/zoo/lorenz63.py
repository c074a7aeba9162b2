"""Lorenz's convection: Lorenz 1963, eqs. 25-27; only x is measured."""

from typing import Any

from benchmarks.zoo.output import first_state
from obs_ros import Model, Variable


def dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any, Any]:
    """Rates of convection x, y and stratification z."""
    a, b, c = x
    sigma, rho, beta = p
    return sigma * (b - a), a * (rho - c) - b, a * b - beta * c


LORENZ63 = Model(
    name='lorenz63',
    states=(
        Variable('x', lower=-25.0, upper=25.0),
        Variable('y', lower=-30.0, upper=30.0),
        Variable('z', lower=0.0, upper=50.0),
    ),
    outputs=(Variable('x'),),
    parameters=(
        Variable('sigma', lower=5.0, upper=15.0, nominal=10.0),
        Variable('rho', lower=20.0, upper=35.0, nominal=28.0),
        Variable('beta', lower=1.0, upper=4.0, nominal=8.0 / 3.0),
    ),
    dynamics=dynamics,
    output=first_state,
    max_step=0.01,
    reference='Lorenz 1963, eqs. 25-27',
)
