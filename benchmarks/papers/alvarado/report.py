"""Tables of the observers of the tyre's stiffness."""

from collections import Counter
from collections.abc import Iterator, Sequence

import numpy as np

from benchmarks.intervals import clustered_interval, median_interval
from benchmarks.papers.alvarado.printed import MAGNITUDES, sign_choices, slowest_pole
from benchmarks.papers.alvarado.roads import CASES, COSINE, SOFTENING, SPAN, TRAPEZOID, Case
from benchmarks.papers.alvarado.run import (
    CONTESTANTS,
    DESIGNED,
    FILTERED,
    KALMAN,
    LONG_WINDOWS,
    NEAR,
    NO_GAIN,
    PAPER,
    PRINTED,
    RATED,
    SOON,
    WINDOWS,
    Figures,
    Measured,
)
from benchmarks.papers.claims import share
from benchmarks.report import Requirement, filled, requirements, rms, table
from obs_ros.models.suspension import SUSPENSION
from obs_ros.observers.papers.adaptive_gains import stored_gains
from obs_ros.observers.papers.design.peak_gain import peak_gain
from obs_ros.observers.papers.design.plants import suspension

SLIDING = (WINDOWS, LONG_WINDOWS)
CONFIDENT_LIMIT = 0.02  # of the windows may be confidently wrong


def report(figures: Figures) -> str:
    """Return the tables of the report."""
    begin, end, counted = SPAN
    return filled(
        'papers/alvarado/report',
        few=len(figures.runs[KALMAN.label, TRAPEZOID.label]),
        begin=begin,
        end=end,
        counted=counted,
        softening=f'{SOFTENING.begin:g} to {SOFTENING.end:g} s, counted from '
        f'{SOFTENING.counted:g} s, {len(figures.runs[PAPER.label, SOFTENING.label])} seeds',
        near=f'{100 * NEAR:g} % from {SOON:g} s after the first bump begins on',
        errors=error_table(figures),
        rates=rate_table(figures),
        windows=window_table(figures),
        known=known_table(figures),
        signs=sign_table(figures),
        bare=f'{slowest_pole(MAGNITUDES):.2g}',
        gains=gain_table(),
        acceptance=requirements(acceptance(figures)),
    )


def error_table(figures: Figures) -> str:
    """Tell the errors of kt by case and contestant."""
    return table(
        {'drive': case.label}
        | {one.label: spread(figures.runs[one.label, case.label]) for one in CONTESTANTS}
        for case in CASES
    )


def rate_table(figures: Figures) -> str:
    """Tell how many runs find kt and keep it."""
    rows = []
    for case in (TRAPEZOID, COSINE):
        row = {'drive': case.label}
        for one in RATED:
            found = figures.runs[one.label, case.label]
            row[one.label] = share(sum(run.kept for run in found), len(found))
        rows.append(row)
    return table(rows)


def window_table(figures: Figures) -> str:
    """Tell how sure the windows are, and how often wrongly."""
    rows = []
    for case in CASES:
        for one in SLIDING:
            found = figures.runs[one.label, case.label]
            rows.append({'drive': case.label, 'windows of': one.label.split()[2] + ' s'}
                        | certainty(found))  # fmt: skip
    return table(rows)


def certainty(found: Sequence[Measured]) -> dict[str, str]:
    """Return the columns of one row of the windows' table."""
    windows = [window for run in found for window in run.windows]
    given = [window for window in windows if np.isfinite(window.sd)]
    hidden = [window for window in windows if not np.isfinite(window.sd)]
    reasons = Counter(str(window.outcome) for window in hidden).most_common()
    low, high = wrong_interval(found)
    error = float(rms([window.error for window in given])) if given else np.nan
    return {
        'runs': str(len(found)),
        'windows': str(len(windows)),
        'confidently wrong': f'{wrong(found):.4f} ({low:.4f} to {high:.4f})',
        'sd withheld': f'{len(hidden) / len(windows):.2f}',
        'reasons': ', '.join(f'{name} {count}' for name, count in reasons) or 'none',
        'RMS (%) of those with an sd': f'{100.0 * error:.2f}',
    }


def known_table(figures: Figures) -> str:
    """Tell what the gains make of the disturbance."""
    return table(
        {'L': name}
        | {
            f'{output} (mm): RMS (largest)': f'{errors[0, i]:.3f} ({errors[1, i]:.3f})'
            for i, output in enumerate(('x1', 'x3', 'z_def'))
        }
        for name, errors in figures.known.items()
    )


def sign_table(figures: Figures) -> str:
    """Tell the stable choices of signs of the printed gains."""
    stored = stored_gains(SUSPENSION, 'printed').L
    stable = [one for one in sign_choices() if one.stable]
    return table(
        {
            'signs of the first column': ' '.join(f'{sign:+.0f}' for sign in np.sign(one.L[:, 0])),
            'slowest pole (1/s)': f'{one.pole:.3g}',
            'peak gain (m/N)': f'{one.peak:.4g}',
            'RMS of kt (%)': f'{error:.3g}',
            'taken': 'yes' if np.allclose(one.L, stored) else '',
        }
        for one, error in zip(stable, figures.signs, strict=True)
    )


def gain_table() -> str:
    """Measure the gains, and the effect of each."""
    plant = suspension()
    kinds = {name: stored_gains(SUSPENSION, name) for name in ('designed', 'printed')}
    gains = {DESIGNED: kinds['designed'].L, PRINTED: kinds['printed'].L,
             NO_GAIN: 0.0 * kinds['printed'].L}  # fmt: skip
    rows = []
    for name, L in gains.items():
        poles = np.linalg.eigvals(plant.A - L @ plant.C).real
        rows.append({
            'L': name,
            'largest entry': f'{np.abs(L).max():.3g}',
            'poles (1/s)': f'{poles.min():.1f} to {poles.max():.1f}',
            'peak (m/N)': f'{peak_gain(plant, L):.3g}',
            'bound (m/N)': f'{kinds["designed"].beta:.3g}' if name == DESIGNED else 'none',
        })  # fmt: skip
    return table(rows)


def acceptance(figures: Figures) -> list[Requirement]:
    """Judge by the specification's acceptance, on every seed."""
    rows = []
    for one, limit in ((FILTERED, 2.5), (PAPER, 4.0), (KALMAN, 2.5), (WINDOWS, 5.0),
                       (LONG_WINDOWS, 5.0)):  # fmt: skip
        found = figures.runs[one.label, TRAPEZOID.label]
        largest, near = max(run.rms for run in found), max(run.near for run in found)
        rows.append(Requirement(f'{TRAPEZOID.label}: {one.label} <= {limit:g} %, every seed',
                                f'{largest:.2f} %', largest <= limit))  # fmt: skip
        if one != KALMAN:
            rows.append(Requirement(
                f'{TRAPEZOID.label}: {one.label} within {100 * NEAR:g} % of kt <= {SOON:g} s after '
                'the bump begins, every seed', f'{near:.2f} s', near <= SOON))  # fmt: skip
    rows += [row for one in SLIDING for row in window_requirements(figures, one.label)]
    finite = all(run.finite for found in figures.runs.values() for run in found)
    return [*rows, Requirement('never NaN or infinite', '', finite)]


def window_requirements(figures: Figures, label: str) -> Iterator[Requirement]:
    """Judge windows: on the cosine, which tells less, they may withhold."""
    found = figures.runs[label, COSINE.label]
    largest, withheld = max(run.rms for run in found), accurate_or_withheld(found, COSINE)
    yield Requirement(
        f'{COSINE.label}: {label} <= 5 % or withheld, every seed',
        f'largest RMS {largest:.2f} %; every window that counts within 5 % or withheld: {withheld}',
        largest <= 5.0 or withheld,
    )
    for case in CASES:
        amount = wrong(figures.runs[label, case.label])
        yield Requirement(
            f'{case.label}: {label} confidently wrong in <= {CONFIDENT_LIMIT:g} of the windows',
            f'{amount:.4f}', amount <= CONFIDENT_LIMIT)  # fmt: skip


def accurate_or_withheld(found: Sequence[Measured], case: Case) -> bool:
    """Tell if every window that counts is within 5 %, or withholds its standard deviation."""
    windows = [w for run in found for w in run.windows if w.time > case.counted]
    return all(abs(w.error) <= 0.05 or np.isnan(w.sd) for w in windows)


def wrong(found: Sequence[Measured]) -> float:
    """Return the share of windows that are confidently wrong."""
    return float(np.mean([w.confidently_wrong for run in found for w in run.windows]))


def wrong_interval(found: Sequence[Measured]) -> tuple[float, float]:
    """Return its 95 % interval: windows of a run hang together."""
    hits = np.array([sum(w.confidently_wrong for w in run.windows) for run in found], dtype=float)
    counts = np.array([len(run.windows) for run in found], dtype=float)
    return clustered_interval(hits, counts)


def spread(found: Sequence[Measured]) -> str:
    """Return the median error of kt with its interval, and the largest, in %."""
    errors = [run.rms for run in found]
    middle, low, high = median_interval(errors)
    return f'{middle:.2f} ({low:.2f} to {high:.2f}), largest {max(errors):.2f}'
