"""The terms that models of these plants leave out."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from benchmarks.zoo.heated_cells import ROOM

# Rates (n,) to be added, in those of the states, at states (n,) and parameters (q,).
Rates = Callable[[Sequence[float], Sequence[float]], Sequence[float]]

WARM = 30.0  # K above the room
DENSE = 2.0  # g/l
DOSED = 2.0  # mg
LOADED = 5.0  # A
FAR = 2.0  # m


def convection(x: Sequence[float], p: Sequence[float]) -> Sequence[float]:
    """Return the loss that grows with the excess of temperature; as the model's when WARM."""
    loss, capacity = p[3], (p[4],) * 3 + (p[5],) * 3
    return [-loss * (t - ROOM) ** 2 / WARM / c for t, c in zip(x, capacity, strict=True)]


def inhibition(x: Sequence[float], p: Sequence[float]) -> Sequence[float]:
    """Return the growth that dense substrate prevents; half when DENSE, never more than all."""
    mu_max, ks, yield_ = p
    grown = mu_max * x[1] / (ks + x[1]) * x[0] * x[1] / (DENSE + x[1])
    return [-grown, grown / yield_]


def saturation(x: Sequence[float], p: Sequence[float]) -> Sequence[float]:
    """Return the elimination that saturates; half when DOSED, never more than all."""
    return [p[0] * x[0] * x[0] / (DOSED + x[0]), 0.0, 0.0]


def dry_friction(x: Sequence[float], p: Sequence[float]) -> Sequence[float]:
    """Return the deceleration by dry friction, in the torque of a current LOADED."""
    return [0.0, -p[2] * LOADED * float(np.tanh(x[1])) / (1e-3 * p[3])]


def hardening(x: Sequence[float], p: Sequence[float]) -> Sequence[float]:
    """Return the force of a spring that hardens; as that of the model's when FAR."""
    return [0.0, -p[1] * x[0] * (x[0] / FAR) ** 2]


UNMODELLED: Mapping[str, Rates] = {
    'cells': convection,
    'Monod': inhibition,
    'compartments': saturation,
    'motor': dry_friction,
    'van der Pol': hardening,
}
