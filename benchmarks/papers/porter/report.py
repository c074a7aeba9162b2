"""Tables of the genetic adaptive observer beside filters, and what is asked of it."""

from collections.abc import Sequence

import numpy as np

from benchmarks.intervals import share_interval
from benchmarks.papers.claims import share
from benchmarks.papers.observed import Outcome, diverged
from benchmarks.papers.porter.plan import (
    BRED,
    CASES,
    CLAMPED,
    LINEAR,
    PAPER,
    SCENARIOS,
    TRIES,
    Outcomes,
    ways,
)
from benchmarks.papers.porter.scores import DEFAULT, apart, errors, failed, median_text, unsettled
from benchmarks.report import Requirement, filled, requirements, table

MOST_RMS = {  # of x2, mean over the runs of the default
    'base': 0.08, 'chaotic': 0.08, 'Gaussian': 0.05, 'disturbed': 0.5, 'mismatch': 0.3
}  # fmt: skip
SETTLED = 2.5  # s, the median asked of the paper's mode on the linear plant


def report(outcomes: Outcomes) -> str:
    """Return the tables below the claims."""
    return filled(
        'papers/porter/report',
        rates=rates_table(outcomes),
        asked=requirements(asked(outcomes)),
        tries=TRIES,
        breeding=breeding_table(outcomes),
        choice=choice(outcomes),
    )


def rates_table(outcomes: Outcomes) -> str:
    """Tell failures, errors and settling times by scenario and observer."""
    return table(
        {'scenario': name, 'observer': way.label, **row(outcomes[scenario, way.label])}
        for scenario, name in SCENARIOS.items()
        for way in ways(scenario)
    )


def row(found: Sequence[Outcome]) -> dict[str, object]:
    """Return a row's figures."""
    counts = {
        'diverged': sum(map(diverged, found)),
        'failed': sum(map(failed, found)),
        'not settled': sum(map(unsettled, found)),
    }
    several = len(found) > 1
    return {
        'runs': len(found),
        **{name: share(n, len(found)) if several else n for name, n in counts.items()},
        'RMS x2, median': median_text(errors(found)),
        'settled at (s), median': median_text(one.settled for one in found),
        'frozen at (s), median': median_text(one.frozen for one in found),
    }


def breeding_table(outcomes: Outcomes) -> str:
    """Tell by case how gains that are clamped, and bred again, compare without a freeze."""
    pooled = {
        way: [one for case in CASES for one in outcomes[case, way]] for way in (CLAMPED, BRED)
    }
    rows = [(name, {way: outcomes[case, way] for way in pooled}) for case, name in CASES.items()]
    return table(
        {
            'scenario': name,
            **{f'diverged, {way}': share(sum(map(diverged, own)), len(own))
               for way, own in found.items()},
            **{f'RMS x2, {way}': median_text(errors(own)) for way, own in found.items()},
        }
        for name, found in [*rows, ('all', pooled)]
    )  # fmt: skip


def choice(outcomes: Outcomes) -> str:
    """Say which way is the default, and whether another one diverges less often."""
    other = BRED if DEFAULT == CLAMPED else CLAMPED
    lost = {
        way: sum(diverged(one) for case in CASES for one in outcomes[case, way])
        for way in (DEFAULT, other)
    }
    runs = sum(len(outcomes[case, DEFAULT]) for case in CASES)
    own, others = (share_interval(lost[way], runs) for way in (DEFAULT, other))
    if not apart(own, others):
        told = 'the intervals of their divergences overlap, so that neither is shown to be safer'
    else:
        told = f'it diverges {"less" if own < others else "**more**"} often than the other way'
    means = {
        way: sum(mean_error(outcomes[case, way]) <= MOST_RMS.get(name, np.inf)
                 for case, name in CASES.items())
        for way in lost
    }  # fmt: skip
    met = ', '.join(f'`{way}` {count} of {len(CASES)}' for way, count in means.items())
    return f'The default is `{DEFAULT}`: {told}. Mean RMS within what is asked below: {met}.'


def mean_error(found: Sequence[Outcome]) -> float:
    """Return the mean RMS error of x2 over the runs."""
    return float(np.mean(errors(found)))


def asked(outcomes: Outcomes) -> list[Requirement]:
    """Judge the default; nothing is asked of most of the others."""
    rows = []
    for scenario, name in CASES.items():
        found = outcomes[scenario, DEFAULT]
        lost, mean = sum(map(diverged, found)), mean_error(found)
        limit = MOST_RMS.get(name, np.inf)
        small = f', mean RMS <= {limit:g}' if np.isfinite(limit) else ''
        told = f'{share(lost, len(found))}, {mean:.3g}'
        met = lost == 0 and mean <= limit
        rows.append(Requirement(f'{name}: {DEFAULT} never diverges{small}', told, met))
    settled = [one.settled for one in outcomes[LINEAR, PAPER]]
    late, middle = sum(map(unsettled, outcomes[LINEAR, PAPER])), np.median(settled)
    told = f'{late} not, {middle:.3g} s'
    met = late == 0 and bool(middle <= SETTLED)
    return [
        *rows, Requirement(f'linear: {PAPER} always settles, median <= {SETTLED:g} s', told, met)
    ]  # fmt: skip
