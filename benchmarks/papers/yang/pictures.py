"""Pictures of the tables: errors against noise, and convergence; needs Matplotlib."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from benchmarks.judge import SAME_OPTIMUM
from benchmarks.papers.yang.convergence import FIRST_EVALUATIONS, Followed
from benchmarks.papers.yang.reference import SYMBOLS, Cell, printed_errors
from benchmarks.papers.yang.run import DEFAULT, PAPER, Errors, bounds
from benchmarks.report import panels
from benchmarks.tanks import noise_of

UNITS = {'p1': '', 'p2': '', 'p3': '', 'h3': ' (cm)'}
LABELS = {'ft1': 'paper mode, f_t1 (euclidean)', 'ft2': 'paper mode, f_t2 (correlation)'}
COLOURS = {'ft1': 'tab:blue', 'ft2': 'tab:orange', DEFAULT: 'tab:green'}
LEAST = 1e-4  # sigma^2; below, the searches are at the same point


def draw_errors(errors: Errors, cells: Sequence[Cell]) -> Any:
    """Draw median errors against SNR: a row per window, a column per unknown."""
    windows = sorted({cell.window for cell in cells})
    size = (13.0, 3.2 * len(windows) + 0.8)
    figure, grid = panels(len(windows), len(SYMBOLS), size, sharex=True)
    for window, row in zip(windows, grid, strict=True):
        for i, axes in enumerate(row):
            _error_lines(axes, errors, [c for c in cells if c.window == window], i)
            axes.set_yscale('log')
            axes.set_title(f'{window}: {SYMBOLS[i]}{UNITS[SYMBOLS[i]]}', fontsize=10)
            axes.grid(alpha=0.3)
    for axes in grid[-1]:
        axes.set_xlabel('SNR (dB)')
    handles, labels = grid[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc='outside lower center', ncols=4, fontsize=9)
    figure.suptitle(
        'Median absolute error, 4 unknowns (errors of 0, with the truth on a bound: not drawn)'
    )
    return figure


def _error_lines(axes: Any, errors: Errors, cells: Sequence[Cell], i: int) -> None:
    """Draw the errors of unknown i in one window."""
    noisy = [cell for cell in cells if np.isfinite(cell.snr_db)]
    for fitness in sorted({cell.fitness for cell in noisy}):
        own = sorted((c for c in noisy if c.fitness == fitness), key=lambda c: c.snr_db)
        snr = [cell.snr_db for cell in own]
        median = [np.median(errors[cell, PAPER][:, i]) for cell in own]
        axes.plot(snr, median, 'o-', color=COLOURS[fitness], label=LABELS[fitness])
        run = [printed_errors(cell)[i] or np.nan for cell in own]
        axes.plot(snr, run, 'x', color=COLOURS[fitness], label=f"the paper's run, {fitness}")
    own = sorted((c for c in noisy if (c, DEFAULT) in errors), key=lambda c: c.snr_db)
    snr = [cell.snr_db for cell in own]
    median = [np.median(errors[cell, DEFAULT][:, i]) for cell in own]
    axes.plot(snr, median, 's-', color=COLOURS[DEFAULT], label='default search')
    # The median of |error| of an efficient estimate is 0.6745 standard deviations.
    bound = [0.6745 * bounds(cell.window, 4)[i] * noise_of(cell.snr_db) for cell in own]
    axes.plot(snr, bound, 'k--', label='Cramér-Rao bound (as a median)')


def draw_convergence(followed: Mapping[tuple[str, str], Followed]) -> Any:
    """Draw the excess over the optimum against candidates, a panel per window."""
    windows = sorted({window for window, _ in followed})
    figure, (row,) = panels(1, len(windows), (4.3 * len(windows), 4.0), sharey=True)
    for axes, window in zip(row, windows, strict=True):
        for (name, method), run in followed.items():
            if name == window:
                axes.plot(run.evaluations, np.maximum(run.excess, LEAST), label=method)
        axes.axhline(SAME_OPTIMUM * len(SYMBOLS), color='k', ls='--', lw=1, label='solved')
        axes.set(
            xscale='log',
            yscale='log',
            title=window,
            xlabel='candidates',
            xlim=(FIRST_EVALUATIONS, None),
        )
        axes.grid(alpha=0.3)
    figure.axes[0].set_ylabel(r'excess of the squares ($\sigma^2$), median')
    figure.axes[0].legend(fontsize=9)
    return figure
