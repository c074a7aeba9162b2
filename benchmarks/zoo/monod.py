"""A stirred bioreactor that grows by Monod's law; its biomass is measured: Monod 1949."""

from typing import Any

from benchmarks.zoo.output import first_state
from obs_ros import Model, Variable

FEED = 10.0  # g/l of substrate in the inflow


def dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any]:
    """Return the rates of biomass and substrate (g/l/h) under the dilution rate u (1/h)."""
    biomass, substrate = x
    mu_max, ks, yield_ = p
    grown = mu_max * substrate / (ks + substrate) * biomass
    return grown - u[0] * biomass, u[0] * (FEED - substrate) - grown / yield_


MONOD = Model(
    name='monod',
    states=(
        Variable('biomass', 'g/l', lower=0.01, upper=10.0),
        Variable('substrate', 'g/l', lower=0.0, upper=10.0),
    ),
    inputs=(Variable('dilution', '1/h'),),
    outputs=(Variable('biomass', 'g/l'),),
    parameters=(
        Variable('mu_max', '1/h', lower=0.05, upper=1.5),
        Variable('ks', 'g/l', lower=0.05, upper=5.0),
        Variable('yield_', lower=0.1, upper=1.0),
    ),
    dynamics=dynamics,
    output=first_state,
    max_step=0.025,
    reference='Monod 1949',
)
