"""The process observer as Zhang et al. 2020 print it: eq. 48 to the letter, forward Euler."""

import math

import numpy as np

from obs_ros.core.typing import Array
from obs_ros.models import heat_exchanger as plant
from plant_sim.scenarios.heat_exchanger import NOMINAL, PRESSURES

THETA = 80.0
SUBSTEPS = 4


def printed_observer(y: Array, period: float) -> Array:
    """Return Fp and Fu (K, 2) from temperatures (K, 2), a `period` (s) apart; NaN once lost.

    x2' has Aa/m c u beside c V, u the pressure of the chamber, and theta^2 hA/(rho cp V) (Tp - Tu)
    as its gain. The stems rest, so that V = 0. From the paper's start: 30 degC and no flow.
    """
    tp = tu = 30.0
    fp = fu = 0.0
    h, found = period / SUBSTEPS, np.full(y.shape, np.nan)
    area = plant.DIAPHRAGM_AREA / plant.STEM_MASS
    push_p = area * float(plant.flow2(NOMINAL[1], 1.0)) * PRESSURES[1]
    push_u = area * float(plant.flow1(NOMINAL[0], 1.0)) * PRESSURES[0]
    for k, (yp, yu) in enumerate(y.tolist()):
        found[k] = fp, fu
        for _ in range(SUBSTEPS):
            ep, eu = tp - yp, tu - yu
            rates = (
                (plant.TPI - tp) / plant.VP * fp + plant.AP * (tu - tp) - 2.0 * THETA * ep,
                (plant.TUI - tu) / plant.VU * fu + plant.AU * (tp - tu) - 2.0 * THETA * eu,
                push_p - THETA**2 * plant.AP * (tp - tu) * ep,
                push_u - THETA**2 * plant.AU * (tu - tp) * eu,
            )
            tp, tu, fp, fu = (
                value + h * rate for value, rate in zip((tp, tu, fp, fu), rates, strict=True)
            )
        if not all(math.isfinite(value) and abs(value) < 1e12 for value in (tp, tu, fp, fu)):
            break
    return found
