"""Windows of plants whose states are pushed about: simulated, and solved with and without walks."""

import functools
from typing import Any, NamedTuple

import numpy as np

from benchmarks.process_noise.compiled import simulation_of
from benchmarks.process_noise.plants import PLANTS, Plant
from benchmarks.process_noise.reference import most_likely
from benchmarks.runner import cpu_seconds, timed
from obs_ros import Estimate, Record, solve_window
from obs_ros.core.deadline import Deadline
from obs_ros.core.model import names
from obs_ros.core.rng import random_generator
from obs_ros.core.typing import Array
from obs_ros.horizon.moving_horizon import MovingHorizon
from obs_ros.horizon.settings import EstimationSettings
from obs_ros.horizon.solver import Solver

STEPS = 10  # of the simulation, from sample to sample
MODES = ('off', 'auto')


def simulated(plant: Plant, walk: float, seed: int) -> tuple[Record, Array, Array, Array]:
    """Return a window's record, its parameters (q,), and its states (n,) at start and end."""
    rng = np.random.default_rng([seed, plant.samples])
    t = plant.interval * np.arange(plant.samples)
    x0, p, u = plant.draw(rng, t)
    push = np.zeros(x0.size)
    push[list(plant.walking)] = walk * np.sqrt(plant.interval / STEPS)
    pushes = push * rng.standard_normal((plant.samples - 1, STEPS, x0.size))
    y, x, u = np.empty((plant.samples, len(plant.noise))), x0.copy(), np.ascontiguousarray(u)
    simulation_of(plant.model)(t, u, p, pushes, x, y)
    return Record(t, u, y + plant.noise * rng.standard_normal(y.shape)), p, x0, x


class Solved(NamedTuple):
    """Errors and deviations of parameters (q,) and end state (n,), outcome, process time (s).

    `walks` (w,) are those found of the states whose walk is told.
    """

    error: Array
    sd: Array
    end_error: Array
    end_sd: Array
    walks: Array
    outcome: str
    seconds: float


class Window(NamedTuple):
    """One window by mode; errors (q,) of the reference and process times (s) of a warm window.

    Warm is the second of two in sequence, by mode; all NaN where they were left out.
    """

    modes: dict[str, Solved]
    reference: Array
    warm: dict[str, float]


def solved(name: str, walk: float, seed: int, referred: bool) -> Window:
    """Solve one window in every mode; if it is `referred`, also by the reference, and warm."""
    compile_all(name)
    plant = PLANTS[name]
    record, p, x0, x = simulated(plant, walk, seed)
    reference, warm = np.full(len(plant.estimated), np.nan), dict.fromkeys(MODES, np.nan)
    if referred:
        reference = (most_likely(plant, record, x0, p, walk) - p)[plant.estimated]
        warm = {mode: warm_seconds(plant, record, mode, seed) for mode in MODES}
    modes = {mode: _solved(plant, record, mode, seed, p, x) for mode in MODES}
    return Window(modes, reference, warm)


def warm_seconds(plant: Plant, record: Record, mode: Any, seed: int) -> float:
    """Return the process time (s) of a window that begins when a quarter of another is over."""
    settings = EstimationSettings(process_noise=mode, fixed=plant.fixed)
    horizon, long = MovingHorizon(Solver.of(plant.model, settings)), plant.samples * 4 // 5
    for i, first in enumerate((0, plant.samples - long)):
        part = slice(first, first + long)
        window = Record(record.t[part], record.u[part], record.y[part])
        rng = random_generator(seed, i)
        seconds = cpu_seconds(functools.partial(horizon.solve, window, rng, Deadline()))
    return seconds


@functools.cache  # once in each process
def compile_all(name: str) -> None:
    """Solve a window with walks, so that no time of another holds what a first one needs."""
    plant = PLANTS[name]
    record = simulated(plant, 0.1, 0)[0]
    for mode in MODES:
        _estimate(plant, record, mode, 0)
        warm_seconds(plant, record, mode, 0)


def _estimate(plant: Plant, record: Record, mode: Any, seed: int) -> Estimate:
    return solve_window(plant.model, record, seed=seed, process_noise=mode, fixed=plant.fixed)


def _solved(plant: Plant, record: Record, mode: str, seed: int, p: Array, x: Array) -> Solved:
    found, seconds = timed(lambda: _estimate(plant, record, mode, seed))
    states = names(plant.model.states)
    parameters = [plant.model.parameters[i].name for i in plant.estimated]
    return Solved(
        error=np.array([found.parameters[v] for v in parameters]) - p[plant.estimated],
        sd=np.array([found.stddev[v] for v in parameters]),
        end_error=np.array([found.state[v] for v in states]) - x,
        end_sd=np.array([found.stddev[v] for v in states]),
        walks=np.array([found.walks.get(states[i], 0.0) for i in plant.told]),
        outcome=found.outcome.value,
        seconds=seconds,
    )
