"""Gains of adaptive observers, by model: what the design found and what the paper prints."""

from collections.abc import Mapping
from dataclasses import dataclass

from obs_ros.observers.papers.design import suspension_gains

Matrix = tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class AdaptiveGains:
    """x' = A x + Psi + B phi2(x, u) theta, y = C x, with theta the `parameter`.

    L (n, r) and H (r,), by the gains' origin; B (n,) in the same order of states.
    """

    parameter: str
    B: tuple[float, ...]
    L: Mapping[str, Matrix]
    H: Mapping[str, tuple[float, ...]]


GAINS = {
    'suspension': AdaptiveGains(
        parameter='kt',
        B=(0.0, 0.0, 0.0, 1.0),
        L={
            'designed': suspension_gains.L,
            # The print has lost its minus signs; these make A - L C stable.
            'printed': (
                (0.9627, 0.9677, -0.0050),
                (1.3959, -1.0688, 2.4647),
                (0.6003, 0.5931, 0.0072),
                (-1.0688, 1.3799, -2.4487),
            ),
        },
        H={'designed': suspension_gains.H, 'printed': (0.3696, 0.3708, -0.0012)},
    ),
}
