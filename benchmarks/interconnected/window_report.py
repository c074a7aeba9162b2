"""Tables of the sliding windows on the heat exchanger."""

from collections import Counter
from collections.abc import Sequence

import numpy as np

from benchmarks.interconnected.run import FAULTS, SETTLING
from benchmarks.interconnected.windows import DURATION, EVERY, SIZES, Followed, Watched, Windows
from benchmarks.intervals import confidently_wrong, coverage
from benchmarks.report import Requirement, slashed, table
from obs_ros.core.typing import Array

PRODUCT = 'only dP1/k1^2 is determined'


def window_tables(windows: Windows) -> dict[str, object]:
    """Return the three tables, and the length and spacing of the windows in s."""
    tables = {'faults': fault_table(windows), 'watches': watch_table(windows)}
    return {'followed': follow_table(windows), **tables, 'duration': DURATION, 'every': EVERY}


def follow_table(windows: Windows) -> str:
    """Case 2 by dP1 and k2."""
    rows = [
        {'noise': 'none'} | follow_row([windows.quiet]),
        {'noise': '0.05 K'} | follow_row(windows.noisy),
    ]
    return table(rows)


def follow_row(runs: Sequence[Followed]) -> dict[str, str]:
    """Return RMS, standard deviations, and errors when the last window before a fault is gone."""
    rms = [run.rms for run in runs]
    sd = np.concatenate([run.sd[run.plateau] for run in runs]) * (1e-6, 1.0)
    middle, most = np.nanmedian(sd, axis=0), np.nanmax(sd, axis=0)
    return {
        'RMS (%), median of seeds': slashed(np.median(rms, axis=0)),
        'largest': slashed(np.max(rms, axis=0)),
        'sd of dP1 (MPa), median / largest': slashed((middle[0], most[0]), '.2g'),
        'sd of k2 (N/m), median / largest': slashed((middle[1], most[1]), '.2g'),
        'largest error 4 to 5 s after a fault (%)':
            slashed(np.max([fresh(run) for run in runs], axis=0)),
    }  # fmt: skip


def fresh(run: Followed) -> Array:
    """Return the largest errors (%) of Fp and Fu in the second after a window has gone by."""
    inside = np.any([(run.t >= f + SETTLING) & (run.t < f + SETTLING + 1.0) for f in FAULTS], 0)
    return np.asarray(100.0 * np.abs(run.error[inside]).max(axis=0))


def fault_table(windows: Windows) -> str:
    """Tell how often the faulty valve wins the jump search."""
    rows = []
    for label, kinds in windows.faults.items():
        for name, runs in kinds.items():
            firsts = [run.first for run in runs]
            rows.append({
                'noise': label,
                'fault': f'{name} {SIZES[name]:+g}',
                'runs': len(runs),
                'right valve named after 2 s': sum(run.named for run in runs),
                'its other parameter listed': sum(run.partner for run in runs),
                'all alternatives of that valve': sum(run.clear for run in runs),
                'first named after (s): median (largest)':
                    f'{np.median(firsts):.1f} ({max(firsts):.1f})',
                'moment off by (s), median':
                    f'{np.nanmedian(np.abs([run.error for run in runs])):.2f}',
                'false alarms before': sum(run.false for run in runs),
            })  # fmt: skip
    return table(rows)


def watch_table(windows: Windows) -> str:
    """Coverage, confidence and words."""
    rows = []
    for label, runs in windows.watches.items():
        words = Counter(
            text.removesuffix(' (known from earlier windows)')
            for run in runs
            for weak in run.weak
            for text in weak
        ).most_common(3)
        rows.append({
            'clean windows': label,
            'number': sum(len(run.weak) for run in runs),
            'coverage p': f'{coverage(*both(runs, "p")):.3f}',
            'coverage end state': f'{coverage(*both(runs, "x")):.3f}',
            'cw': f'{wrong(runs):.3f}',
            'withheld p': f'{withheld(runs):.2f}',
            'false alarms': sum(run.alarms for run in runs),
            'dP1/k1^2 named': f'{named(runs):.3f}',
            'what is said most': ', '.join(f'{text} ({count})' for text, count in words),
        })  # fmt: skip
    return table(rows)


def both(runs: Sequence[Watched], kind: str) -> tuple[Array, Array]:
    """Return errors and standard deviations of all runs, of `p` or `x`."""
    error, sd = (
        np.concatenate([getattr(run, f'{kind}_{name}') for run in runs]) for name in ('error', 'sd')
    )
    return error, sd


def wrong(runs: Sequence[Watched]) -> float:
    """Return the share of windows in which any value is confidently wrong."""
    error, sd = (np.hstack(pair) for pair in zip(both(runs, 'p'), both(runs, 'x'), strict=True))
    return float(np.mean(confidently_wrong(error, sd).any(axis=1)))


def withheld(runs: Sequence[Watched]) -> float:
    """Return the share of the parameters' standard deviations that are not given."""
    return float(np.mean(np.isnan(both(runs, 'p')[1])))


def named(runs: Sequence[Watched]) -> float:
    """Return the share of windows whose words name the product."""
    said = [any(text.startswith(PRODUCT) for text in weak) for run in runs for weak in run.weak]
    return float(np.mean(said))


def window_acceptance(windows: Windows) -> list[Requirement]:
    """Judge the windows by the specification's acceptance."""
    rms = np.max([run.rms for run in windows.noisy], axis=0)
    sd = np.nanmedian(np.concatenate([run.sd[run.plateau] for run in windows.noisy]), axis=0)
    plateau = fresh(windows.quiet)
    rows = [
        Requirement('windows: RMS <= 0.6 / 1.1 %, every seed', f'{slashed(rms)} %',
                    rms[0] <= 0.6 and rms[1] <= 1.1),
        Requirement('windows: sd of dP1 <= 0.008 MPa, of k2 <= 40 N/m, median',
                    f'{1e-6 * sd[0]:.4f} MPa, {sd[1]:.0f} N/m', sd[0] <= 8e3 and sd[1] <= 40.0),
        Requirement('windows, no noise: new plateau within 4 s (error <= 0.1 %)',
                    f'{slashed(plateau)} %', bool((plateau <= 0.1).all())),
    ]  # fmt: skip
    for label, kinds in windows.faults.items():
        for claim, name in (
            ('right valve named 2 s after the fault', 'named'),
            ('the equivalent parameter listed', 'partner'),
        ):
            found = [getattr(run, name) for runs in kinds.values() for run in runs]
            rows.append(Requirement(f'windows, {label}: {claim} in >= 95 %',
                                    f'{100.0 * np.mean(found):.0f} % of {len(found)}',
                                    np.mean(found) >= 0.95))  # fmt: skip
    for label, runs in windows.watches.items():
        p, x, cw = coverage(*both(runs, 'p')), coverage(*both(runs, 'x')), wrong(runs)
        still = not label.startswith('pressures')  # where withholding is right
        given = 'p withheld' if np.isnan(p) else f'{p:.3f}'
        covers = (p >= 0.93 or (still and np.isnan(p))) and x >= 0.93
        rows.append(
            Requirement(
                f'windows, {label}: coverage >= .93 (p, end state), cw <= .01',
                f'{given}, {x:.3f}, {cw:.3f}',
                covers and cw <= 0.01,
            )
        )
        if still:
            rows.append(Requirement(f'windows, {label}: dP1/k1^2 named in >= 99 %',
                                    f'{named(runs):.3f}', named(runs) >= 0.99))  # fmt: skip
    return rows
