"""Three tanks whose levels cross, at 60 dB: at equal levels the flow's slope is infinite."""

from typing import NamedTuple

import numpy as np

from benchmarks.integrators.reference import states
from benchmarks.integrators.run import FINE
from obs_ros import Record, load_model, solve_window
from obs_ros.core.typing import Array

NOISE = 0.01  # cm
SAMPLES, PERIOD = 60, 1.0  # s
FEEDS = 30.0, 30.0  # cm3/s
PARAMETER = 'p1'


class Kinked(NamedTuple):
    """A window whose first and third level cross: error and interval of p1."""

    outcome: str
    truth: float
    value: float
    interval: tuple[float, float]

    @property
    def given(self) -> bool:
        """Whether an interval was given."""
        return bool(np.isfinite(self.interval).all())

    @property
    def covered(self) -> bool:
        """Whether it holds the truth."""
        return self.interval[0] <= self.truth <= self.interval[1]


def crossing(seed: int) -> tuple[Record, Array]:
    """Return a window in which the levels cross, and its truth: levels (3,), openings (3,)."""
    rng = np.random.default_rng([seed, 60])
    model, t = load_model('three_tank'), PERIOD * np.arange(float(SAMPLES))
    u = np.tile(FEEDS, (SAMPLES, 1))
    while True:
        p, middle = rng.uniform(0.2, 1.0, 3), rng.uniform(20.0, 60.0)
        x0 = middle + np.array([rng.uniform(1.0, 8.0), rng.uniform(-15.0, 15.0), 0.0])
        x0[:2] = x0[:2] if rng.random() < 0.5 else 2.0 * middle - x0[:2]
        levels = states(model, t, u, x0, p, rtol=FINE)
        heads = levels[:, 0] - levels[:, 2]
        if levels.min() > 1.0 and np.ptp(np.sign(heads)) > 0.0:
            y = levels[:, :2] + NOISE * rng.standard_normal((SAMPLES, 2))
            return Record(t, u, y), np.concatenate([x0, p])


def solved(seed: int) -> Kinked:
    """Solve the window of a seed."""
    record, truth = crossing(seed)
    noise = dict.fromkeys(('h1', 'h2'), NOISE)
    estimate = solve_window('three_tank', record, seed=seed, noise=noise, process_noise='off')
    p1 = float(truth[3])
    interval = estimate.interval.get(PARAMETER, (np.nan, np.nan))
    return Kinked(str(estimate.outcome.value), p1, estimate.parameters[PARAMETER], interval)
