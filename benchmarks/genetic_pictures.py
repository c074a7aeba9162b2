"""Pictures of genetic_papers.py; needs matplotlib."""

from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from benchmarks.genetic_papers import JETS, MINIMUM, NON_MINIMUM, SCENARIOS_1995, Outcomes

matplotlib.use('Agg')
MOST_ERROR = 2.0  # what the axes show


def draw_gao(path: Path, outcomes: Outcomes) -> None:
    """Draw errors and gains of the genetic adaptive observer against time, by scenario."""
    figure = Figure(figsize=(20, 7), layout='constrained')
    grid = figure.subplots(2, len(SCENARIOS_1995), sharex=True)
    for (scenario, name), (errors, gains) in zip(SCENARIOS_1995.items(), grid.T, strict=True):
        shown = outcomes[scenario, 'GAO'][0]
        for i in (1, 0):
            errors.plot(shown.t, shown.x[:, i] - shown.truth[:, i], lw=0.7, label=f'x{i + 1}')
            gain = shown.figures[:, shown.figure_names.index(f'L{i + 1}')]
            gains.plot(shown.t, gain, lw=0.5, label=f'L{i + 1}')
        frozen = outcomes[scenario, 'GAO, frozen'][0]
        difference = frozen.x[:, 1] - frozen.truth[:, 1]
        errors.plot(frozen.t, difference, 'k', lw=0.7, label='x2, frozen')
        errors.set(title=name, ylim=(-MOST_ERROR, MOST_ERROR))
        gains.set_xlabel('t (s)')
        finish(errors, gains)
    grid[0, 0].set_ylabel('estimate less truth')
    grid[1, 0].set_ylabel('gains')
    figure.savefig(path, dpi=90)


def draw_gase(path: Path, outcomes: Outcomes) -> None:
    """Draw hidden states, true and estimated, against time, one column a plant."""
    plants = {
        MINIMUM: ('minimum phase', ('x2', 'x3'), 'adaptive Luenberger'),
        NON_MINIMUM: ('non-minimum phase', ('x2', 'x3'), 'adaptive Luenberger'),
        **{name: (f'jet engine, {case}', ('R', 'Phi'), 'joint EKF') for name, case in JETS.items()},
    }
    figure = Figure(figsize=(20, 8), layout='constrained')
    grid = figure.subplots(2, len(plants), sharex='col')
    for (scenario, (title, states, other)), column in zip(plants.items(), grid.T, strict=True):
        for i, (axes, state) in enumerate(zip(column, states, strict=True), 1):
            true = outcomes[scenario, 'GASE, paper'][0]
            axes.plot(true.t, true.truth[:, i], 'k:', lw=1.2, label='truth')
            for way in ('GASE, paper', 'GASE, window_end', other):
                shown = outcomes[scenario, way][0]
                axes.plot(shown.t, shown.x[:, i], lw=0.7, label=way)
            low, high = np.min(true.truth[:, i]), np.max(true.truth[:, i])
            axes.set_ylim(low - 0.7 * (high - low), high + 0.7 * (high - low))
            axes.set_ylabel(state)
        column[0].set_title(title)
        column[-1].set_xlabel('t (s)')
        finish(*column)
    figure.savefig(path, dpi=90)


def finish(*all_axes: Axes) -> None:
    """Give axes a grid and a legend."""
    for axes in all_axes:
        axes.grid(alpha=0.3)
        axes.legend(fontsize=7, loc='upper right')
