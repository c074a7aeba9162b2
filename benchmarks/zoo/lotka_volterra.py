"""Prey and predators: Lotka 1925, Volterra 1926; only the prey is counted.

The predators' unit is their appetite, which prey alone cannot tell.
"""

from typing import Any

from benchmarks.zoo.output import first_state
from obs_ros import Model, Variable


def dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any]:
    """Growth of prey and predators per year."""
    prey, predators = x
    birth, growth, death = p
    return birth * prey - prey * predators, growth * prey * predators - death * predators


LOTKA_VOLTERRA = Model(
    name='lotka_volterra',
    states=(Variable('prey', lower=0.1, upper=5.0), Variable('predators', lower=0.1, upper=5.0)),
    outputs=(Variable('prey'),),
    parameters=(
        Variable('birth', unit='1/s', lower=0.3, upper=2.0, nominal=1.0),
        Variable('growth', unit='1/s', lower=0.3, upper=2.0, nominal=1.0),
        Variable('death', unit='1/s', lower=0.3, upper=2.0, nominal=1.0),
    ),
    dynamics=dynamics,
    output=first_state,
    max_step=0.05,
    reference='Volterra 1926',
)
