"""Picture of the ball and beam, process noise off and found; needs Matplotlib."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benchmarks.recordings import PLANTS, recorded
from benchmarks.report import panels, rms
from obs_ros import Record, solve_window
from obs_ros.core.typing import Array
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid

PLANT = 'ball and beam'
MODES = {'off': 'tab:orange', 'auto': 'tab:blue'}
PERIOD, AHEAD = 1.0, 1.0  # s from window to window, and of a forecast: they abut
SHOWN = 5  # every so many windows one with its deviation
BAND = 2.0  # standard deviations


class Told(NamedTuple):
    """A window: its end (s), a and its deviation (m/s2), and its forecast (K, 2) of t and y."""

    end: float
    a: float
    sd: float
    forecast: Array


def draw_ball(folder: Path) -> Any:
    """Draw a with its deviations, and forecasts of one second over what was measured."""
    whole = recorded(PLANT, folder)
    figure, grid = panels(2, 2, (13.0, 7.0), sharex=True, sharey='row')
    for (above, below), (mode, colour) in zip(grid.T, MODES.items(), strict=True):
        windows = told(whole, mode)
        shown = windows[::SHOWN]
        end, a, sd = (np.array([getattr(one, kind) for one in shown]) for kind in Told._fields[:3])
        given = np.isfinite(sd)
        above.errorbar(
            end[given], a[given], BAND * sd[given], fmt='o', color=colour, ms=5, capsize=2,
            label=f'± {BAND:g} sd',
        )  # fmt: skip
        if not given.all():
            above.plot(end[~given], a[~given], 'x', color=colour, ms=7, label='sd withheld')
        below.plot(whole.t, whole.y[:, 0], color='0.65', lw=2.5, label='measured')
        for i, one in enumerate(windows):
            label = f'forecast of {AHEAD:g} s' if i == 0 else None
            below.plot(*one.forecast.T, color=colour, lw=1.3, label=label)
        wrong = 1e3 * float(rms(last_errors(whole, windows)))
        above.set_title(f'process_noise {mode}: windows of {PLANTS[PLANT].window:g} s, each alone')
        below.set_title(f'after {AHEAD:g} s forecasts are off by {wrong:.1f} mm (RMS)')
        below.set(xlabel='t (s), end of the window', xlim=(windows[0].end - 2.0, whole.t[-1]))
        for axes in (above, below):
            axes.grid(alpha=0.3)
            axes.legend(fontsize=9, loc='upper right', ncols=2)
    grid[0, 0].set(ylabel='a (m/s2)', ylim=(0.0, 7.5))
    low, high = float(whole.y.min()), float(whole.y.max())
    grid[1, 0].set(ylabel='position (m)', ylim=(low - 0.02, high + 0.05))
    return figure


def told(whole: Record, mode: Any) -> list[Told]:
    """Solve a window every second, each alone."""
    plant = PLANTS[PLANT]
    interval = float(whole.t[1] - whole.t[0])
    length, step, ahead = (round(time / interval) for time in (plant.window, PERIOD, AHEAD))
    found = []
    for first in range(0, len(whole.t) - length - ahead, step):
        last = first + length
        estimate = solve_window(plant.model, _part(whole, first, last), seed=1, process_noise=mode)
        following = _part(whole, last - 1, last + ahead)
        grid = Grid.of(plant.model, following, np.ones(1))
        x, p = (np.array(list(each.values())) for each in (estimate.state, estimate.parameters))
        y = kernels_for(plant.model).trajectories(grid, x[:, None], p[:, None])[1][:, 0, 0]
        forecast = np.column_stack([following.t, y])
        end = float(whole.t[last - 1])
        found.append(Told(end, estimate.parameters['a'], estimate.stddev['a'], forecast))
    return found


def last_errors(whole: Record, windows: list[Told]) -> Array:
    """Return the errors (m) at the ends of the forecasts."""
    measured = np.interp([one.forecast[-1, 0] for one in windows], whole.t, whole.y[:, 0])
    return np.array([one.forecast[-1, 1] for one in windows]) - measured


def _part(whole: Record, first: int, last: int) -> Record:
    return Record(whole.t[first:last], whole.u[first:last], whole.y[first:last])
