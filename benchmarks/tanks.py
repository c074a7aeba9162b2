"""Windows of the three tanks with their truth: random ones, and the three of Yang et al. 2020."""

import functools
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from obs_ros import Record
from obs_ros.core.typing import Array
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid
from obs_ros.models.three_tank import THREE_TANK

STATES, PARAMETERS = ('h1', 'h2', 'h3'), ('p1', 'p2', 'p3')
FEED = 30.0  # cm3/s, of both pumps
# Where levels cross, flows change sign through a square root: 1 s steps err by 3e-3 cm there.
TRUE_STEP = 0.01  # s

# A search given the same seed must not draw the numbers that made the truth.
WINDOW_STREAM = 1

# Section 5.1: valve openings of the windows T1, T2, T3 of 1000 s each, one after the other.
PAPER_WINDOWS: Mapping[str, tuple[float, float, float]] = {
    'T1': (1.0, 1.0, 1.0),
    'T2': (0.7, 0.5, 1.0),
    'T3': (0.4, 0.5, 0.5),
}
PAPER_START = (0.0, 0.0, 60.0)  # cm
PAPER_SAMPLES = 1000


@dataclass(frozen=True)
class TankWindow:
    """A record, the true initial levels (cm) and openings by name, and its noise.

    `sigma` (cm) is the standard deviation of the noise, `levels` (K, 3) are the true ones;
    `crossing` tells whether two neighbouring ones change their order inside the window.
    """

    record: Record
    truth: Mapping[str, float]
    sigma: float
    levels: Array
    crossing: bool


def noise_of(snr_db: float) -> float:
    """Return the standard deviation in cm, taking a signal of unit power: none is printed."""
    return float(10.0 ** (-snr_db / 20.0))


def simulated(x0: Array, p: Array, t: Array) -> Array:
    """Return the true levels (K, 3) in cm at times t (K,) in s."""
    model = replace(THREE_TANK, max_step=TRUE_STEP)
    grid = Grid.of(model, blank_record(t), np.ones(2))
    levels, _ = kernels_for(model).trajectories(grid, x0[:, None], p[:, None])
    return levels[:, :, 0]


def blank_record(t: Array, y: Array | None = None) -> Record:
    """Return a record with both pumps running steadily."""
    return Record(t, np.full((t.size, 2), FEED), np.zeros((t.size, 2)) if y is None else y)


def measured(
    t: Array, levels: Array, p: Array, snr_db: float, rng: np.random.Generator
) -> TankWindow:
    """Measure the true levels (K, 3) at times t (K,) in s, of valves p (3,)."""
    sigma = noise_of(snr_db)
    y = levels[:, :2] + sigma * rng.standard_normal((len(levels), 2))
    heads = levels[:, (0, 2)] - levels[:, (2, 1)]
    truth = dict(zip(STATES + PARAMETERS, (*levels[0].tolist(), *p.tolist()), strict=True))
    crossing = bool((np.ptp(np.sign(heads), axis=0) > 0).any())
    return TankWindow(blank_record(t, y), truth, sigma, levels, crossing)


def random_window(
    seed: int,
    samples: int,
    snr_db: float,
    period: float = 1.0,
    openings: tuple[float, float] = (0.2, 1.0),
    levels: tuple[float, float] = (5.0, 95.0),
) -> TankWindow:
    """Draw openings, initial levels (cm) and the noise; samples lie `period` s apart."""
    rng = np.random.default_rng([seed, WINDOW_STREAM])
    p, x0 = rng.uniform(*openings, 3), rng.uniform(*levels, 3)
    t = period * np.arange(float(samples))
    return measured(t, simulated(x0, p, t), p, snr_db, rng)


def paper_window(name: str, snr_db: float, seed: int) -> TankWindow:
    """Return window T1, T2 or T3 with fresh noise; the seed's noise is the same at every SNR."""
    rng = np.random.default_rng([seed, WINDOW_STREAM, list(PAPER_WINDOWS).index(name)])
    levels, p = paper_levels(name), np.array(PAPER_WINDOWS[name])
    return measured(np.arange(float(PAPER_SAMPLES)), levels, p, snr_db, rng)


@functools.cache
def paper_levels(name: str) -> Array:
    """Return the true levels (K, 3) of a window; the next one starts where it ends."""
    before = [other for other in PAPER_WINDOWS if other < name]
    start = np.array(PAPER_START) if not before else paper_end(before[-1])
    return simulated(start, np.array(PAPER_WINDOWS[name]), np.arange(float(PAPER_SAMPLES)))


@functools.cache
def paper_end(name: str) -> Array:
    """Return the true levels (3,) when window `name` ends, 1000 s after its first sample."""
    t = np.array([0.0, 1.0])
    return simulated(paper_levels(name)[-1], np.array(PAPER_WINDOWS[name]), t)[-1]
