"""Two real poles in a row, the first state measured: Porter & Passino 1995, eqs. 12-13.

The coefficients a11, a12, a22 are the parameters, so that each can drift. With y = x1 the hidden x2
is seen through a12 only: y is u behind a12 / ((s - a11)(s - a22)).
"""

from typing import Any

from obs_ros.core.model import Model, Variable


def dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any]:
    """Rates in 1/s of both states (1) under the input (1/s)."""
    x1, x2 = x
    a11, a12, a22 = p
    return a11 * x1 + a12 * x2, a22 * x2 + u[0]


def output(t: Any, x: Any, u: Any, p: Any) -> tuple[Any]:
    """Return the measured x1."""
    return (x[0],)


LINEAR_SECOND_ORDER = Model(
    name='linear_second_order',
    states=tuple(Variable(name, lower=-5.0, upper=5.0, nominal=0.0) for name in ('x1', 'x2')),
    inputs=(Variable('u', unit='1/s', lower=-10.0, upper=10.0, nominal=1.0),),
    outputs=(Variable('x1', lower=-5.0, upper=5.0, nominal=0.0),),
    parameters=(
        # The ranges of a11 and a22 do not meet: swapped poles would give the same y.
        Variable('a11', unit='1/s', lower=-3.5, upper=-1.0, nominal=-2.25),
        Variable('a12', unit='1/s', lower=-7.0, upper=-2.0, nominal=-4.5),
        Variable('a22', unit='1/s', lower=-8.0, upper=-4.0, nominal=-5.5),
    ),
    dynamics=dynamics,
    output=output,
    max_step=0.05,
    reference='Porter & Passino 1995, eqs. 12-13',
)
