"""A run of an observer as the benchmarks of papers judge it."""

import numpy as np

from benchmarks.papers.observed import Outcome

GOOD = Outcome(
    rms=np.array([0.01, 0.02, 0.02]),
    size=np.array([1.0, 1.0, 1.0]),
    squares=np.array([1.0, 4400.0, 2100.0]),
    settled=2.0,
    resets=0,
    largest=np.array([0.1, 3.0, 3.0]),
    onset=0.0,
)
