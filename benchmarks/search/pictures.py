"""Pictures of search.py; needs matplotlib."""

from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from benchmarks.search.contest import DEADLINES, RIVALS, WAYS, limited_name
from benchmarks.search.report import HARD, plain, pooled, success

if TYPE_CHECKING:
    from benchmarks.search.run import Verdicts

matplotlib.use('Agg')


def draw_success(path: Path, verdicts: 'Verdicts') -> None:
    """Draw the share of windows at the optimum: a group of bars per case, a bar per method."""
    figure = Figure(figsize=(1.1 * len(verdicts) + 3.0, 5.0), layout='constrained')
    axes = figure.subplots()
    middle, width = np.arange(len(verdicts)), 0.8 / len(WAYS)
    for i, way in enumerate(WAYS):
        height = [success(own, way) for own in verdicts.values()]
        axes.bar(middle + (i + 0.5) * width - 0.4, height, width, label=way)
    axes.set_xticks(middle, list(verdicts), rotation=30, ha='right')
    axes.set_ylabel('windows at the optimum (%)')
    axes.grid(axis='y', alpha=0.3)
    figure.legend(loc='outside upper center', ncols=len(WAYS), fontsize=9)
    figure.savefig(path, dpi=110)


def draw_deadlines(path: Path, verdicts: 'Verdicts') -> None:
    """Draw the share of windows at the optimum against the process time allowed."""
    panels = {'the plain cases': plain(verdicts), **{c: [c] for c in HARD if c in verdicts}}
    panels = {title: cases for title, cases in panels.items() if cases}
    figure = Figure(figsize=(3.4 * max(2, len(panels)), 3.8), layout='constrained')
    grid = figure.subplots(1, max(1, len(panels)), squeeze=False, sharey=True)[0]
    for axes, (title, cases) in zip(grid, panels.items(), strict=False):
        own = pooled(verdicts, cases)
        for way in RIVALS:
            height = [success(own, limited_name(way, s)) for s in DEADLINES]
            axes.plot([1e3 * s for s in DEADLINES], height, 'o-', label=way)
        axes.set(xscale='log', title=title, xlabel='process time allowed (ms)', ylim=(-3, 103))
        axes.set_xticks([1e3 * s for s in DEADLINES], [f'{1e3 * s:g}' for s in DEADLINES])
        axes.grid(alpha=0.3)
    figure.axes[0].set_ylabel('windows at the optimum (%)')
    figure.axes[0].legend(fontsize=9)
    figure.savefig(path, dpi=110)
