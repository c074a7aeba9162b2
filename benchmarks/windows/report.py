"""Tables of the random windows."""

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np

from benchmarks.judge import FINER
from benchmarks.report import Requirement, filled, quantiles, requirements, rms, table
from benchmarks.tanks import noise_of
from benchmarks.windows.run import (
    FULL_WINDOW,
    INTERIOR,
    KNOWLEDGE,
    SOLVED,
    UNKNOWNS,
    YARDSTICK_LANES,
    Solved,
    Verdict,
)
from obs_ros import Outcome

# Process time in ms, median and 95th percentile (issues 2 and 3).
TIME_LIMITS = {'full': (10.0, 20.0), 'short': (1.5, np.inf)}
PLAIN_LIMIT = 1.3  # median ratio of times, with the default process noise and without
EFFICIENCY_LIMIT = 1.05  # RMSE over the Cramér-Rao bound


def report(sections: Sequence[str], seeds: Sequence[int], samples: int, starts: int) -> str:
    """Return the report of a section for every noise level."""
    return filled(
        'windows/report',
        count=len(seeds),
        first=seeds[0],
        samples=samples,
        starts=starts,
        solved=SOLVED,
        finer=FINER,
        sections='\n\n'.join(sections),
    )


def section(
    snr: float,
    samples: int,
    seeds: Sequence[int],
    solved: Mapping[str, Sequence[Solved]],
    verdicts: Sequence[Verdict],
) -> str:
    """Return the report's section on one noise level."""
    lost = [
        f'- seed {seeds[i]}, noise {known}: {v.excess[known]:.3g} sigma^2, '
        f'{solved[known][i].estimate.outcome} ({solved[known][i].estimate.message})'
        for i, v in enumerate(verdicts)
        for known in KNOWLEDGE
        if not v.excess[known] <= SOLVED
    ]
    return filled(
        'windows/section',
        snr=snr,
        sigma=noise_of(snr),
        search=search_table(solved, verdicts),
        lanes=YARDSTICK_LANES,
        full=FULL_WINDOW,
        yardstick=1e6 * np.median([one.yardstick for one in solved['known']]),
        requirements=requirements(asked(samples, solved, verdicts)),
        interior=INTERIOR,
        efficiency_limit=EFFICIENCY_LIMIT,
        efficiency=efficiency_table(verdicts),
        lost='\n'.join(['Not solved:\n', *lost]) if lost else '',
    )


def asked(
    samples: int, solved: Mapping[str, Sequence[Solved]], verdicts: Sequence[Verdict]
) -> list[Requirement]:
    """Judge success and process times, whether the noise is known or not."""
    limits = TIME_LIMITS['full' if samples >= FULL_WINDOW else 'short']
    rows = []
    for known in KNOWLEDGE:
        lost = sum(not verdict.excess[known] <= SOLVED for verdict in verdicts)
        rows.append(Requirement(f'noise {known}: all solved', f'{lost} not', lost == 0))
        times = 1e3 * np.array(quantiles(one.seconds for one in solved[known]))
        for name, time, limit in zip(('median', 'p95'), times, limits, strict=True):
            if np.isfinite(limit):
                claim = f'noise {known}: {name} <= {limit:g} ms'
                rows.append(Requirement(claim, f'{time:.1f} ms', time <= limit))
        ratio = float(np.median([one.seconds / one.plain for one in solved[known]]))
        claim = f'noise {known}: <= {PLAIN_LIMIT:g} x the time without process noise'
        rows.append(Requirement(claim, f'{ratio:.2f}', ratio <= PLAIN_LIMIT))
    return rows


def search_table(solved: Mapping[str, Sequence[Solved]], verdicts: Sequence[Verdict]) -> str:
    """Tell how many windows were solved, the time, and the verdicts of the search."""
    rows = []
    for known in KNOWLEDGE:
        estimates = [one.estimate for one in solved[known]]
        excess = np.array([verdict.excess[known] for verdict in verdicts])
        lost = ~(excess <= SOLVED)
        accepted = [estimate.outcome == Outcome.CONVERGED for estimate in estimates]
        outcomes = Counter(str(estimate.outcome) for estimate in estimates)
        times = 1e3 * np.array(quantiles(one.seconds for one in solved[known]))
        yardsticks = np.median([one.seconds / one.yardstick for one in solved[known]])
        rows.append({
            'noise': known,
            'solved': f'{np.count_nonzero(~lost)}/{len(lost)}',
            'worst excess (sigma^2)': f'{excess.max():.2g}',
            'judge missed': np.count_nonzero(excess < -SOLVED),
            'converged but not solved': np.count_nonzero(lost & accepted),
            'outcomes': ', '.join(f'{count} {name}' for name, count in outcomes.most_common()),
            'median (ms)': f'{times[0]:.1f}',
            'p95 (ms)': f'{times[1]:.1f}',
            'median (yardsticks)': f'{yardsticks:.0f}',
            'evaluations': f'{np.median([estimate.evaluations for estimate in estimates]):.0f}',
        })  # fmt: skip
    return table(rows)


def efficiency_table(verdicts: Sequence[Verdict]) -> str:
    """Compare the errors with the Cramér-Rao bound where the box does not cut it."""
    interior = [verdict for verdict in verdicts if verdict.interior]
    groups = {
        'all': interior,
        'no levels cross': [verdict for verdict in interior if not verdict.crossing],
        'levels cross': [verdict for verdict in interior if verdict.crossing],
    }
    rows = []
    for label, chosen in groups.items():
        for known in KNOWLEDGE if chosen else ():
            ratios = np.array([verdict.ratios[known] for verdict in chosen])
            single = dict(zip(UNKNOWNS, (f'{one:.2f}' for one in rms(ratios, 0)), strict=True))
            rows.append(
                {'noise': known, 'windows': label, 'count': len(chosen),
                 'together': f'{rms(ratios):.3f}', **single}
            )  # fmt: skip
    return table(rows)
