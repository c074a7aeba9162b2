"""The gain that an observer really has, from the disturbance to the error of the outputs."""

import numpy as np
from scipy.optimize import minimize_scalar

from obs_ros.core.typing import Array
from obs_ros.observers.papers.design.plants import LipschitzPlant


def peak_gain(plant: LipschitzPlant, L: Array) -> float:
    """Return the largest singular value from eta to C e, over frequency and the slopes of phi.

    The slopes are none and the steepest between each column of B and each row of E.
    """

    def gain(log_frequency: float, f: Array) -> float:
        shifted = 1j * 10.0**log_frequency * np.eye(len(f)) - f
        return float(np.linalg.norm(plant.C @ np.linalg.solve(shifted, plant.N), 2))

    steepest = plant.gamma * np.einsum('il,kj->lkij', plant.B, plant.E).reshape(-1, *plant.A.shape)
    peaks = []
    for slope in (0.0 * plant.A, *steepest, *-steepest):
        f = plant.A - L @ plant.C + slope
        grid = np.linspace(-3.0, 6.0, 1801)
        gains = [gain(w, f) for w in grid]
        best = grid[int(np.argmax(gains))]
        finer = minimize_scalar(lambda w, f=f: -gain(w, f), bounds=(best - 0.01, best + 0.01),
                                method='bounded')  # fmt: skip
        peaks.append(max(max(gains), -float(finer.fun)))
    return max(peaks)
