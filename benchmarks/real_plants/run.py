"""Windows of recorded plants, each solved alone, and what they forecast of what followed."""

import functools
import time
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benchmarks.real_plants.plants import PLANTS, Plant
from obs_ros import Record, solve_window
from obs_ros.core.typing import Array
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid

OVERLAP = 4  # windows begin in one window's length
HORIZONS = {'an eighth': 1.0 / 8.0, 'a window': 1.0}  # of a window


class Solved(NamedTuple):
    """One window: values and deviations of its parameters, outcome, process time (s).

    `forecast` and `hold` are the root mean square errors (r,) by horizon of the model's forecast
    and of the last measured value; NaN where the recording ends before.
    """

    values: Array
    sd: Array
    outcome: str
    message: str
    seconds: float
    forecast: dict[str, Array]
    hold: dict[str, Array]


@functools.cache  # once in each process, not for each window
def recorded(name: str, folder: Path) -> Record:
    """Return the whole recording of a plant."""
    plant = PLANTS[name]
    rows = np.genfromtxt(folder / plant.file, delimiter=',', names=True)
    t = rows['t'] if plant.interval is None else plant.interval * np.arange(rows.size)
    u, y = (
        np.column_stack([rows[name] for name in group]) for group in (plant.inputs, plant.outputs)
    )
    return Record(t, u, y)


def starts(plant: Plant, record: Record) -> list[float]:
    """Return the times (s) at which windows begin, the first of four disjoint from the fifth."""
    last = record.t[-1] - plant.window
    return np.arange(record.t[0], last, plant.window / OVERLAP).tolist()


def solved(name: str, folder: str, mode: Any, start: float) -> Solved:
    """Solve the window of a plant that begins at a time (s), process noise `off` or `auto`."""
    plant = PLANTS[name]
    whole = recorded(name, Path(folder))
    window = _part(whole, start, start + plant.window)
    begin = time.process_time()
    found = solve_window(plant.model, window, seed=1, process_noise=mode)
    seconds = time.process_time() - begin
    names = [variable.name for variable in plant.model.parameters]
    x = np.array([[found.state[variable.name]] for variable in plant.model.states])
    p = np.array([[found.parameters[each]] for each in names])
    forecast, hold = {}, {}
    for horizon, share in HORIZONS.items():
        ahead = _part(whole, window.t[-1], window.t[-1] + share * plant.window, closed=True)
        complete = ahead.t[-1] > window.t[-1] + 0.9 * share * plant.window
        grid = Grid.of(plant.model, ahead, np.ones(len(plant.outputs)))
        y = kernels_for(plant.model).trajectories(grid, x, p)[1][1:, :, 0]
        for errors, guess in ((forecast, y), (hold, ahead.y[:1])):
            rms = np.sqrt(np.mean((guess - ahead.y[1:]) ** 2, axis=0))
            errors[horizon] = rms if complete else np.full(len(plant.outputs), np.nan)
    return Solved(
        values=p[:, 0],
        sd=np.array([found.stddev[each] for each in names]),
        outcome=found.outcome.value,
        message=found.message,
        seconds=seconds,
        forecast=forecast,
        hold=hold,
    )


def _part(whole: Record, first: float, last: float, *, closed: bool = False) -> Record:
    """Return the samples in [first, last), or [first, last]."""
    inside = (whole.t >= first - 1e-9) & (whole.t < last + (1e-9 if closed else -1e-9))
    return Record(whole.t[inside], whole.u[inside], whole.y[inside])
