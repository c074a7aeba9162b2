"""A quarter car on a magnetorheological damper: Alvarado-Méndez et al. 2024, eq. 32-36.

The road zr and the damper's current I are measured; kt is the tyre's stiffness, and eta a force on
the damper that nobody measures (a disturbance: wear, a shifted load).
"""

import math
from typing import Any

import numpy as np

from obs_ros.core.model import Model, Variable

MS, MUS = 470.0, 110.0  # kg, chassis and wheel
KS = 86378.0  # N/m, spring
KT = 260000.0  # N/m, tyre
A1, A2 = 37.8, 22.15  # s/m, 1/m, hysteresis
B1, B2 = 2830.86, 7897.21  # N s/m, N/m, damper
FC = 600.95  # N/A


def dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any, Any, Any]:
    """Rates from positions (m) and speeds (m/s), road (m), current (A), kt (N/m), eta (N)."""
    zs, vs, zus, vus = x
    zr, current = u
    kt, eta = p
    zd, vd = zs - zus, vs - vus
    force = current * FC * hysteresis(zd, vd) + B1 * vd + B2 * zd + eta  # F_MR, eq. 34
    return (
        vs,
        (-KS * zd - force) / MS,
        vus,
        (KS * zd + force - kt * (zus - zr)) / MUS,
    )


def hysteresis(zd: Any, vd: Any) -> Any:
    """Return rho in [-1, 1] from the damper's deflection (m) and its rate (m/s), eq. 35."""
    return np.tanh(A1 * vd + A2 * zd)


def output(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any, Any]:
    """Return chassis, wheel and damper position zs, zus, zd in m."""
    return x[0], x[2], x[0] - x[2]


# The damper's slope at rest puts a pole near -540 1/s.
SUSPENSION = Model(
    name='suspension',
    states=(
        Variable('zs', 'm', -0.5, 0.5, nominal=0.0),
        Variable('vs', 'm/s', -5.0, 5.0, nominal=0.0),
        Variable('zus', 'm', -0.5, 0.5, nominal=0.0),
        Variable('vus', 'm/s', -5.0, 5.0, nominal=0.0),
    ),
    inputs=(Variable('zr', 'm', nominal=0.0), Variable('I', 'A', lower=0.0, nominal=2.0)),
    outputs=tuple(Variable(name, 'm') for name in ('zs', 'zus', 'zd')),
    parameters=(
        Variable('kt', 'N/m', 0.1 * KT, 3.0 * KT, nominal=KT),
        Variable('eta', 'N', -2000.0, 2000.0, nominal=0.0, walk=math.inf),
    ),
    dynamics=dynamics,
    output=output,
    max_step=1e-3,
    reference='Alvarado-Méndez et al. 2024, eq. 32-36',
)
