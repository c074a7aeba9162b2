"""Linear parts of plants, as the design of gains wants them."""

from dataclasses import dataclass

import numpy as np

from obs_ros.core.typing import Array
from obs_ros.models.suspension import B1, B2, KS, KT, MS, MUS


@dataclass(frozen=True, eq=False)
class LipschitzPlant:
    """x' = A x + B phi(x) + N eta, y = C x, with |phi(x) - phi(z)| <= gamma |E (x - z)|.

    A (n, n), B (n, l), C (r, n), N (n, m), E (k, n); gamma in the unit of phi per unit of E x.
    `scale` (n,) is the size that each state typically has and `disturbance` that of eta: the
    solver works in these units, for it fails where numbers lie six powers of ten apart.
    """

    A: Array
    B: Array
    C: Array
    N: Array
    E: Array
    gamma: float
    scale: Array
    disturbance: float


POSITIONS = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [1.0, 0.0, -1.0, 0.0]])
WHEEL_SPEED = np.array([[0.0, 0.0, 0.0, 1.0]])


def suspension(*, share: float | None = 0.2, wheel_speed: bool = False) -> LipschitzPlant:
    """Return the suspension, eq. 37-38, with phi = kt (zr - zus) / mus.

    With a `share`, A has the nominal kt in it and phi keeps only what kt may be off by, that share
    of it. Without, all of kt is in phi, as in the paper: gamma = kt / mus (the print drops kt).
    `wheel_speed` adds a fourth output, vus.

    The damper's hysteresis is left out, as in the paper, whose Psi must not depend on hidden
    states though it does.
    """
    stiff, tyre = KS + B2, 0.0 if share is None else KT
    a = np.array(
        [
            [0.0, 1.0, 0.0, 0.0],
            [-stiff / MS, -B1 / MS, stiff / MS, B1 / MS],
            [0.0, 0.0, 0.0, 1.0],
            [stiff / MUS, B1 / MUS, -(stiff + tyre) / MUS, -B1 / MUS],
        ]
    )
    return LipschitzPlant(
        A=a,
        B=np.array([[0.0], [0.0], [0.0], [1.0]]),
        C=np.vstack([POSITIONS, WHEEL_SPEED]) if wheel_speed else POSITIONS,
        N=np.array([[0.0], [-1.0 / MS], [0.0], [1.0 / MUS]]),
        E=np.array([[0.0, 0.0, 1.0, 0.0]]),
        gamma=(1.0 if share is None else share) * KT / MUS,
        scale=np.array([1.0, 20.0, 1.0, 40.0]),
        disturbance=1e5,
    )
