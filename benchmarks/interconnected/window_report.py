"""Tables of valve_windows.py: what sliding windows make of the heat exchanger."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from benchmarks.common import mark, on_all_cores
from benchmarks.common import table as markdown
from benchmarks.interconnected.windows import (
    DURATION,
    EVERY,
    FAULTS,
    SETTLING,
    SIZES,
    Fault,
    Followed,
    Isolated,
    Watch,
    Watched,
    followed,
    isolated,
    watched,
)
from obs_ros.core.typing import Array

NOISES = {'0.1 K, correlated over 0.1 s': (0.1, 0.1), '0.1 K, white': (0.1, 0.0)}
ALL = ('dP1', 'dP2', 'k1', 'k2')
WATCHES = {
    'pressures move, all four unknown': (True, ALL),
    'constant pressures, dP1 and k1 unknown': (False, ('dP1', 'k1')),
    'constant pressures, all four unknown': (False, ALL),
}
PRODUCT = 'only dP1/k1^2 is determined'
COVERED = 1.96  # standard deviations, 95 %
FEW = 10  # runs of each kind of watch, of 57 windows
FAULTY = 10  # noises of each fault: 40 runs


class Windows(NamedTuple):
    """All runs of windows: case 2 without noise and with, by noise and fault, by kind of watch."""

    quiet: Followed
    noisy: Sequence[Followed]
    faults: Mapping[str, Mapping[str, Sequence[Isolated]]]
    watches: Mapping[str, Sequence[Watched]]


def run_windows(seeds: Sequence[int]) -> Windows:
    """Return all runs."""
    quiet, *noisy = on_all_cores(followed, [None, *seeds], 'case 2 in windows')
    kinds = [
        (label, Fault(name, *noise, seed))
        for label, noise in NOISES.items()
        for name in SIZES
        for seed in seeds[:FAULTY]
    ]
    faults: dict[str, dict[str, list[Isolated]]] = {}
    done = on_all_cores(isolated, [fault for _, fault in kinds], 'faults')
    for (label, fault), one in zip(kinds, done, strict=True):
        faults.setdefault(label, {}).setdefault(fault.parameter, []).append(one)
    plans = [
        (label, Watch(moving, seed, parameters))
        for label, (moving, parameters) in WATCHES.items()
        for seed in seeds[:FEW]
    ]
    watches: dict[str, list[Watched]] = {}
    seen = on_all_cores(watched, [watch for _, watch in plans], 'clean windows')
    for (label, _), watch in zip(plans, seen, strict=True):
        watches.setdefault(label, []).append(watch)
    return Windows(quiet, noisy, faults, watches)


def window_tables(windows: Windows) -> list[str]:
    """Return the three tables."""
    return [follow_table(windows), fault_table(windows), watch_table(windows)]


def follow_table(windows: Windows) -> str:
    """Case 2 by dP1 and k2."""
    rows = [('none', *follow_row([windows.quiet])), ('0.05 K', *follow_row(windows.noisy))]
    head = ('noise', 'RMS (%), median of seeds', 'largest', 'sd of dP1 (MPa), median / largest',
            'sd of k2 (N/m), median / largest',
            'largest error 4 to 5 s after a fault (%)')  # fmt: skip
    return (
        f'## Windows of {DURATION:g} s, case 2\n\nSamples at 20 Hz, a window every {EVERY:g} s, '
        'the model without the inertia of the stems; unknown are temperatures and openings at the '
        'start of each window, dP1 and k2. The noise is told (0.05 K), its colour is not. RMS over '
        'the windows that end on the plateaus, Fp / Fu.\n\n' + markdown(head, rows)
    )


def follow_row(runs: Sequence[Followed]) -> tuple[str, ...]:
    """Return RMS, standard deviations, and errors when the last window before a fault is gone."""
    rms = [run.rms for run in runs]
    sd = np.concatenate([run.sd[run.plateau] for run in runs]) * (1e-6, 1.0)
    return (
        pair(np.median(rms, axis=0)),
        pair(np.max(rms, axis=0)),
        f'{np.nanmedian(sd[:, 0]):.2g} / {np.nanmax(sd[:, 0]):.2g}',
        f'{np.nanmedian(sd[:, 1]):.2g} / {np.nanmax(sd[:, 1]):.2g}',
        pair(np.max([fresh(run) for run in runs], axis=0)),
    )


def fresh(run: Followed) -> Array:
    """Return the largest errors (%) of Fp and Fu in the second after a window has gone by."""
    inside = np.any([(run.t >= f + SETTLING) & (run.t < f + SETTLING + 1.0) for f in FAULTS], 0)
    return np.asarray(100.0 * np.abs(run.error[inside]).max(axis=0))


def fault_table(windows: Windows) -> str:
    """Which valve is faulty, by the race's evidence."""
    rows = []
    for label, kinds in windows.faults.items():
        for name, runs in kinds.items():
            firsts = [run.first for run in runs]
            rows.append((
                label, f'{name} {SIZES[name]:+g}', len(runs),
                sum(run.named for run in runs), sum(run.partner for run in runs),
                sum(run.clear for run in runs), f'{np.median(firsts):.1f} ({max(firsts):.1f})',
                f'{np.nanmedian(np.abs([run.error for run in runs])):.2f}',
                sum(run.false for run in runs),
            ))  # fmt: skip
    head = ('noise', 'fault', 'runs', 'right valve named after 2 s', 'its other parameter listed',
            'all alternatives of that valve', 'first named after (s): median (largest)',
            'moment off by (s), median', 'false alarms before')  # fmt: skip
    return (
        '## Which valve is faulty? Windows\n\nAll four parameters may jump, none is known before; '
        'pressures are constant, so that dP and k of one valve cannot be told apart. Named is the '
        "valve of the set that wins the race in the newest window 2 s after the fault; 'listed': "
        'both parameters of the valve stand in the result, one as the winner and one in '
        '`Jump.alternatives`, or together.\n\n' + markdown(head, rows)
    )


def watch_table(windows: Windows) -> str:
    """Coverage, confidence and words."""
    rows = []
    for label, runs in windows.watches.items():
        words = Counter(
            text.removesuffix(' (known from earlier windows)')
            for run in runs for weak in run.weak for text in weak
        ).most_common(3)  # fmt: skip
        rows.append((
            label, sum(len(run.weak) for run in runs), f'{coverage(runs, "p"):.3f}',
            f'{coverage(runs, "x"):.3f}', f'{wrong(runs):.3f}', f'{withheld(runs):.2f}',
            sum(run.alarms for run in runs), f'{named(runs):.3f}',
            ', '.join(f'{text} ({count})' for text, count in words),
        ))  # fmt: skip
    head = ('clean windows', 'number', 'coverage p', 'coverage end state', 'cw', 'withheld p',
            'false alarms', 'dP1/k1^2 named', 'what is said most')  # fmt: skip
    return (
        '## What windows without a fault say\n\nWhite noise of 0.05 K; unknown parameters within '
        '20 % of nominal; where pressures move, they do within 20 % every 2 s. Coverage: of 95 % '
        'intervals, where a standard deviation is given; cw: windows with any error above 3 sd and '
        '2 % of the box.\n\n' + markdown(head, rows)
    )


def stacked(runs: Sequence[Watched], name: str) -> Array:
    """Return the rows of all runs."""
    return np.concatenate([getattr(run, name) for run in runs])


def coverage(runs: Sequence[Watched], what: str) -> float:
    """Return how many of the intervals that are given hold the truth; of `p` or `x`."""
    error, sd = stacked(runs, f'{what}_error'), stacked(runs, f'{what}_sd')
    given = np.isfinite(sd)
    return float(np.mean(np.abs(error[given]) <= COVERED * sd[given])) if given.any() else np.nan


def wrong(runs: Sequence[Watched]) -> float:
    """Return the share of windows in which any value is confidently wrong."""
    error = np.hstack([stacked(runs, 'p_error'), stacked(runs, 'x_error')])
    sd = np.hstack([stacked(runs, 'p_sd'), stacked(runs, 'x_sd')])
    hit = (np.abs(error) > np.maximum(3.0 * sd, 0.02)) & np.isfinite(sd)
    return float(np.mean(hit.any(axis=1)))


def withheld(runs: Sequence[Watched]) -> float:
    """Return the share of the parameters' standard deviations that are not given."""
    return float(np.mean(np.isnan(stacked(runs, 'p_sd'))))


def named(runs: Sequence[Watched]) -> float:
    """Return the share of windows whose words name the product."""
    return float(np.mean([any(text.startswith(PRODUCT) for text in weak)
                          for run in runs for weak in run.weak]))  # fmt: skip


def window_acceptance(windows: Windows) -> list[tuple[str, str, str]]:
    """Return the rows of the specification's acceptance that are about windows."""
    rms = np.max([run.rms for run in windows.noisy], axis=0)
    sd = np.nanmedian(np.concatenate([run.sd[run.plateau] for run in windows.noisy]), axis=0)
    plateau = fresh(windows.quiet)
    rows = [
        ('windows: RMS <= 0.6 / 1.1 %, every seed', f'{pair(rms)} %',
         mark(rms[0] <= 0.6 and rms[1] <= 1.1)),
        ('windows: sd of dP1 <= 0.008 MPa, of k2 <= 40 N/m, median',
         f'{1e-6 * sd[0]:.4f} MPa, {sd[1]:.0f} N/m', mark(sd[0] <= 8e3 and sd[1] <= 40.0)),
        ('windows, no noise: new plateau within 4 s (error <= 0.1 %)', f'{pair(plateau)} %',
         mark(bool((plateau <= 0.1).all()))),
    ]  # fmt: skip
    for label, kinds in windows.faults.items():
        found = [run.named for runs in kinds.values() for run in runs]
        listed = [run.partner for runs in kinds.values() for run in runs]
        rows += [
            (f'windows, {label}: right valve named 2 s after the fault in >= 95 %',
             f'{100.0 * np.mean(found):.0f} % of {len(found)}', mark(np.mean(found) >= 0.95)),
            (f'windows, {label}: the equivalent parameter listed in >= 95 %',
             f'{100.0 * np.mean(listed):.0f} %', mark(np.mean(listed) >= 0.95)),
        ]  # fmt: skip
    for label, runs in windows.watches.items():
        p, x, cw = coverage(runs, 'p'), coverage(runs, 'x'), wrong(runs)
        still = not label.startswith('pressures')  # where withholding is right
        given = 'p withheld' if np.isnan(p) else f'{p:.3f}'
        rows.append((f'windows, {label}: coverage >= .93 (p, end state), cw <= .01',
                     f'{given}, {x:.3f}, {cw:.3f}',
                     mark((p >= 0.93 or (still and np.isnan(p)))
                          and x >= 0.93 and cw <= 0.01)))  # fmt: skip
        if still:
            rows.append((f'windows, {label}: dP1/k1^2 named in >= 99 %',
                         f'{named(runs):.3f}', mark(named(runs) >= 0.99)))  # fmt: skip
    return rows


def pair(values: Array) -> str:
    """Return the figures of Fp and Fu."""
    return ' / '.join(f'{value:.2f}' for value in values)
