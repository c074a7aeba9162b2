"""Pictures of a replay: parameters and states with their intervals, residuals, forecast errors."""

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from obs_ros.core.model import Variable
from obs_ros.core.periods import within
from obs_ros.core.typing import Array, IntArray
from obs_ros.replay.engine import Account
from obs_ros.replay.extras import require
from obs_ros.replay.fitted import fitted_outputs, outputs_of_states
from obs_ros.replay.panels import (
    COLOURS,
    JUMP_COLOUR,
    SETTINGS,
    STYLE,
    Band,
    broken,
    dots,
    finish,
    label,
    legend,
    limit,
    panels,
    usual,
    wraps,
)  # fmt: skip

INTERVALS = '95 % intervals'
UNBOUNDED = (-math.inf, math.inf)
CONFIRMED = ('converged', 'approximate', 'at_bound')


def draw(account: Account, folder: Path) -> None:
    """Write parameters.png, states.png and misfit.png; nothing without estimates.

    Raises MissingPackageError without Matplotlib.
    """
    require('matplotlib', 'drawing').use('Agg')
    plt = require('matplotlib.pyplot', 'drawing')
    for name, figure in figures(plt, account):
        figure.savefig(folder / name, dpi=120, metadata={'Software': None})
        plt.close(figure)


def figures(plt: Any, account: Account) -> Iterator[tuple[str, Any]]:
    """Yield the figures by the names of their files; `plt` is matplotlib.pyplot."""
    if not len(account.history):
        return
    with plt.rc_context(STYLE):
        if account.history.model.parameters:
            yield 'parameters.png', _parameters(plt, account)
        yield 'states.png', _states(plt, account)
        yield 'misfit.png', _misfit(plt, account)


def _parameters(plt: Any, account: Account) -> Any:
    """Draw each parameter, estimate by estimate, with its band."""
    history = account.history
    variables, times = history.model.parameters, _times(account)[0]
    figure, axes = panels(plt, len(variables), f'Parameters, {INTERVALS}')
    for k, (variable, ax) in enumerate(zip(variables, axes, strict=True)):
        place, colour = len(history.model.states) + k, COLOURS[k % len(COLOURS)]
        band = _estimates(ax, account, place, colour, joined=True)
        label(ax, variable)
        limit(ax, band.value, (variable.lower, variable.upper), band.usual_reach)
    jumps = _draw_jumps(account, axes, variables)
    legend(figure, dots=times.size <= SETTINGS.marked, jumps=jumps)
    finish(figure, axes, account.first)
    return figure


def _states(plt: Any, account: Account) -> Any:
    """Draw the states that the fits found, what was measured, and the estimates with their bands.

    Outputs that are no state have panels of their own, below.
    """
    history = account.history
    model, times = history.model, _times(account)[0]
    shown = outputs_of_states(model)
    others = [k for k in range(len(model.outputs)) if k not in shown.values()]
    title = 'States and outputs' if others else 'States'
    figure, axes = panels(plt, len(model.states) + len(others), f'{title}, {INTERVALS}')
    along = _seconds(account, history.path.stamps)
    for place, (variable, ax) in enumerate(zip(model.states, axes, strict=False)):
        colour, fitted = COLOURS[place % len(COLOURS)], history.path.rows[:, place]
        measured = _measured(ax, account, shown[place]) if place in shown else np.empty(0)
        ax.plot(*broken(along, fitted, variable.period), color=colour, linewidth=0.9)
        band = _estimates(ax, account, place, colour, joined=account.horizon is None)
        label(ax, variable)
        seen = np.concatenate([band.value, fitted, usual(measured)])
        limit(ax, seen, UNBOUNDED, band.usual_reach)
    fits = fitted_outputs(history)
    for k, ax in zip(others, axes[len(model.states) :], strict=True):
        measured = _measured(ax, account, k)
        line = broken(along, fits[:, k], model.outputs[k].period)
        ax.plot(*line, color='0.2', linewidth=0.9)
        label(ax, model.outputs[k])
        limit(ax, np.concatenate([fits[:, k], usual(measured)]), UNBOUNDED)
    jumps = _draw_jumps(account, axes, model.variables)
    few, windows = times.size <= SETTINGS.marked, account.horizon is not None
    legend(figure, dots=few, jumps=jumps, path=windows)
    finish(figure, axes, account.first)
    return figure


def _estimates(ax: Any, account: Account, place: int, colour: str, *, joined: bool) -> Band:
    """Draw the estimates of one unknown with their intervals, `joined` to a band; return these."""
    history = account.history
    times, shown = _times(account)
    band = Band(*(history.rows(kind)[shown][:, place] for kind in ('values', 'lower', 'upper')))
    confirmed = np.isin(np.array(history.outcome_of)[shown], CONFIRMED)
    if joined:
        at = wraps(band.value, history.model.variables[place].period)
        along, value, lower, upper = (
            np.insert(each, at, math.nan) for each in (times, band.value, band.lower, band.upper)
        )
        ax.plot(along, value, color=colour, linewidth=0.8, alpha=0.5)
        ax.fill_between(along, lower, upper, color=colour, alpha=0.18, lw=0)
    if times.size <= SETTINGS.marked:
        ax.errorbar(times, band.value, band.reach, fmt='none', ecolor=colour,
                    elinewidth=0.8, alpha=0.6)  # fmt: skip
    dots(ax, times, band.value, confirmed, band.known, colour)
    return band


def _measured(ax: Any, account: Account, output: int) -> Array:
    """Draw what was measured of an output, and return it."""
    trace = account.history.measured
    period = np.asarray(account.history.model.outputs[output].period or 0.0)
    values = within(trace.rows[:, output], period)
    ax.plot(_seconds(account, trace.stamps), values, linestyle='', marker='.', markersize=4,
            color='0.68', zorder=0)  # fmt: skip
    return values[np.isfinite(values)]


def _draw_jumps(account: Account, axes: Any, variables: Sequence[Variable]) -> bool:
    """Mark the jumps of the parameters shown, each in its panel, or in all; whether there were.

    Those that were taken back are left out.
    """
    names = [variable.name for variable in variables]
    found = [jump for jump in account.history.standing if set(jump.sizes) & set(names)]
    own = len(names) == len(axes)
    for jump in found:
        for name, ax in zip(names, axes, strict=True) if own else ((None, ax) for ax in axes):
            if name is None or name in jump.sizes:
                ax.axvline(_since(account, jump.stamp), color=JUMP_COLOUR, linestyle='--', lw=1)
    return bool(found)


def _misfit(plt: Any, account: Account) -> Any:
    """Draw residuals and forecast errors by output, or the innovation of immediate observers."""
    history = account.history
    times, shown = _times(account)
    if account.horizon is None:
        figure, axes = panels(plt, 1, 'Innovation: outputs less what was expected')
        axes[0].plot(times, history.rows('rms')[shown][:, 0], color=COLOURS[0], linewidth=0.8)
        axes[0].set_ylabel('root mean square')
        finish(figure, axes, account.first)
        return figure
    outputs = history.model.outputs
    figure, axes = panels(plt, len(outputs), 'Residuals of windows, errors of their forecasts')
    kinds = (
        ('residuals', 'residual of the window', COLOURS[0], '-'),
        ('forecasts', f'forecast error over the next {account.horizon:g} s', COLOURS[1], '-'),
        ('held', 'the same, last value held', '0.6', ':'),
    )
    for place, (variable, ax) in enumerate(zip(outputs, axes, strict=True)):
        for kind, words, colour, style in kinds:
            rms = history.rows(kind)[shown][:, place]
            rms = np.where(np.isfinite(rms) & (rms > 0.0), rms, np.nan)
            marker = 'o' if times.size <= SETTINGS.marked else None
            ax.plot(times, rms, color=colour, linestyle=style, linewidth=1.2, label=words,
                    marker=marker, markersize=3)  # fmt: skip
        ax.set_yscale('log')
        label(ax, variable, 'rms of ')
    axes[0].legend(loc='lower center', bbox_to_anchor=(0.5, 1.0), ncols=3, frameon=False)
    finish(figure, axes, account.first)
    return figure


def _times(account: Account) -> tuple[Array, Any]:
    """Return seconds since the first sample, of the estimates shown: all, or some of very many."""
    stamps = account.history.stamps
    shown = slice(None, None, max(1, -(-len(stamps) // SETTINGS.most_points)))
    return np.array([_since(account, int(stamp)) for stamp in stamps[shown]]), shown


def _seconds(account: Account, stamps: IntArray) -> Array:
    return (stamps - (account.first or 0)) / 1e9


def _since(account: Account, stamp: int | None) -> float:
    return ((stamp or 0) - (account.first or 0)) / 1e9
