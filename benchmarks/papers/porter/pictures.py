"""Pictures of the genetic adaptive observer, as the paper has them; needs Matplotlib."""

from typing import Any

from benchmarks.papers.porter.plan import CASES, CLAMPED, PAPER, Outcomes
from benchmarks.report import panels

MOST_ERROR = 1.0  # what the axes show


def draw(outcomes: Outcomes) -> Any:
    """Draw errors and gains against time, by case: the first run of each."""
    figure, grid = panels(3, len(CASES), (18.0, 9.0), sharex=True, sharey='row')
    for (scenario, name), (errors, *gains) in zip(CASES.items(), grid.T, strict=True):
        going, frozen = (outcomes[scenario, way][0].trace for way in (CLAMPED, PAPER))
        assert going is not None and frozen is not None
        for label, one, i, style in (
            ('x2', going, 1, 'C0'), ('x1', going, 0, 'C1'), ("x2, the paper's mode", frozen, 1, 'k')
        ):  # fmt: skip
            errors.plot(one.t, one.x[:, i] - one.truth[:, i], style, lw=0.8, label=label)
        errors.set(title=name, ylim=(-MOST_ERROR, MOST_ERROR))
        for i, axes in enumerate(gains, 1):
            # Dots: the best gains change with every sample, and lines would fill the axes.
            axes.plot(going.t, going.figures[f'L{i}'], f'C{2 - i}.', ms=1.5, label=f'L{i}')
            axes.plot(frozen.t, frozen.figures[f'L{i}'], 'k', lw=0.8, label="the paper's mode")
        gains[-1].set_xlabel('t (s)')
        for axes in (errors, *gains):
            axes.grid(alpha=0.3)
        errors.legend(fontsize=7, loc='upper right')
    for axes, label in zip(grid[:, 0], ('estimate less truth', 'L1', 'L2'), strict=True):
        axes.set_ylabel(label)
    return figure
