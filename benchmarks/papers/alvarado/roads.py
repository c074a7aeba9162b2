"""Drives over bumps, as Alvarado-Méndez et al. 2024 describe them, and their truth."""

import functools
import math
from typing import NamedTuple

import numpy as np

from benchmarks.play import columns, played
from obs_ros.core.typing import Array
from plant_sim.scenarios import load_scenario
from plant_sim.scenarios.suspension import BUMPS

LONG = 65.0  # s, the paper's simulation


class Case(NamedTuple):
    """A drive: its road, force on the damper (N) from 12 s on, noise (m), begin, end (s).

    Errors count from `counted` s on.
    """

    scenario: str
    force: float
    noise: float
    begin: float
    end: float
    counted: float

    @property
    def label(self) -> str:
        """Return the case in words."""
        road = self.scenario.removeprefix('suspension_')
        return f'{road}, eta {self.force:g} N, {1e3 * self.noise:g} mm'


class Truth(NamedTuple):
    """Times (K,), inputs (K, 2), positions without noise (K, 3), states (K, 4), kt and eta (K,)."""

    t: Array
    u: Array
    y: Array
    x: Array
    kt: Array
    eta: Array


# The first bump, from before the force rises: begin, end and what counts of it, in s.
SPAN = (7.0, 12.5, BUMPS[0] + 1.5)
TRAPEZOID = Case('suspension_trap', 300.0, 1e-4, *SPAN)
COSINE = Case('suspension_cos', 0.0, 1e-3, *SPAN)
# The tyre softens at 15 s, which shows on the second bump.
SOFTENING = Case('suspension_kt_step', 300.0, 1e-4, 7.0, 22.5, BUMPS[1] + 1.5)
CASES = (TRAPEZOID, COSINE, SOFTENING)


@functools.cache
def truth_of(scenario: str, disturbed: bool, begin: float, end: float) -> Truth:
    """Return a drive without noise; the plant is integrated to 1e-8 m."""
    period = load_scenario(scenario).sample_period
    faults = {} if disturbed else {'eta': 0.0}
    rows = played(scenario, round(end / period) + 1, faults=faults, snr_db=math.inf)
    t, u, y, x, p = columns(rows[round(begin / period) :], 'tuyxp')
    return Truth(t, u, y, x, p[:, 0], p[:, 1])


def noisy(case: Case, truth: Truth, seed: int) -> Array:
    """Return the positions (K, 3) as they are measured."""
    rng = np.random.default_rng(seed)
    return truth.y + case.noise * rng.standard_normal(truth.y.shape)
