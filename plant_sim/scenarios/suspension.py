"""A car over two bumps while its damper fails: Alvarado-Méndez et al. 2024, section 5.

The paper shows road and disturbance in pictures only. Taken here: bumps at 10-13 s and 20-23 s of
three shapes, and a force on the damper that rises to 300 N, 15 % of its range, from 8 to 12 s.
"""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from obs_ros.models.suspension import KT
from plant_sim.scenario import Scenario
from plant_sim.signals import Schedule, Signal

BUMPS = (10.0, 20.0)  # s
LENGTH = 3.0  # s
EDGE = 0.2  # s, of a trapezoid
CURRENT = 2.0  # A
FORCE, RISE = 300.0, (8.0, 12.0)  # N, s
STAIR = 0.01  # s, from one step of the rising force to the next
NOISE = 1e-4  # m


def trapezoid(s: float) -> float:
    """Height in m, s seconds into a bump."""
    return float(np.interp(s, (0.0, EDGE, LENGTH - EDGE, LENGTH), (0.0, 0.05, 0.05, 0.0)))


def raised_cosine(s: float) -> float:
    """Height in m, s seconds into a bump."""
    return 0.05 * (1.0 - math.cos(2.0 * math.pi * s / LENGTH)) if 0.0 <= s <= LENGTH else 0.0


def rectangle(s: float) -> float:
    """Height in m, s seconds into a bump."""
    return 0.05 if 0.0 <= s < LENGTH else 0.0


def road(bump: Callable[[float], float]) -> Signal:
    """Return zr (m), flat but for the bumps, and the damper's current (A)."""
    return lambda t: (sum(bump(t - start) for start in BUMPS), CURRENT)


def damage(kt: tuple[float, ...] = (KT,), at: tuple[float, ...] = (0.0,)) -> Schedule:
    """Return kt (N/m), with its values from the times `at` (s) on, and the rising force eta (N)."""
    rising = np.arange(RISE[0], RISE[1] + 0.5 * STAIR, STAIR).round(9)
    times = np.union1d(at, rising)
    rows = [
        (kt[int(np.searchsorted(at, t, side='right')) - 1], float(np.interp(t, RISE, (0.0, FORCE))))
        for t in times
    ]
    return Schedule(tuple(times), tuple(rows))


TRAPEZOIDS = Scenario(
    name='suspension_trap',
    model='suspension',
    initial_state=(0.0, 0.0, 0.0, 0.0),
    inputs=road(trapezoid),
    parameters=damage(),
    sample_period=1e-3,
    duration=65.0,
    snr_db=-20.0 * math.log10(NOISE),
    reference='Alvarado-Méndez et al. 2024, section 5',
)
COSINES = replace(TRAPEZOIDS, name='suspension_cos', inputs=road(raised_cosine))
RECTANGLES = replace(TRAPEZOIDS, name='suspension_rect', inputs=road(rectangle))

# Between the bumps the tyre loses a fifth of its stiffness.
SOFT_TYRE = replace(
    TRAPEZOIDS,
    name='suspension_kt_step',
    parameters=damage(kt=(KT, 0.8 * KT), at=(0.0, 15.0)),
    reference='after Alvarado-Méndez et al. 2024, with a tyre that softens',
)
