"""A drug in three compartments; the amount in the central one is measured.

Two peripheral compartments exchange with the central one, which alone eliminates: Godfrey 1983.
The boxes of k21 and k31 tell the two apart.
"""

from typing import Any

from benchmarks.zoo.output import first_state
from obs_ros import Model, Variable


def dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any, Any]:
    """Return the rates of the amounts (mg/h) under the infusion u (mg/h)."""
    central, shallow, deep = x
    k10, k12, k21, k13, k31 = p
    to_shallow, to_deep = k12 * central - k21 * shallow, k13 * central - k31 * deep
    return u[0] - k10 * central - to_shallow - to_deep, to_shallow, to_deep


COMPARTMENTS = Model(
    name='compartments',
    states=tuple(
        Variable(name, 'mg', lower=0.0, upper=300.0) for name in ('central', 'shallow', 'deep')
    ),
    inputs=(Variable('infusion', 'mg/h'),),
    outputs=(Variable('central', 'mg'),),
    parameters=(
        Variable('k10', '1/h', lower=0.02, upper=2.0),
        Variable('k12', '1/h', lower=0.02, upper=3.0),
        Variable('k21', '1/h', lower=0.15, upper=3.0),
        Variable('k13', '1/h', lower=0.02, upper=1.0),
        Variable('k31', '1/h', lower=0.005, upper=0.15),
    ),
    dynamics=dynamics,
    output=first_state,
    max_step=0.1,
    reference='Godfrey 1983',
)
