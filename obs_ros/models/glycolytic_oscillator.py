"""A glycolytic oscillator under a feed, its substrate measured: Porter & Passino 1995, eq. 17.

The substrate x1 is turned into the product x2, which speeds its own making. Two rates are
parameters: that at which substrate is used up, a, and that at which product is removed, d; both are
1 in the paper, and a = 0.8 is the plant of its model mismatch. The rate of making stays 1: with
y = x1 alone, it would only rescale x2.

Without product none is made: x2 = 0 stays 0, and there x1 does not depend on x2 to first order.
"""

from typing import Any

from obs_ros.core.model import Model, Variable


def dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any]:
    """Rates in 1/s of substrate and product (1) under the feed (1/s)."""
    x1, x2 = x
    a, d = p
    turnover = x1 * x2 * x2
    return u[0] - a * turnover, turnover - d * x2


def output(t: Any, x: Any, u: Any, p: Any) -> tuple[Any]:
    """Return the measured substrate x1."""
    return (x[0],)


GLYCOLYTIC_OSCILLATOR = Model(
    name='glycolytic_oscillator',
    states=tuple(Variable(name, lower=0.0, upper=5.0, nominal=0.0) for name in ('x1', 'x2')),
    inputs=(Variable('u', unit='1/s', lower=-5.0, upper=5.0, nominal=1.0),),
    outputs=(Variable('x1', lower=0.0, upper=5.0, nominal=0.0),),
    parameters=(
        Variable('a', unit='1/s', lower=0.5, upper=1.5, nominal=1.0),
        Variable('d', unit='1/s', lower=0.5, upper=1.5, nominal=1.0),
    ),
    dynamics=dynamics,
    output=output,
    max_step=0.02,
    reference='Porter & Passino 1995, eq. 17',
)
