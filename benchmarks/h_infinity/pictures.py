"""Picture of the tyre's stiffness; needs Matplotlib."""

from typing import Any

from benchmarks.h_infinity.run import CASES, contestants, observed
from benchmarks.report import panels


def draw_stiffness(seed: int) -> Any:
    """Draw kt over time, a panel per case."""
    figure, grid = panels(2, 3, (15.0, 7.0))
    for axes, case in zip(grid.flat, CASES, strict=False):
        for one in contestants(case):
            t, found, kt, _ = observed(one, case, seed)
            axes.plot(t[::20], 1e-3 * found[::20], lw=1.0, label=one.label)
        axes.plot(t[::20], 1e-3 * kt[::20], 'k--', lw=1.2, label='truth')
        axes.set(title=f'{case.label}: kt (kN/m)', ylim=(100.0, 420.0))
        axes.grid(alpha=0.3)
    handles, labels = grid[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc='outside lower center', ncols=4, fontsize=9)
    return figure
