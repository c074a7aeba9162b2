"""Tables of the genetic adaptive state estimator beside the paper's and beside filters."""

import numpy as np

from benchmarks.papers.claims import share
from benchmarks.papers.gremling.claims import (
    LUENBERGER_SUMS,
    LUENBERGER_WITHIN,
    PRINTED_RUNS,
    TABLES,
)
from benchmarks.papers.gremling.plan import JETS, LINEAR, LUENBERGER, PAPER, Outcomes, ways
from benchmarks.papers.gremling.run import OTHERS, Figures
from benchmarks.papers.gremling.scores import (
    largest_text,
    mean_text,
    squares,
    unbounded,
    undetected,
)
from benchmarks.report import Requirement, filled, requirements, slashed, table

WITHIN = 0.3  # of the paper's means


def report(figures: Figures) -> str:
    """Return the tables below the claims."""
    return filled(
        'papers/gremling/report',
        runs=PRINTED_RUNS,
        fewer=OTHERS,
        linear=linear_table(figures.outcomes),
        asked=requirements(asked(figures.outcomes)),
        jet=jet_table(figures.outcomes),
        filters=filters_table(figures),
    )


def linear_table(outcomes: Outcomes) -> str:
    """Tell sums of squared errors on the linear plants, beside the paper's."""
    rows = []
    for scenario, name in LINEAR.items():
        printed = {PAPER: TABLES[scenario][1], LUENBERGER: LUENBERGER_SUMS[scenario][1]}
        for way in ways(scenario):
            own = squares(outcomes, scenario, way.label)
            least, most = slashed(own.min(axis=0), '.0f'), slashed(own.max(axis=0), '.0f')
            rows.append({
                'plant': name,
                'observer': way.label,
                'runs': len(own),
                'Es x2 / x3, mean': mean_text(own),
                'from - to': f'{least} to {most}' if len(own) > 1 else '',
                "the paper's mean": slashed(printed.get(way.label, ()), '.0f'),
                'largest error x1 / x2 / x3': largest_text(outcomes, scenario, way.label),
            })  # fmt: skip
    return table(rows)


def asked(outcomes: Outcomes) -> list[Requirement]:
    """Judge the sums of squared errors by those that the paper prints."""
    rows = []
    for scenario, name in LINEAR.items():
        for label, printed, within in (
            (PAPER, TABLES[scenario][1], WITHIN),
            (LUENBERGER, LUENBERGER_SUMS[scenario][1], LUENBERGER_WITHIN),
        ):
            off = squares(outcomes, scenario, label).mean(axis=0) / printed - 1.0
            asked = f"{name}: {label} within {100.0 * within:g} % of the paper's means"
            told = slashed(100.0 * off, '+.1f') + ' %'
            rows.append(Requirement(asked, told, bool((np.abs(off) <= within).all())))
    return rows


def jet_table(outcomes: Outcomes) -> str:
    """Tell errors and failures on the jet engine."""
    rows = []
    for scenario, name in JETS.items():
        for way in ways(scenario):
            found = outcomes[scenario, way.label]
            lost, missed = sum(map(unbounded, found)), sum(map(undetected, found))
            several = len(found) > 1
            rows.append({
                'case': name,
                'observer': way.label,
                'runs': len(found),
                'Es R / Phi, mean': mean_text(squares(outcomes, scenario, way.label), '.3g'),
                'largest error Psi / R / Phi': largest_text(outcomes, scenario, way.label),
                'lost': share(lost, len(found)) if several else lost,
                'growth of R missed': share(missed, len(found)) if several else missed,
            })  # fmt: skip
    return table(rows)


def filters_table(figures: Figures) -> str:
    """Tell by variance of the process noise how many extended Kalman filters are unstable."""
    rows = []
    for process in sorted({one.process for one in figures.filters}):
        row = {'process variance': f'{process:g}'}
        for kept in (True, False):
            bad = [
                unstable for one, unstable in figures.filters.items()
                if (one.process, one.kept) == (process, kept)
            ]  # fmt: skip
            row[f'unstable, {"R >= 0 kept" if kept else "R free"}'] = f'{sum(bad)} of {len(bad)}'
        rows.append(row)
    return table(rows)
