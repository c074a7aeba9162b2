"""Pictures of the genetic adaptive state estimator, as the paper has them; needs Matplotlib."""

from typing import Any

from benchmarks.papers.gremling.plan import DEFAULT, EKF, JETS, LINEAR, LUENBERGER, PAPER, Outcomes
from benchmarks.report import panels

MARGIN = 0.35  # beyond the truth, of its range
SHOWN = 25.0  # s: of the linear plants' 100 s, too, or curves would run together


def draw(outcomes: Outcomes) -> Any:
    """Draw hidden states, true and estimated, against time, one column a plant: first runs."""
    plants = {
        **{name: (title, ('x2', 'x3'), LUENBERGER) for name, title in LINEAR.items()},
        **{name: (f'jet engine, {case}', ('R', 'Phi'), EKF) for name, case in JETS.items()},
    }
    figure, grid = panels(2, len(plants), (18.0, 8.0), sharex='col')
    for (scenario, (title, states, other)), column in zip(plants.items(), grid.T, strict=True):
        traces = {way: outcomes[scenario, way][0].trace for way in (PAPER, DEFAULT, other)}
        for i, (axes, state) in enumerate(zip(column, states, strict=True), 1):
            for way, shown in traces.items():
                assert shown is not None
                axes.plot(shown.t, shown.x[:, i], lw=0.9, label=way)
            axes.plot(shown.t, shown.truth[:, i], 'k--', lw=1.1, label='truth')
            low, high = shown.truth[:, i].min(), shown.truth[:, i].max()
            margin = MARGIN * (high - low)
            axes.set(ylim=(low - margin, high + margin), xlim=(0.0, SHOWN), ylabel=state)
            axes.grid(alpha=0.3)
        column[0].set_title(title)
        column[0].legend(fontsize=7, loc='upper right')
        column[-1].set_xlabel('t (s)')
    return figure
