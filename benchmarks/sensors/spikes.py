"""Outliers put into runs of a spring by hand: spikes, bursts, dropouts, at a rate."""

from collections.abc import Callable, Mapping

import numpy as np

from benchmarks.sensors.spring import INTERVAL, NOISE, SAMPLES, Run, run
from obs_ros.core.typing import Array

IN_RUN = 10  # windows of a run
CLEAN = 'clean'
SIZES = (5.0, 100.0)  # standard deviations of outliers at a rate
RATES = {'1 %': 0.01, '3 %': 0.03}

Spoil = Callable[[Array, np.random.Generator], None]


def spike(size: float) -> Spoil:
    """Return a spoiler that puts one spike, of so many sigmas, into each window."""

    def spoil(y: Array, rng: np.random.Generator) -> None:
        for first in range(0, len(y), SAMPLES):
            place = first + rng.integers(1, SAMPLES - 1)
            y[place] += size * NOISE * rng.choice((-1.0, 1.0))

    return spoil


def every_two_seconds(y: Array, rng: np.random.Generator) -> None:
    """Put a spike of 5 to 100 sigmas every 2 s, the first within these."""
    every = round(2.0 / INTERVAL)
    places = np.arange(rng.integers(every), len(y), every)
    y[places, 0] += outlying(rng, places.size)


def bursts(y: Array, rng: np.random.Generator) -> None:
    """Put ten samples that are off by the same 20 to 50 sigmas into each window."""
    for first in range(0, len(y), SAMPLES):
        place = first + rng.integers(1, SAMPLES - 11)
        y[place : place + 10] += rng.uniform(20.0, 50.0) * NOISE * rng.choice((-1.0, 1.0))


def dropouts(y: Array, rng: np.random.Generator) -> None:
    """Let 2 % of the samples read 0, one at a time."""
    y[rng.random(len(y)) < 0.02] = 0.0


def at_rate(share: float) -> Spoil:
    """Return a spoiler that lets a share of the samples be off by 5 to 100 sigmas."""

    def spoil(y: Array, rng: np.random.Generator) -> None:
        places = np.flatnonzero(rng.random(len(y)) < share)
        y[places, 0] += outlying(rng, places.size)

    return spoil


def outlying(rng: np.random.Generator, count: int) -> Array:
    """Return errors (N,) of the sizes of outliers, of either sign."""
    return np.asarray(NOISE * rng.uniform(*SIZES, size=count) * rng.choice((-1.0, 1.0), size=count))


FAULTS: Mapping[str, Spoil] = {
    'one spike of 10 sigma': spike(10.0),
    'one spike of 100 sigma': spike(100.0),
    'a spike every 2 s': every_two_seconds,
    'a burst of 10 samples': bursts,
    'dropouts to zero': dropouts,
    **{f'{name} outliers of 5-100 sigma': at_rate(share) for name, share in RATES.items()},
}
BY_RATE = [f'{name} outliers of 5-100 sigma' for name in RATES]


def spoiled(kind: str, seed: int) -> Run:
    """Return a run of windows with a fault, or clean."""
    drawn = run(seed, SAMPLES * IN_RUN)
    y = drawn.record.y.copy()
    if kind != CLEAN:
        FAULTS[kind](y, np.random.default_rng([seed, 1]))
    return drawn.spoiled(y)
