"""Picture of the growth; needs Matplotlib."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks.report import panels
from benchmarks.scaling.curve import Curve


def draw_scaling(curves: Sequence[Curve]) -> Any:
    """Draw every growth on its own panel, beside linear growth from the last point."""
    figure, grid = panels(2, 3, (12.0, 7.0))
    for axes, curve in zip(grid.flat, curves, strict=False):
        x, ms = np.array(curve.x), 1e3 * np.array(curve.seconds)
        axes.loglog(x, ms, 'o-', label=f'exponent {curve.exponents[0]:.2f}')
        axes.loglog(x, ms[-1] * x / x[-1], 'k--', lw=1, label='linear')
        axes.set(title=curve.title, xlabel=curve.x_name, ylabel='process time (ms)')
        axes.set_xticks(x, [f'{one:g}' for one in curve.x])
        axes.set_xticks([], minor=True)
        axes.grid(alpha=0.3)
        axes.legend(fontsize=9)
    return figure
