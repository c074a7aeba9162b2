"""Pictures of the tyre's stiffness and of the outputs under the force; needs Matplotlib."""

from typing import Any

from benchmarks.papers.alvarado.roads import CASES, noisy, truth_of
from benchmarks.papers.alvarado.run import CONTESTANTS, observed
from benchmarks.report import panels

EVERY = 20  # samples


def draw_stiffness(seed: int) -> Any:
    """Draw kt over time, a panel per drive."""
    figure, grid = panels(1, len(CASES), (15.0, 4.5))
    for axes, case in zip(grid.flat, CASES, strict=True):
        truth = truth_of(case.scenario, case.force > 0.0, case.begin, case.end)
        y = noisy(case, truth, seed)
        for one in CONTESTANTS:
            found = observed(one, case, truth, y, seed).kt
            axes.plot(truth.t[::EVERY], 1e-3 * found[::EVERY], lw=1.0, label=one.label)
        axes.plot(truth.t[::EVERY], 1e-3 * truth.kt[::EVERY], 'k--', lw=1.2, label='truth')
        axes.set(title=f'{case.label}: kt (kN/m)', ylim=(100.0, 420.0), xlabel='s')
        axes.grid(alpha=0.3)
    handles, labels = grid[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc='outside lower center', ncols=3, fontsize=9)
    return figure
