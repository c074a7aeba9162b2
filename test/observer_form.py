"""Runs of plants in observer form, as Gremling & Passino 2000 have them."""

from typing import Any

import numpy as np
from plants import rich_input, trajectory

from obs_ros import Sample
from obs_ros.core.typing import Array

T = 0.01
MINIMUM_PHASE = (2.1, 2.1, 1.0, 1.0, 0.9, 0.8)
NON_MINIMUM_PHASE = (2.9, 2.91, 0.959, 0.0, 1.0, -0.05)


def experiment(observer: Any, p: Any, seconds: float = 100.0, sigma: float = 0.0) -> Array:
    """Sums of squared errors of the states, eq. 19."""
    t = T * np.arange(round(seconds / T) + 1)
    x = trajectory(observer.model, t, lambda s: (rich_input(s),), (0.0, 0.0, 0.0), p)
    noise = sigma * np.random.default_rng(0).standard_normal(t.size)
    sums = np.zeros(3)
    for k, now in enumerate(t):
        y = x[k, :1] + noise[k]
        observer.absorb(Sample(round(now * 1e9), u=np.array([rich_input(now)]), y=y))
        sums += (observer.x - x[k]) ** 2
    return sums
