"""A jet engine's compressor on the stable side: Moore-Greitzer as in Gremling & Passino 2000."""

from typing import Any

from benchmarks.zoo.output import first_state
from obs_ros import Model, Variable


def dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any, Any]:
    """Pressure rise, squared amplitude of rotating stall, mass flow; u is the throttle's flow."""
    pressure, stall, flow = x
    offset, linear, cubic, loss, plenum, growth = p
    rise = offset + linear * flow - cubic * flow * flow * flow - loss * flow * stall
    return (plenum * (flow - u[0]), growth * stall * (1.0 - flow * flow - stall), rise - pressure)


_RANGES = {
    'offset': (1.0, 2.0),
    'linear': (1.2, 1.8),
    'cubic': (0.2, 0.8),
    'loss': (2.0, 4.0),
    'plenum': (0.3, 0.7),
    'growth': (5.0, 9.0),
}
JET = Model(
    name='jet',
    states=(
        Variable('pressure', lower=0.0, upper=4.0),
        Variable('stall', lower=0.0, upper=0.5),
        Variable('flow', lower=0.5, upper=2.0),
    ),
    inputs=(Variable('throttle', interpolation='linear'),),
    outputs=(Variable('pressure'),),
    parameters=tuple(Variable(name, lower=a, upper=b) for name, (a, b) in _RANGES.items()),
    dynamics=dynamics,
    output=first_state,
    max_step=0.02,
    reference='Gremling & Passino 2000, eqs. 17-19',
)
