"""Picture of scaling.py; needs matplotlib."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib
import numpy as np
from matplotlib.figure import Figure

if TYPE_CHECKING:
    from benchmarks.scaling.run import Curve

matplotlib.use('Agg')


def draw_scaling(path: Path, curves: Sequence['Curve']) -> None:
    """Draw every growth on its own panel, beside linear growth from the last point."""
    figure = Figure(figsize=(12.0, 7.0), layout='constrained')
    for axes, curve in zip(figure.subplots(2, 3).flat, curves, strict=False):
        x, ms = np.array(curve.x), 1e3 * np.array(curve.seconds)
        axes.loglog(x, ms, 'o-', label=f'exponent {curve.exponents[0]:.2f}')
        axes.loglog(x, ms[-1] * x / x[-1], 'k--', lw=1, label='linear')
        axes.set(title=curve.title, xlabel=curve.x_name, ylabel='process time (ms)')
        axes.set_xticks(x, [f'{one:g}' for one in curve.x])
        axes.set_xticks([], minor=True)
        axes.grid(alpha=0.3)
        axes.legend(fontsize=9)
    figure.savefig(path, dpi=110)
