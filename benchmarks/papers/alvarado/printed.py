"""The observer as Alvarado-Méndez et al. 2024 print it: eq. 4 and 41, forward Euler of 1 ms.

Written from the equations alone, without the package's observer, and without bounds.
"""

import functools
import itertools
import math
from typing import NamedTuple

import numpy as np

from benchmarks.papers.alvarado.roads import Truth
from obs_ros.core.typing import Array
from obs_ros.models.suspension import A1, A2, B1, B2, FC, KS, KT, MS, MUS
from obs_ros.observers.papers.design.peak_gain import peak_gain
from obs_ros.observers.papers.design.plants import suspension

# The matrices of section 5, whose minus signs the print has lost.
MAGNITUDES = np.array([
    [0.9627, 0.9677, 0.0050], [1.3959, 1.0688, 2.4647],
    [0.6003, 0.5931, 0.0072], [1.0688, 1.3799, 2.4487],
])  # fmt: skip
GAMMA = 125.0
RIGHT_START, PAPERS_START = 0.0, 0.1  # xhat(0), each state


class Printed(NamedTuple):
    """Estimates of the states (K, 4) and of kt (K,) in N/m."""

    x: Array
    kt: Array


def printed_observer(
    truth: Truth, L: Array, H: Array, *, start: float, kt: float, scale: float, adapts: bool = True
) -> Printed:
    """Observe noise-free outputs from xhat(0) = `start` and `kt` (N/m); theta = `scale` q.

    With `adapts` false kt is known and stays. What is not finite any more stays NaN.
    """
    h = float(truth.t[1] - truth.t[0])
    zs = vs = zus = vus = start
    found, stiffness = np.full((truth.t.size, 4), np.nan), np.full(truth.t.size, np.nan)
    rows = L.tolist()
    factor = h * GAMMA * scale**2 if adapts else 0.0
    for k, ((zr, current), y) in enumerate(zip(truth.u.tolist(), truth.y.tolist(), strict=True)):
        found[k], stiffness[k] = (zs, vs, zus, vus), kt
        if not abs(kt) < 1e12 or not abs(zs) < 1e12:
            break
        zd, vd, phi = zs - zus, vs - vus, (zr - zus) / MUS
        e = y[0] - zs, y[1] - zus, y[2] - zd
        force = current * FC * math.tanh(A1 * vd + A2 * zd) + B1 * vd + B2 * zd
        rates = vs, -(KS * zd + force) / MS, vus, (KS * zd + force) / MUS + phi * kt
        pulls = [row[0] * e[0] + row[1] * e[1] + row[2] * e[2] for row in rows]
        kt += factor * phi * (H[0] * e[0] + H[1] * e[1] + H[2] * e[2])
        zs, vs, zus, vus = (
            value + h * (rate + pull)
            for value, rate, pull in zip((zs, vs, zus, vus), rates, pulls, strict=True)
        )
    return Printed(found, stiffness)


class Signs(NamedTuple):
    """A choice of the signs of L (4, 3): its slowest pole (1/s) and its peak gain (m/N).

    The pole is of A - L C as the paper has A, without kt; the gain with kt within +-20 %.
    """

    L: Array
    pole: float
    peak: float

    @property
    def stable(self) -> bool:
        """Whether A - L C is."""
        return self.pole < 0.0


@functools.cache
def sign_choices() -> tuple[Signs, ...]:
    """Return the sixteen choices of a sign for each row of L, the stable ones first, by their gain.

    Within a row the third number is, to the last digit printed, the first less the second: so it is
    with C, whose third row is the first less the second, and so the signs within a row are known.
    """
    rows = [row_with_signs(row) for row in MAGNITUDES]
    plant, found = suspension(), []
    for signs in itertools.product((1.0, -1.0), repeat=4):
        L = np.array(signs)[:, None] * np.array(rows)
        pole = slowest_pole(L)
        found.append(Signs(L, pole, peak_gain(plant, L) if pole < 0.0 else math.inf))
    return tuple(sorted(found, key=lambda one: (one.peak, one.pole)))


def slowest_pole(L: Array) -> float:
    """Return the largest real part (1/s) of the poles of A - L C, with the A of eq. 37."""
    plant = suspension(share=None)
    return float(np.linalg.eigvals(plant.A - L @ plant.C).real.max())


def row_with_signs(row: Array) -> Array:
    """Return a row (3,) with signs such that its third is the first less the second.

    The first is positive. Raises ValueError where no signs do that to 1.5 units of the last digit.
    """
    for signs in itertools.product((1.0, -1.0), repeat=2):
        signed = row * (1.0, *signs)
        if abs(signed[0] - signed[1] - signed[2]) < 1.5e-4:
            return np.asarray(signed)
    raise ValueError(f'print these numbers otherwise: none is the difference of the rest: {row}')


def least_freedom() -> float:
    """Return |C B|: where it is 0, B'P = HC forces B'PB = H C B = 0, and P > 0 cannot be."""
    plant = suspension(share=None)
    return float(np.linalg.norm(plant.C @ plant.B))


def lipschitz() -> tuple[float, float]:
    """Return the slope |d phi4 / d x3| of eq. 39 at the true kt (1/s2), and that of eq. 40."""
    step = 1e-6
    slope = ((0.0 - step) / MUS * KT - (0.0 + step) / MUS * KT) / (2.0 * step)
    return abs(slope), 1.0 / MUS


def hidden_in_psi() -> float:
    """Return the share of the argument of rho, a1 vd + a2 zd, that the outputs do not tell."""
    C = suspension().C
    wanted = np.array([A2, A1, -A2, -A1])
    return float(np.linalg.norm(wanted - wanted @ np.linalg.pinv(C) @ C) / np.linalg.norm(wanted))
