"""Windows of recorded plants, solved alone and in sequence, and what they forecast."""

import functools
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benchmarks.recordings import PLANTS, Plant, forecast, part, recorded, starts
from benchmarks.runner import timed
from obs_ros import Estimate, Record, solve_window
from obs_ros.core.deadline import Deadline
from obs_ros.core.rng import random_generator
from obs_ros.core.typing import Array
from obs_ros.horizon.moving_horizon import MovingHorizon
from obs_ros.horizon.settings import EstimationSettings
from obs_ros.horizon.solver import Solver

HORIZONS = {'an eighth': 1.0 / 8.0, 'a window': 1.0}  # of a window
SOON = 1.0  # s: a forecast just so far ahead


class Solved(NamedTuple):
    """One window: values and deviations of its parameters, outcome, process time (s).

    `forecast` and `hold` are the root mean square errors (r,) by horizon of the model's forecast
    and of the last measured value, and `soon` (r,) the forecast's error SOON ahead; NaN where the
    recording has nothing there. `factor` (q,) is the scatter of disjoint windows over their
    deviations that a sequence has found so far, NaN where it says nothing.
    """

    values: Array
    sd: Array
    outcome: str
    message: str
    seconds: float
    forecast: dict[str, Array]
    hold: dict[str, Array]
    soon: Array
    till_soon: Array
    factor: Array


def solved(name: str, folder: str, mode: Any, start: float) -> Solved:
    """Solve the window of a plant that begins at a time (s) alone, in a mode of process noise."""
    plant, whole = PLANTS[name], recorded(name, Path(folder))
    window = part(whole, start, start + plant.window)
    found, seconds = timed(lambda: solve_window(plant.model, window, seed=1, process_noise=mode))
    return _judged(plant, whole, window, found, seconds)


def in_sequence(name: str, folder: str, mode: Any) -> list[Solved]:
    """Solve all windows of a plant one after the other, as a node does."""
    plant, whole = PLANTS[name], recorded(name, Path(folder))
    solver = Solver.of(plant.model, EstimationSettings(process_noise=mode))
    solver.prepare()
    windows, found = MovingHorizon(solver), []
    for i, start in enumerate(starts(plant, whole)):
        window = part(whole, start, start + plant.window)
        rng = random_generator(1, i)
        estimate, seconds = timed(functools.partial(windows.solve, window, rng, Deadline()))
        found.append(_judged(plant, whole, window, estimate, seconds))
    return found


def _judged(plant: Plant, whole: Record, window: Record, found: Estimate, seconds: float) -> Solved:
    """Return an estimate with its forecasts: the model's rollout from the window's end."""
    names = [variable.name for variable in plant.model.parameters]
    nothing = np.full(len(plant.outputs), np.nan)
    foretold, hold, soon, till_soon = {}, {}, nothing, nothing
    for horizon, share in HORIZONS.items():
        ahead = part(whole, window.t[-1], window.t[-1] + share * plant.window, closed=True)
        complete = ahead.t[-1] > window.t[-1] + 0.9 * share * plant.window
        y = forecast(plant.model, found, ahead)[1:]
        for errors, guess in ((foretold, y), (hold, ahead.y[:1])):
            rms = np.sqrt(np.mean((guess - ahead.y[1:]) ** 2, axis=0))
            errors[horizon] = rms if complete else nothing
        there = np.flatnonzero(np.abs(ahead.t[1:] - window.t[-1] - SOON) < 1e-6)
        if there.size:
            off = (y - ahead.y[1:])[: there[0] + 1]
            soon, till_soon = off[-1], np.sqrt(np.mean(off**2, axis=0))
    return Solved(
        values=np.array([found.parameters[each] for each in names]),
        sd=np.array([found.stddev[each] for each in names]),
        outcome=found.outcome.value,
        message=found.message,
        seconds=seconds,
        forecast=foretold,
        hold=hold,
        soon=soon,
        till_soon=till_soon,
        factor=np.array([found.figures.get(f'scatter_over_sd.{each}', np.nan) for each in names]),
    )
