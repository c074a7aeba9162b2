"""The cost of windows that no candidate fits, in candidate-steps of like windows that one does."""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from benchmarks.metered import spent
from benchmarks.mismatch.plants import FULL_TANKS, NOISE, TANKS, overflowing
from benchmarks.zoo.lag import LAG
from obs_ros import Model, Record
from obs_ros.core.typing import Array

SEEDS = 5
FITS = 'fits'
TANK_SAMPLES, TANK_NOISE = 1024, {'y1': NOISE, 'y2': NOISE}  # V
LOW_TOP = 5.0  # V, of tanks that overflow in every window
LAG_SAMPLES, LAG_INTERVAL, LAG_NOISE = 400, 0.1, 0.02  # s, m
STIFFNESS, DAMPING = 1.0, 0.3  # 1/s2, 1/s, of the plant that is no lag


class Cost(NamedTuple):
    """One window solved alone: candidate-steps, process time (s), outcome."""

    steps: int
    seconds: float
    outcome: str


def lag_window(kind: str, seed: int) -> Record:
    """Return a window of a lag, or of what is none."""
    rng = np.random.default_rng([seed, LAG_SAMPLES])
    t = LAG_INTERVAL * np.arange(LAG_SAMPLES)
    levels = rng.uniform(0.5, 1.5, LAG_SAMPLES) * (1.0 - 2.0 * (np.arange(LAG_SAMPLES) % 2))
    u = levels[(t // 5.0).astype(int)]
    k, tau = rng.uniform((0.5, 2.0), (2.0, 6.0))
    if kind == 'wrong structure':
        y = oscillation(u, k)
    else:
        y = np.empty(LAG_SAMPLES)
        y[0], decay = rng.uniform(-1.0, 1.0), np.exp(-LAG_INTERVAL / tau)
        for i in range(LAG_SAMPLES - 1):
            y[i + 1] = k * u[i] + (y[i] - k * u[i]) * decay
    return Record(t, u[:, None], replaced(kind, y[:, None], LAG_NOISE, rng))


def oscillation(u: Array, k: float) -> Array:
    """Return the outputs (K,) of a weakly damped mass that the input pulls."""
    y, v, h = np.empty(u.size), 0.0, LAG_INTERVAL
    y[0] = 0.0
    for i in range(u.size - 1):
        v += h * (STIFFNESS * (k * u[i] - y[i]) - DAMPING * v)
        y[i + 1] = y[i] + h * v
    return y


def tanks_window(kind: str, seed: int) -> Record:
    """Return a window of two tanks, or of what their model cannot be."""
    record, _ = overflowing(seed, TANK_SAMPLES, LOW_TOP if kind == 'overflow' else np.inf)
    rng = np.random.default_rng([seed, TANK_SAMPLES, 1])
    return record.with_outputs(replaced(kind, record.y, 0.0, rng))


def replaced(kind: str, y: Array, noise: float, rng: np.random.Generator) -> Array:
    """Return the outputs (K, r) with noise, or others of the same mean and spread."""
    white, mean, spread = rng.standard_normal(y.shape), y.mean(axis=0), y.std(axis=0)
    if kind == 'random outputs':
        return np.asarray(mean + spread * white)
    if kind == 'square wave':
        y = mean + 2.0 * spread * (1.0 - 2.0 * (np.arange(len(y)) // 23 % 2))[:, None]
    return np.asarray(y + noise * white)


class Case(NamedTuple):
    """A model, its noise by output, its windows by kind and seed, and the kinds."""

    model: Model
    noise: Mapping[str, float]
    window: Callable[[str, int], Record]
    kinds: tuple[str, ...]


CASES = {
    'lag, 3 unknowns': Case(
        LAG, {'y': LAG_NOISE}, lag_window, ('wrong structure', 'random outputs', 'square wave')
    ),
    'two tanks, 5 unknowns': Case(
        TANKS, TANK_NOISE, tanks_window, ('overflow', 'random outputs', 'square wave')
    ),
    'two tanks, 8 unknowns': Case(
        FULL_TANKS, TANK_NOISE, tanks_window, ('overflow', 'random outputs', 'square wave')
    ),
}
KNOWLEDGE = ('unknown', 'known')  # of the noise


def cost(name: str, kind: str, known: str, seed: int) -> Cost:
    """Solve a window alone, with default settings, and count."""
    case = CASES[name]
    noise = case.noise if known == 'known' else None
    run = spent(case.model, case.window(kind, seed), seed, noise=noise)
    return Cost(run.steps, run.seconds, run.estimate.outcome.value)


def runs(seed: int) -> dict[tuple[str, str, str], list[tuple[str, str, str, int]]]:
    """Return the runs of `cost` by case, kind and knowledge of the noise."""
    return {
        (name, kind, known): [(name, kind, known, seed + i) for i in range(SEEDS)]
        for name, case in CASES.items()
        for known in KNOWLEDGE
        for kind in (FITS, *case.kinds)
    }
