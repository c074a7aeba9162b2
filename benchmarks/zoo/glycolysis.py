"""A glycolytic oscillator fed periodically; the substrate is measured: Porter & Passino 1995."""

from typing import Any

from benchmarks.zoo.output import first_state
from obs_ros import Model, Variable


def dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any]:
    """Substrate and product, each turned over at a rate."""
    substrate, product = x
    conversion, removal = p
    turned = conversion * substrate * product * product
    return u[0] - turned, turned - removal * product


GLYCOLYSIS = Model(
    name='glycolysis',
    states=(Variable('substrate', lower=0.1, upper=3.0), Variable('product', lower=0.1, upper=3.0)),
    inputs=(Variable('feed', unit='1/s', interpolation='linear'),),
    outputs=(Variable('substrate'),),
    parameters=(
        Variable('conversion', unit='1/s', lower=0.5, upper=2.0, nominal=1.0),
        Variable('removal', unit='1/s', lower=0.5, upper=2.0, nominal=1.0),
    ),
    dynamics=dynamics,
    output=first_state,
    max_step=0.05,
    reference='Porter & Passino 1995',
)
