"""Tables of the sliding windows on the heat exchanger."""

from collections import Counter
from collections.abc import Sequence

import numpy as np

from benchmarks.intervals import clustered_interval, confidently_wrong, coverage, covered
from benchmarks.papers.claims import share
from benchmarks.papers.zhang.windows import (
    DURATION,
    EVERY,
    FAULTS,
    SETTLING,
    SIZES,
    Followed,
    Isolated,
    Watched,
    Windows,
)
from benchmarks.report import Requirement, slashed, table
from obs_ros.core.typing import Array, BoolArray

PRODUCT = 'only dP1/k1^2 is determined'


def window_tables(windows: Windows) -> dict[str, object]:
    """Return the tables, and the length and spacing of the windows in s."""
    return {
        'followed': follow_table(windows),
        'faults': fault_table(windows),
        'moments': moment_table(windows),
        'watches': watch_table(windows),
        'duration': DURATION,
        'every': EVERY,
    }


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
    """Tell how often the faulty valve wins the jump search, over all four faults."""
    rows = []
    for label in windows.faults:
        runs = all_faults(windows, label)
        rows.append({
            'noise': label,
            'right valve named after 2 s': share(sum(run.named for run in runs), len(runs)),
            'its other parameter listed': share(sum(run.partner for run in runs), len(runs)),
            'all alternatives of that valve': share(sum(run.clear for run in runs), len(runs)),
            'runs with a false alarm before': share(sum(run.false > 0 for run in runs), len(runs)),
        })  # fmt: skip
    return table(rows)


def all_faults(windows: Windows, label: str) -> list[Isolated]:
    """Return the runs of all faults with a noise."""
    return [run for runs in windows.faults[label].values() for run in runs]


def moment_table(windows: Windows) -> str:
    """Tell how soon the faulty valve is named, by fault."""
    rows = []
    for label, kinds in windows.faults.items():
        for name, runs in kinds.items():
            firsts = [run.first for run in runs]
            rows.append({
                'noise': label,
                'fault': f'{name} {SIZES[name]:+g}',
                'runs': len(runs),
                'first named after (s): median (largest)':
                    f'{np.median(firsts):.1f} ({max(firsts):.1f})',
                'moment off by (s), median':
                    f'{np.nanmedian(np.abs([run.error for run in runs])):.2f}',
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
            'coverage p': covering(runs, 'p'),
            'coverage end state': covering(runs, 'x'),
            'cw': of_windows([wrongs(run) for run in runs]),
            'withheld p': f'{withheld(runs):.2f}',
            'runs with a false alarm': share(sum(run.alarms > 0 for run in runs), len(runs)),
            'dP1/k1^2 named': of_windows([namings(run) for run in runs]),
            'what is said most': ', '.join(f'{text} ({count})' for text, count in words),
        })  # fmt: skip
    return table(rows)


def both(runs: Sequence[Watched], kind: str) -> tuple[Array, Array]:
    """Return errors and standard deviations of all runs, of `p` or `x`."""
    error, sd = (
        np.concatenate([getattr(run, f'{kind}_{name}') for run in runs]) for name in ('error', 'sd')
    )
    return error, sd


def covering(runs: Sequence[Watched], kind: str) -> str:
    """Return the coverage of the intervals of `p` or `x` with its interval; runs hang together."""
    pairs = [both([run], kind) for run in runs]
    hits = [covered(error, sd).sum() for error, sd in pairs]
    given = [np.isfinite(sd).sum() for _, sd in pairs]
    return clustered(hits, given) if sum(given) else 'none given'


def of_windows(told: Sequence[BoolArray]) -> str:
    """Return the share of windows, of which each run has an array, with its interval."""
    return clustered([each.sum() for each in told], [each.size for each in told])


def clustered(hits: Sequence[float], counts: Sequence[float]) -> str:
    """Return a share of what hangs together by runs, with its 95 % interval."""
    low, high = clustered_interval(np.array(hits, dtype=float), np.array(counts, dtype=float))
    return f'{sum(hits) / sum(counts):.3f} ({low:.3f} to {high:.3f})'


def wrongs(run: Watched) -> BoolArray:
    """Tell in which windows (W,) any value is confidently wrong."""
    error, sd = np.hstack([run.p_error, run.x_error]), np.hstack([run.p_sd, run.x_sd])
    return np.asarray(confidently_wrong(error, sd).any(axis=1))


def wrong(runs: Sequence[Watched]) -> float:
    """Return the share of windows in which any value is confidently wrong."""
    return float(np.mean(np.concatenate([wrongs(run) for run in runs])))


def withheld(runs: Sequence[Watched]) -> float:
    """Return the share of the parameters' standard deviations that are not given."""
    return float(np.mean(np.isnan(both(runs, 'p')[1])))


def namings(run: Watched) -> BoolArray:
    """Tell which windows (W,) have words that name the product."""
    return np.array([any(text.startswith(PRODUCT) for text in weak) for weak in run.weak])


def named(runs: Sequence[Watched]) -> float:
    """Return the share of windows whose words name the product."""
    return float(np.mean(np.concatenate([namings(run) for run in runs])))


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
    for label in windows.faults:
        for claim, name in (
            ('right valve named 2 s after the fault', 'named'),
            ('the equivalent parameter listed', 'partner'),
        ):
            found = [getattr(run, name) for run in all_faults(windows, label)]
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
