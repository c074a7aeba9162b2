"""Pictures of errors beside time."""

from collections.abc import Sequence
from typing import Any

from benchmarks.integrators.curves import Point
from benchmarks.report import panels

COLOURS = {
    'rk4': 'C0', 'rosenbrock': 'C3', 'rosenbrock, own steps': 'C6', 'Radau': 'C2', 'BDF': 'C4',
    'LSODA': 'C5', 'IDAS': 'C1',
}  # fmt: skip


def errors(points: Sequence[Point]) -> Any:
    """Return the figure: one panel for each plant."""
    plants = list(dict.fromkeys(point.plant for point in points))
    figure, axes = panels(1, len(plants), (3.2 * len(plants), 3.6), sharey=True)
    for ax, plant in zip(axes[0], plants, strict=True):
        for method in dict.fromkeys(point.method for point in points):
            own = [p for p in points if (p.plant, p.method) == (plant, method) and p.error < 10.0]
            ax.loglog(
                [p.nanoseconds for p in own], [max(p.error, 1e-12) for p in own], 'o-',
                color=COLOURS.get(method, 'k'), markersize=3, label=method,
            )  # fmt: skip
        ax.set_title(plant, fontsize=9)
        ax.set_xlabel('ns per candidate and sample')
        ax.grid(alpha=0.3)
    axes[0][0].set_ylabel("error, shares of the outputs' deviation")
    axes[0][-1].legend(fontsize=7, loc='center left', bbox_to_anchor=(1.02, 0.5))
    return figure
