"""Pictures of the genetic observers, as the papers have them; needs Matplotlib."""

from typing import Any

from benchmarks.genetic_papers.plan import JETS, MINIMUM, NON_MINIMUM, SCENARIOS_1995, Outcomes
from benchmarks.report import panels

MOST_ERROR = 1.0  # what the axes show
MARGIN = 0.35  # beyond the truth, of its range
SHOWN = 25.0  # s: of the linear plants' 100 s, too, or curves would run together


def draw_gao(outcomes: Outcomes) -> Any:
    """Draw errors and gains of the genetic adaptive observer against time, by scenario."""
    figure, grid = panels(3, len(SCENARIOS_1995), (18.0, 9.0), sharex=True, sharey='row')
    for (scenario, name), (errors, *gains) in zip(SCENARIOS_1995.items(), grid.T, strict=True):
        shown, frozen = (outcomes[scenario, way][0] for way in ('GAO', 'GAO, frozen'))
        for label, one, i, style in (
            ('x2', shown, 1, 'C0'), ('x1', shown, 0, 'C1'), ('x2, frozen', frozen, 1, 'k')
        ):  # fmt: skip
            errors.plot(one.t, one.x[:, i] - one.truth[:, i], style, lw=0.8, label=label)
        errors.set(title=name, ylim=(-MOST_ERROR, MOST_ERROR))
        for i, axes in enumerate(gains, 1):
            row = shown.figures[:, shown.figure_names.index(f'L{i}')]
            # Dots: the best gains change with every sample, and lines would fill the axes.
            axes.plot(shown.t, row, f'C{2 - i}.', ms=1.5, label=f'L{i}')
        gains[-1].set_xlabel('t (s)')
        finish(errors, *gains)
    for axes, label in zip(grid[:, 0], ('estimate less truth', 'L1', 'L2'), strict=True):
        axes.set_ylabel(label)
    return figure


def draw_gase(outcomes: Outcomes) -> Any:
    """Draw hidden states, true and estimated, against time, one column a plant."""
    plants = {
        MINIMUM: ('minimum phase', ('x2', 'x3'), 'adaptive Luenberger'),
        NON_MINIMUM: ('non-minimum phase', ('x2', 'x3'), 'adaptive Luenberger'),
        **{name: (f'jet engine, {case}', ('R', 'Phi'), 'joint EKF') for name, case in JETS.items()},
    }
    figure, grid = panels(2, len(plants), (18.0, 8.0), sharex='col')
    for (scenario, (title, states, other)), column in zip(plants.items(), grid.T, strict=True):
        for i, (axes, state) in enumerate(zip(column, states, strict=True), 1):
            true = outcomes[scenario, 'GASE, paper'][0]
            for way in ('GASE, paper', 'GASE, window_end', other):
                shown = outcomes[scenario, way][0]
                axes.plot(shown.t, shown.x[:, i], lw=0.9, label=way)
            axes.plot(true.t, true.truth[:, i], 'k--', lw=1.1, label='truth')
            low, high = true.truth[:, i].min(), true.truth[:, i].max()
            margin = MARGIN * (high - low)
            axes.set(ylim=(low - margin, high + margin), xlim=(0.0, SHOWN), ylabel=state)
        column[0].set_title(title)
        column[-1].set_xlabel('t (s)')
        finish(*column)
    return figure


def finish(*all_axes: Any) -> None:
    """Give axes a grid, and those on top a legend."""
    for axes in all_axes:
        axes.grid(alpha=0.3)
    all_axes[0].legend(fontsize=7, loc='upper right')
