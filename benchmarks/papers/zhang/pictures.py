"""Picture of the flows; needs Matplotlib."""

from typing import Any

from benchmarks.papers.zhang.plants import COLD, MOVING, PROCESS, UTILITY
from benchmarks.papers.zhang.run import CONTESTANTS, observed
from benchmarks.report import panels

CASES = (COLD, UTILITY, PROCESS, MOVING)
EVERY = 10  # samples


def draw_flows(seed: int) -> Any:
    """Draw estimated and true flows: a column per case, a row per flow."""
    figure, grid = panels(2, len(CASES), (18.0, 7.0))
    for column, case in enumerate(CASES):
        runs = {one.label: observed(one, case, None if case == COLD else seed)
                for one in CONTESTANTS}  # fmt: skip
        for row, name in enumerate(('Fp', 'Fu')):
            axes = grid[row, column]
            for label, run in runs.items():
                # The noise of the large gain would hide all others.
                below = 1 if label.endswith('80') else 2
                axes.plot(run.t[::EVERY], 1e6 * run.flows[::EVERY, row], lw=0.9, label=label,
                          zorder=below)  # fmt: skip
            axes.plot(run.t[::EVERY], 1e6 * run.truth[::EVERY, row], 'k--', lw=1.2, label='truth',
                      zorder=3)  # fmt: skip
            middle = 1e6 * run.truth[:, row]
            axes.set(ylim=(0.6 * middle.min(), 1.4 * middle.max()))
            noise = 'no noise' if case == COLD else 'noise of 0.05 K'
            axes.set_title(f'{case.label}, {noise}: {name} (1e-6 m3/s)', fontsize=9)
            axes.grid(alpha=0.3)
    for axes in grid[-1]:
        axes.set_xlabel('s')
    handles, labels = grid[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc='outside lower center', ncols=6, fontsize=9)
    return figure
