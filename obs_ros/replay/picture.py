"""Pictures of a replay: parameters and states with their bands, and what the fits leave."""

from pathlib import Path
from typing import Any

import numpy as np

from obs_ros.replay.engine import Account
from obs_ros.replay.extras import require
from obs_ros.typing import Array

BAND = 2.0  # standard deviations
MOST_POINTS = 4000  # of a curve
MARKED = 400  # estimates at most that get a dot each
CONFIRMED = ('converged', 'at_bound')
COLOURS = ('#1f5fa8', '#c4561a', '#2d7f46', '#7a4fa0', '#8c6d1f', '#a83254')


def draw(account: Account, folder: Path) -> None:
    """Write parameters.png, states.png and misfit.png; nothing without estimates.

    Raises MissingPackageError without Matplotlib.
    """
    matplotlib = require('matplotlib', 'drawing')
    matplotlib.use('Agg')
    plt = require('matplotlib.pyplot', 'drawing')
    history = account.history
    if not len(history):
        return
    n = len(history.model.states)
    with plt.rc_context({'font.size': 9, 'axes.spines.top': False, 'axes.spines.right': False}):
        if history.model.parameters:
            _curves(plt, account, n, history.model.parameters, folder / 'parameters.png',
                    f'Parameters, ± {BAND:g} sd')  # fmt: skip
        _curves(plt, account, 0, history.model.states, folder / 'states.png',
                f'States at the end of each window, ± {BAND:g} sd'
                if account.horizon else f'States, ± {BAND:g} sd')  # fmt: skip
        _misfit(plt, account, folder / 'misfit.png')


def _curves(plt: Any, account: Account, first: int, variables: Any, path: Path, title: str) -> None:
    history = account.history
    times, shown = _times(account)
    values, deviations = history.rows('values')[shown], history.rows('deviations')[shown]
    confirmed = np.isin(np.array(history.outcome_of)[shown], CONFIRMED)
    figure, axes = _panels(plt, len(variables), title)
    for place, (variable, ax) in enumerate(zip(variables, axes, strict=True), first):
        colour = COLOURS[(place - first) % len(COLOURS)]
        value, deviation = values[:, place], BAND * deviations[:, place]
        _band(ax, times, value, deviation, colour)
        _dots(ax, times, value, confirmed, np.isfinite(deviation), colour)
        for jump in history.jumps:
            if variable.name in jump.sizes:
                ax.axvline(
                    _since(account, jump.stamp), color='#b01030', linestyle='--', linewidth=1
                )
        unit = '' if variable.unit == '1' else f' ({variable.unit})'
        ax.set_ylabel(f'{variable.name}{unit}')
        _limit(ax, value, deviation, (variable.lower, variable.upper))
    jumps = any(set(jump.sizes) & {v.name for v in variables} for jump in history.jumps)
    _legend(figure, dots=times.size <= MARKED, jumps=jumps)
    _finish(plt, figure, axes, account, path)


def _misfit(plt: Any, account: Account, path: Path) -> None:
    """Draw residuals and forecast errors by output, or the innovation of immediate observers."""
    history = account.history
    times, shown = _times(account)
    if account.horizon is None:
        figure, axes = _panels(plt, 1, 'Innovation: outputs less what was expected')
        axes[0].plot(times, history.rows('rms')[shown][:, 0], color=COLOURS[0], linewidth=0.8)
        axes[0].set_ylabel('root mean square')
        _finish(plt, figure, axes, account, path)
        return
    outputs = history.model.outputs
    figure, axes = _panels(plt, len(outputs), 'What windows leave, and what the next ones bring')
    kinds = (
        ('residuals', 'residual of the window', COLOURS[0], '-'),
        ('forecasts', f'forecast error over the next {account.horizon:g} s', COLOURS[1], '-'),
        ('held', 'the same, last value held', '0.6', ':'),
    )
    for place, (variable, ax) in enumerate(zip(outputs, axes, strict=True)):
        for kind, label, colour, style in kinds:
            rms = history.rows(kind)[shown][:, place]
            rms = np.where(np.isfinite(rms) & (rms > 0.0), rms, np.nan)
            ax.plot(times, rms, color=colour, linestyle=style, linewidth=1.2, label=label,
                    marker='o' if times.size <= MARKED else None, markersize=3)  # fmt: skip
        ax.set_yscale('log')
        unit = '' if variable.unit == '1' else f' ({variable.unit})'
        ax.set_ylabel(f'rms of {variable.name}{unit}')
    axes[0].legend(loc='lower center', bbox_to_anchor=(0.5, 1.0), ncols=3, frameon=False)
    _finish(plt, figure, axes, account, path)


def _times(account: Account) -> tuple[Array, Any]:
    """Return seconds since the first sample, of the estimates shown: all, or some of very many."""
    stamps = account.history.stamps
    shown = slice(None, None, max(1, -(-len(stamps) // MOST_POINTS)))
    return np.array([_since(account, int(stamp)) for stamp in stamps[shown]]), shown


def _since(account: Account, stamp: int | None) -> float:
    return ((stamp or 0) - (account.first or 0)) / 1e9


def _panels(plt: Any, count: int, title: str) -> tuple[Any, Any]:
    figure, axes = plt.subplots(
        count, 1, figsize=(9.0, 1.4 + 1.9 * count), sharex=True, squeeze=False,
        layout='constrained',
    )  # fmt: skip
    figure.suptitle(title, x=0.01, ha='left', fontweight='bold')
    return figure, axes[:, 0]


def _band(ax: Any, times: Array, value: Array, deviation: Array, colour: str) -> None:
    ax.plot(times, value, color=colour, linewidth=0.8, alpha=0.5)
    ax.fill_between(times, value - deviation, value + deviation, color=colour, alpha=0.18, lw=0)
    if times.size <= MARKED:
        ax.errorbar(times, value, np.nan_to_num(deviation), fmt='none', ecolor=colour,
                    elinewidth=0.8, alpha=0.6)  # fmt: skip


def _dots(ax: Any, times: Array, value: Array, confirmed: Any, known: Any, colour: str) -> None:
    """Mark each estimate: full when confirmed, hollow when in doubt, a cross without deviation."""
    if times.size > MARKED:
        return
    style = {'linestyle': '', 'color': colour, 'markersize': 4}
    ax.plot(times[confirmed & known], value[confirmed & known], marker='o', **style)
    doubtful = ~confirmed & known
    ax.plot(times[doubtful], value[doubtful], marker='o', markerfacecolor='white', **style)
    ax.plot(times[~known], value[~known], marker='x', **style)


def _limit(ax: Any, value: Array, deviation: Array, bounds: tuple[float, float]) -> None:
    """Keep a few wide bands from making all else flat; no band leads outside the bounds."""
    known = np.isfinite(value)
    if not known.any():
        return
    typical = deviation[np.isfinite(deviation)]
    margin = 3.0 * float(np.median(typical)) if typical.size else 0.0
    low = max(float(value[known].min()) - margin, bounds[0])
    high = min(float(value[known].max()) + margin, bounds[1])
    room = 0.08 * (high - low) or 0.05 * abs(high) or 1.0
    ax.set_ylim(low - room, high + room)


def _legend(figure: Any, *, dots: bool, jumps: bool) -> None:
    lines = require('matplotlib.lines', 'drawing')
    style = {'linestyle': '', 'color': '0.3', 'markersize': 4}
    entries = (
        [
            lines.Line2D([], [], marker='o', label='confirmed', **style),
            lines.Line2D([], [], marker='o', markerfacecolor='white', label='in doubt', **style),
            lines.Line2D([], [], marker='x', label='no standard deviation', **style),
        ]
        if dots
        else []
    )
    if jumps:
        entries.append(lines.Line2D([], [], color='#b01030', linestyle='--', label='jump found'))
    if entries:
        figure.legend(handles=entries, loc='outside upper right', ncols=len(entries), frameon=False)


def _finish(plt: Any, figure: Any, axes: Any, account: Account, path: Path) -> None:
    for ax in axes:
        ax.grid(alpha=0.25)
    since = '' if not account.first else f' since {account.first / 1e9:.3f}'
    axes[-1].set_xlabel(f'time (s{since})')
    figure.align_ylabels(axes)
    figure.savefig(path, dpi=120, metadata={'Software': None})
    plt.close(figure)
