"""Tables of the random windows."""

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np

from benchmarks.report import Requirement, quantiles, requirements, rms, table
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
EFFICIENCY_LIMIT = 1.05  # RMSE over the Cramér-Rao bound


def introduction(seeds: Sequence[int], samples: int, starts: int) -> str:
    """Say what was done."""
    return (
        f'{len(seeds)} windows (seeds from {seeds[0]}) of {samples} samples, 1 s apart; openings '
        '~ U[0.2, 1], initial levels ~ U[5, 95] cm, truth integrated with steps of 10 ms; 6 '
        'unknowns, cold start, `solve_window` with its defaults, with the noise unknown and known. '
        f'The judge: scipy `least_squares` (TRF) from the truth and {starts} Latin hypercube '
        'points, both outputs weighted equally, with central differences of its own. Solved means '
        f'within {SOLVED} sigma^2 of its optimum. Process time of the whole call, in a '
        'single process, compiled before.'
    )


def section(
    snr: float,
    samples: int,
    seeds: Sequence[int],
    solved: Mapping[str, Sequence[Solved]],
    verdicts: Sequence[Verdict],
) -> list[str]:
    """Return the report's parts on one noise level."""
    lost = [
        f'- seed {seeds[i]}, noise {known}: {v.excess[known]:.3g} sigma^2, '
        f'{solved[known][i].estimate.outcome} ({solved[known][i].estimate.message})'
        for i, v in enumerate(verdicts)
        for known in KNOWLEDGE
        if not v.excess[known] <= SOLVED
    ]
    return [
        f'## {snr:g} dB (sigma = {noise_of(snr):g} cm)',
        search_table(solved, verdicts),
        requirements(asked(samples, solved, verdicts)),
        efficiency_table(verdicts),
        *(['Not solved:\n\n' + '\n'.join(lost)] if lost else []),
    ]


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
    return rows


def search_table(solved: Mapping[str, Sequence[Solved]], verdicts: Sequence[Verdict]) -> str:
    """Tell how many windows were solved, how long that took, and what the search said of them."""
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
    rule = 1e6 * np.median([one.yardstick for one in solved['known']])
    return (
        table(rows)
        + f'\n\nYardstick: {YARDSTICK_LANES} candidates rolled out over {FULL_WINDOW} samples, '
        f'measured after every solve: {rule:.0f} us.'
    )


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
    return (
        'RMSE over the Cramér-Rao bound, in windows whose truth is more than '
        f'{INTERIOR:g} standard deviations inside the box; asked at 20 and 40 dB: at most '
        f'{EFFICIENCY_LIMIT} over all. (Of one unknown over n windows it scatters by 0.7/sqrt(n).) '
        "Where levels cross, the model's steps of 1 s add an error of their own.\n\n" + table(rows)
    )
