"""Scenarios played once: the truth against which the papers' observers are held."""

import functools
from typing import NamedTuple

import numpy as np

from benchmarks.play import columns, played
from obs_ros.core.typing import Array
from plant_sim.scenarios import load_scenario
from plant_sim.sources import WhiteGaussian

PERIOD = 0.01  # s


class Truth(NamedTuple):
    """A scenario's truth: times t (K,), states x (K, n), inputs u (K, m), outputs y (K, r)."""

    t: Array
    x: Array
    u: Array
    y: Array


def has_random_input(name: str) -> bool:
    """Tell whether a scenario draws its input, so that runs of one observer differ."""
    return isinstance(load_scenario(name).inputs, WhiteGaussian)


def truth_of(name: str, seed: int) -> Truth:
    """Play a scenario; the seed is that of a random input, without which all runs are the same."""
    return _played(name, seed if has_random_input(name) else 0)


@functools.lru_cache(maxsize=16)
def _played(name: str, seed: int) -> Truth:
    count = round(load_scenario(name).duration / PERIOD) + 1
    x, u, y = columns(played(name, count, seed=seed), 'xuy')
    return Truth(PERIOD * np.arange(count), x, u, y)
