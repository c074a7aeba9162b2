"""Panels of a picture: frames, limits, marks and legends, without knowledge of a replay."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from obs_ros.core.model import Variable
from obs_ros.core.typing import Array, BoolArray, IntArray
from obs_ros.replay.extras import require

STYLE = {'font.size': 9, 'axes.spines.top': False, 'axes.spines.right': False}
COLOURS = ('#1f5fa8', '#c4561a', '#2d7f46', '#7a4fa0', '#8c6d1f', '#a83254')
JUMP_COLOUR = '#b01030'


@dataclass(frozen=True)
class PanelSettings:
    """Limits by which a panel stays readable."""

    most_points: int = 4000  # of a curve: more than a screen has columns
    marked: int = 400  # estimates at most that get a dot each: more would touch
    gap: float = 10.0  # usual steps after which a line is interrupted: no window was there
    margin: float = 3.0  # usual half-widths around the values: a few wide bands flatten nothing
    odd: float = 0.01  # of the values on either side, which do not count for the limits


SETTINGS = PanelSettings()


def panels(plt: Any, count: int, title: str) -> tuple[Any, Any]:
    """Return a figure and its axes (count,), one below the other."""
    figure, axes = plt.subplots(
        count, 1, figsize=(9.0, 1.4 + 1.9 * count), sharex=True, squeeze=False,
        layout='constrained',
    )  # fmt: skip
    figure.suptitle(title, x=0.01, ha='left', fontweight='bold')
    return figure, axes[:, 0]


def label(ax: Any, variable: Variable, prefix: str = '') -> None:
    """Write name and unit of a variable beside its axis."""
    unit = '' if variable.unit == '1' else f' ({variable.unit})'
    ax.set_ylabel(f'{prefix}{variable.name}{unit}')


@dataclass(frozen=True)
class Band:
    """Values (K,) with the ends of their intervals; these are NaN where there is none."""

    value: Array
    lower: Array
    upper: Array

    @property
    def known(self) -> BoolArray:
        """Which values (K,) have an interval."""
        return np.isfinite(self.lower) & np.isfinite(self.upper)

    @property
    def reach(self) -> Array:
        """How far (2, K) the interval reaches below and above each value; 0 where there is none."""
        below, above = self.value - self.lower, self.upper - self.value
        return np.where(self.known, np.maximum([below, above], 0.0), 0.0)

    @property
    def usual_reach(self) -> tuple[float, float]:
        """How far intervals reach below and above in the median; 0 where there is none."""
        reach = self.reach[:, self.known]
        below, above = np.median(reach, axis=1).tolist() if reach.size else (0.0, 0.0)
        return below, above


def limit(
    ax: Any, value: Array, bounds: tuple[float, float], reach: tuple[float, float] = (0.0, 0.0)
) -> None:
    """Show all values (K,), and the usual `reach` of bands below and above them.

    So a few wide bands flatten nothing; and none leads outside the bounds.
    """
    known = np.isfinite(value)
    if not known.any():
        return
    below, above = reach
    low = max(float(value[known].min()) - SETTINGS.margin * below, bounds[0])
    high = min(float(value[known].max()) + SETTINGS.margin * above, bounds[1])
    room = 0.08 * (high - low) or 0.05 * abs(high) or 1.0
    ax.set_ylim(low - room, high + room)


def dots(ax: Any, times: Array, value: Array, confirmed: Any, known: Any, colour: str) -> None:
    """Mark each estimate: full if confirmed, hollow if in doubt, a cross without interval."""
    if times.size > SETTINGS.marked:
        return
    style = {'linestyle': '', 'color': colour, 'markersize': 4}
    ax.plot(times[confirmed & known], value[confirmed & known], marker='o', **style)
    doubtful = ~confirmed & known
    ax.plot(times[doubtful], value[doubtful], marker='o', markerfacecolor='white', **style)
    ax.plot(times[~known], value[~known], marker='x', **style)


def broken(times: Array, values: Array, period: float | None = None) -> tuple[Array, Array]:
    """Return times and values of a line, with a NaN at each gap, where no window was.

    So is a line with a `period` interrupted where it wraps.
    """
    if times.size < 3:
        return times, values
    steps = np.diff(times)
    gaps = np.flatnonzero(steps > SETTINGS.gap * np.median(steps)) + 1
    gaps = np.union1d(gaps, wraps(values, period))
    return np.insert(times, gaps, times[gaps]), np.insert(values, gaps, math.nan)


def wraps(values: Array, period: float | None) -> IntArray:
    """Return the places of values (K,) that lie more than half a period from the one before."""
    if period is None:
        return np.zeros(0, dtype=np.int64)
    return np.flatnonzero(np.abs(np.diff(values)) > 0.5 * period) + 1


def usual(values: Array) -> Array:
    """Return the values, odd ones drawn in, so that a spike does not flatten the rest."""
    if not values.size:
        return values
    low, middle, high = np.quantile(values, (SETTINGS.odd, 0.5, 1.0 - SETTINGS.odd))
    return np.asarray(np.clip(values, low - (middle - low), high + (high - middle)))


def legend(figure: Any, *, dots: bool, jumps: bool, path: bool | None = None) -> None:
    """Explain the marks; `path` is None where there are no measurements either."""
    lines = require('matplotlib.lines', 'drawing')
    style = {'linestyle': '', 'color': '0.3', 'markersize': 4}
    entries = (
        [
            lines.Line2D([], [], marker='o', label='confirmed', **style),
            lines.Line2D([], [], marker='o', markerfacecolor='white', label='in doubt', **style),
            lines.Line2D([], [], marker='x', label='no interval', **style),
        ]
        if dots
        else []
    )
    if path is not None:
        entries.insert(0, lines.Line2D([], [], label='measured', **{**style, 'marker': '.',
                                                                    'color': '0.6'}))  # fmt: skip
        label = 'fitted path' if path else 'estimate'
        entries.insert(0, lines.Line2D([], [], color='0.3', linewidth=1.2, label=label))
    if jumps:
        entries.append(lines.Line2D([], [], color=JUMP_COLOUR, linestyle='--', label='jump'))
    if entries:
        figure.legend(handles=entries, loc='outside upper right', ncols=len(entries), frameon=False,
                      columnspacing=1.0, handlelength=1.2, handletextpad=0.4)  # fmt: skip


def finish(figure: Any, axes: Any, first: int | None) -> None:
    """Add grid and time axis; times count from `first` (ns), the stamp of the first sample."""
    for ax in axes:
        ax.grid(alpha=0.25)
    since = '' if not first else f' since {first / 1e9:.3f}'
    axes[-1].set_xlabel(f'time (s{since})')
    figure.align_ylabels(axes)
