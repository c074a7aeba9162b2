"""Pictures of the contest; needs Matplotlib."""

from typing import Any

import numpy as np

from benchmarks.report import panels
from benchmarks.search.contest import DEADLINES, RIVALS, WAYS, Verdicts, limited_name
from benchmarks.search.report import HARD, plain, pooled, success


def draw_success(verdicts: Verdicts) -> Any:
    """Draw the share of windows at the optimum: a group of bars per case, a bar per method."""
    figure, ((axes,),) = panels(1, 1, (1.1 * len(verdicts) + 3.0, 5.0))
    middle, width = np.arange(len(verdicts)), 0.8 / len(WAYS)
    for i, way in enumerate(WAYS):
        height = [success(own, way) for own in verdicts.values()]
        axes.bar(middle + (i + 0.5) * width - 0.4, height, width, label=way)
    axes.set_xticks(middle, list(verdicts), rotation=30, ha='right')
    axes.set_ylabel('windows at the optimum (%)')
    axes.grid(axis='y', alpha=0.3)
    figure.legend(loc='outside upper center', ncols=len(WAYS), fontsize=9)
    return figure


def draw_deadlines(verdicts: Verdicts) -> Any:
    """Draw the share of windows at the optimum against the process time allowed."""
    groups = {'the plain cases': plain(verdicts), **{c: [c] for c in HARD if c in verdicts}}
    groups = {title: cases for title, cases in groups.items() if cases}
    figure, (row,) = panels(1, len(groups), (3.4 * max(2, len(groups)), 3.8), sharey=True)
    for axes, (title, cases) in zip(row, groups.items(), strict=True):
        own = pooled(verdicts, cases)
        for way in RIVALS:
            height = [success(own, limited_name(way, s)) for s in DEADLINES]
            axes.plot([1e3 * s for s in DEADLINES], height, 'o-', label=way)
        axes.set(xscale='log', title=title, xlabel='process time allowed (ms)', ylim=(-3, 103))
        axes.set_xticks([1e3 * s for s in DEADLINES], [f'{1e3 * s:g}' for s in DEADLINES])
        axes.grid(alpha=0.3)
    figure.axes[0].set_ylabel('windows at the optimum (%)')
    figure.axes[0].legend(fontsize=9)
    return figure
