"""Pictures of a replay: parameters and states with their bands, and what the fits leave."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from obs_ros.core.model import Variable
from obs_ros.core.typing import Array, IntArray
from obs_ros.replay.engine import Account
from obs_ros.replay.extras import require
from obs_ros.replay.fitted import fitted_outputs, outputs_of_states

BAND = 2.0  # standard deviations
MOST_POINTS = 4000  # of a curve
MARKED = 400  # estimates at most that get a dot each
CONFIRMED = ('converged', 'at_bound')
STYLE = {'font.size': 9, 'axes.spines.top': False, 'axes.spines.right': False}
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
    with plt.rc_context(STYLE):
        if history.model.parameters:
            _parameters(plt, account, folder / 'parameters.png')
        _states(plt, account, folder / 'states.png')
        _misfit(plt, account, folder / 'misfit.png')


def _parameters(plt: Any, account: Account, path: Path) -> None:
    """Draw each parameter, estimate by estimate, with its band."""
    history = account.history
    variables, times = history.model.parameters, _times(account)[0]
    figure, axes = _panels(plt, len(variables), f'Parameters, ± {BAND:g} sd')
    for k, (variable, ax) in enumerate(zip(variables, axes, strict=True)):
        place, colour = len(history.model.states) + k, COLOURS[k % len(COLOURS)]
        value, deviation = _estimates(ax, account, place, colour, joined=True)
        _label(ax, variable)
        _limit(ax, value, deviation, (variable.lower, variable.upper))
    jumps = _draw_jumps(account, axes, variables)
    _legend(figure, dots=times.size <= MARKED, jumps=jumps)
    _finish(plt, figure, axes, account, path)


def _states(plt: Any, account: Account, path: Path) -> None:
    """Draw the states that the fits found, what was measured, and the estimates with their bands.

    Outputs that are no state have panels of their own, below.
    """
    history = account.history
    model, times = history.model, _times(account)[0]
    shown = outputs_of_states(model)
    others = [k for k in range(len(model.outputs)) if k not in shown.values()]
    title = 'States and outputs' if others else 'States'
    figure, axes = _panels(plt, len(model.states) + len(others), f'{title}, ± {BAND:g} sd')
    along = _seconds(account, history.path.stamps)
    for place, (variable, ax) in enumerate(zip(model.states, axes, strict=False)):
        colour, fitted = COLOURS[place % len(COLOURS)], history.path.rows[:, place]
        measured = _measured(ax, account, shown[place]) if place in shown else np.empty(0)
        ax.plot(*_broken(along, fitted), color=colour, linewidth=0.9)
        value, deviation = _estimates(ax, account, place, colour, joined=account.horizon is None)
        _label(ax, variable)
        seen = np.concatenate([value, fitted, _usual(measured)])
        # Padded: only estimates have a band.
        spread = np.concatenate([deviation, np.full(seen.size - value.size, math.nan)])
        _limit(ax, seen, spread, (-math.inf, math.inf))
    fits = fitted_outputs(history)
    for k, ax in zip(others, axes[len(model.states) :], strict=True):
        measured = _measured(ax, account, k)
        ax.plot(*_broken(along, fits[:, k]), color='0.2', linewidth=0.9)
        _label(ax, model.outputs[k])
        seen = np.concatenate([fits[:, k], _usual(measured)])
        _limit(ax, seen, np.empty(0), (-math.inf, math.inf))
    jumps = _draw_jumps(account, axes, model.variables)
    _legend(figure, dots=times.size <= MARKED, jumps=jumps, path=account.horizon is not None)
    _finish(plt, figure, axes, account, path)


def _estimates(
    ax: Any, account: Account, place: int, colour: str, *, joined: bool
) -> tuple[Array, Array]:
    """Draw the estimates of one unknown, `joined` with a band; return values and band widths."""
    history = account.history
    times, shown = _times(account)
    value = history.rows('values')[shown][:, place]
    deviation = BAND * history.rows('deviations')[shown][:, place]
    confirmed = np.isin(np.array(history.outcome_of)[shown], CONFIRMED)
    if joined:
        ax.plot(times, value, color=colour, linewidth=0.8, alpha=0.5)
        ax.fill_between(times, value - deviation, value + deviation, color=colour, alpha=0.18, lw=0)
    if times.size <= MARKED:
        ax.errorbar(times, value, np.nan_to_num(deviation), fmt='none', ecolor=colour,
                    elinewidth=0.8, alpha=0.6)  # fmt: skip
    _dots(ax, times, value, confirmed, np.isfinite(deviation), colour)
    return value, deviation


def _measured(ax: Any, account: Account, output: int) -> Array:
    """Draw what was measured of an output, and return it."""
    trace = account.history.measured
    values = trace.rows[:, output]
    ax.plot(_seconds(account, trace.stamps), values, linestyle='', marker='.', markersize=4,
            color='0.68', zorder=0)  # fmt: skip
    return values[np.isfinite(values)]


def _draw_jumps(account: Account, axes: Any, variables: Sequence[Variable]) -> bool:
    """Mark the jumps of the parameters shown, each in its panel, or in all; whether there were."""
    names = [variable.name for variable in variables]
    found = [jump for jump in account.history.jumps if set(jump.sizes) & set(names)]
    own = len(names) == len(axes)
    for jump in found:
        for name, ax in zip(names, axes, strict=True) if own else ((None, ax) for ax in axes):
            if name is None or name in jump.sizes:
                ax.axvline(_since(account, jump.stamp), color='#b01030', linestyle='--', lw=1)
    return bool(found)


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
        _label(ax, variable, 'rms of ')
    axes[0].legend(loc='lower center', bbox_to_anchor=(0.5, 1.0), ncols=3, frameon=False)
    _finish(plt, figure, axes, account, path)


def _times(account: Account) -> tuple[Array, Any]:
    """Return seconds since the first sample, of the estimates shown: all, or some of very many."""
    stamps = account.history.stamps
    shown = slice(None, None, max(1, -(-len(stamps) // MOST_POINTS)))
    return np.array([_since(account, int(stamp)) for stamp in stamps[shown]]), shown


def _seconds(account: Account, stamps: IntArray) -> Array:
    return (stamps - (account.first or 0)) / 1e9


def _broken(times: Array, values: Array) -> tuple[Array, Array]:
    """Interrupt a line where no window was: at gaps ten times as long as most steps."""
    if times.size < 3:
        return times, values
    steps = np.diff(times)
    gaps = np.flatnonzero(steps > 10.0 * np.median(steps)) + 1
    return np.insert(times, gaps, times[gaps]), np.insert(values, gaps, math.nan)


def _usual(values: Array) -> Array:
    """Return what spans the values but for their odd ones, so that a spike flattens nothing."""
    if not values.size:
        return values
    low, middle, high = np.quantile(values, (0.01, 0.5, 0.99))
    return np.asarray(np.clip(values, low - (middle - low), high + (high - middle)))


def _since(account: Account, stamp: int | None) -> float:
    return ((stamp or 0) - (account.first or 0)) / 1e9


def _label(ax: Any, variable: Variable, prefix: str = '') -> None:
    unit = '' if variable.unit == '1' else f' ({variable.unit})'
    ax.set_ylabel(f'{prefix}{variable.name}{unit}')


def _panels(plt: Any, count: int, title: str) -> tuple[Any, Any]:
    figure, axes = plt.subplots(
        count, 1, figsize=(9.0, 1.4 + 1.9 * count), sharex=True, squeeze=False,
        layout='constrained',
    )  # fmt: skip
    figure.suptitle(title, x=0.01, ha='left', fontweight='bold')
    return figure, axes[:, 0]


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


def _legend(figure: Any, *, dots: bool, jumps: bool, path: bool | None = None) -> None:
    """Explain what is drawn; `path` is None where there are no measurements either."""
    lines = require('matplotlib.lines', 'drawing')
    style = {'linestyle': '', 'color': '0.3', 'markersize': 4}
    entries = (
        [
            lines.Line2D([], [], marker='o', label='confirmed', **style),
            lines.Line2D([], [], marker='o', markerfacecolor='white', label='in doubt', **style),
            lines.Line2D([], [], marker='x', label='no sd', **style),
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
        entries.append(lines.Line2D([], [], color='#b01030', linestyle='--', label='jump'))
    if entries:
        figure.legend(handles=entries, loc='outside upper right', ncols=len(entries), frameon=False,
                      columnspacing=1.2, handletextpad=0.4)  # fmt: skip


def _finish(plt: Any, figure: Any, axes: Any, account: Account, path: Path) -> None:
    for ax in axes:
        ax.grid(alpha=0.25)
    since = '' if not account.first else f' since {account.first / 1e9:.3f}'
    axes[-1].set_xlabel(f'time (s{since})')
    figure.align_ylabels(axes)
    figure.savefig(path, dpi=120, metadata={'Software': None})
    plt.close(figure)
