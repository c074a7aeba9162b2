"""Tables of the observers of the flows, the paper's claims, and the acceptance."""

import numpy as np

from benchmarks.interconnected.run import CONTESTANTS, Runs, truth_of
from benchmarks.interconnected.window_report import window_acceptance, window_tables
from benchmarks.interconnected.windows import Windows
from benchmarks.report import Requirement, filled, requirements, slashed, table
from obs_ros.core.typing import Array

# Settling of Fp and Fu in case 1, and RMS in %: the specification's figures for the same plant.
REFERENCE = {
    'interconnected, theta 80': ('0.52 / 0.44', '<0.01 / 0.05', '11-12 / 39-47'),
    'high gain, theta 5': ('', '1.13 / 0.83', '1.1-1.2 / 3.6-4.7'),
    'high gain, theta 2': ('', '3.01 / 2.35', '0.4-0.5 / 1.2-1.4'),
    'unknown input': ('4.91 / 1.51', '2.14 / 0.72', '0.5-0.6 / 4.0-5.3'),
}
REFERENCE_3 = {
    'interconnected, theta 2': '0.49 / 1.56',
    'high gain, theta 2': '7.7 / 6.9',
    'unknown input': '7.2 / 6.2',
}


def report(quiet: Runs, noisy: Runs, windows: Windows, seeds: int, drawn: str) -> str:
    """Return the report, with the picture at its end."""
    return filled(
        'interconnected/report',
        seeds=seeds,
        settling=settling_table(quiet),
        noise=noise_table(noisy),
        motion=motion_table(noisy),
        naming=naming_table(noisy),
        claims=requirements(claims(quiet, noisy)),
        **window_tables(windows),
        acceptance=requirements([*acceptance(quiet, noisy), *window_acceptance(windows)]),
        pictures=drawn,
    )


def settling_table(quiet: Runs) -> str:
    """Settling without noise."""
    rows = []
    for one in CONTESTANTS:
        first, second = quiet[one.label, 1][0], quiet[one.label, 2][0]
        reference = REFERENCE.get(one.label, ('', '', ''))
        rows.append({
            'observer': one.label,
            'case 1: settled (s)': beside(slashed(first.settled), reference[0]),
            'largest flow (of nominal)': f'{first.most:.2f}',
            'case 2: settled after Fp@150 / Fu@80 (s)':
                beside(slashed(second.settled), reference[1]),
        })  # fmt: skip
    return table(rows)


def noise_table(noisy: Runs) -> str:
    """RMS in case 2."""
    rows = []
    for one in CONTESTANTS:
        reference = REFERENCE.get(one.label, ('', '', ''))[2]
        rows.append({
            'observer': one.label,
            'RMS (%), median of seeds': beside(slashed(middle(noisy, one.label, 2)), reference),
            'largest': slashed(np.max([run.rms for run in noisy[one.label, 2]], axis=0)),
        })  # fmt: skip
    return table(rows)


def motion_table(noisy: Runs) -> str:
    """RMS in case 3."""
    rows = []
    for one in CONTESTANTS:
        found = slashed(middle(noisy, one.label, 3))
        told = beside(found, REFERENCE_3.get(one.label, ''))
        rows.append({'observer': one.label, 'RMS (%), median': told})
    return table(rows)


def naming_table(noisy: Runs) -> str:
    """Tell the share of runs in which the residuals name the faulty valve."""
    rows = []
    for one in CONTESTANTS:
        named = np.array([run.named for run in noisy[one.label, 2]])
        valves = ('utility valve, 80 s', 'process valve, 150 s')
        shares = (f'{sum(column)} of {len(column)}' for column in named.T)
        rows.append({'observer': one.label, **dict(zip(valves, shares, strict=True))})
    return table(rows)


def claims(quiet: Runs, noisy: Runs) -> list[Requirement]:
    """Hold the paper's claims against the figures found here."""
    paper = 'interconnected, theta 80'
    fast, slow = quiet[paper, 1][0].settled, quiet['unknown input', 1][0].settled
    ours, rival = (middle(noisy, label, 2) for label in (paper, 'unknown input'))
    late = quiet['unknown input', 2][0].settled[0]
    tp, tu = temperatures()
    return [
        Requirement('case 1: Fp within 1 s, Fu within 0.5 s', f'{slashed(fast)} s',
                    fast[0] < 1.0 and fast[1] < 0.5),
        Requirement('case 1: faster than the unknown-input observer',
                    f'{slashed(fast)} s beside {slashed(slow)} s', bool((fast < slow).all())),
        Requirement('more robust to noise than the unknown-input observer',
                    f'{slashed(ours)} % beside {slashed(rival)} %', bool((ours < rival).all())),
        Requirement('case 2: the unknown-input observer finds Fp 1.5 s after 150 s',
                    f'{late:.2f} s', late <= 1.5),
        Requirement('case 2: Tp and Tu drop by 0.2 K at 80 s',
                    f'they change by {tp[0]:+.2f} and {tu[0]:+.2f} K', tp[0] < 0.0 and tu[0] < 0.0),
        Requirement('case 2: Tp drops by 0.9 K and Tu by 0.5 K at 150 s',
                    f'they change by {tp[1]:+.2f} and {tu[1]:+.2f} K', tp[1] < 0.0 and tu[1] < 0.0),
    ]  # fmt: skip


def temperatures() -> tuple[Array, Array]:
    """Return how much Tp and Tu change in the end after each fault of case 2 (K)."""
    t, _, y, _ = truth_of(2)
    before, between, last = (y[np.searchsorted(t, at)] for at in (79.9, 149.9, t[-1]))
    change = np.array([between - before, last - between])
    return change[:, 0], change[:, 1]


def acceptance(quiet: Runs, noisy: Runs) -> list[Requirement]:
    """Judge the observers by the specification's acceptance."""
    settled = quiet['interconnected, theta 80', 1][0].settled
    calm = np.max([run.rms for run in noisy['interconnected, theta 2', 2]], axis=0)
    fed, plain = (middle(noisy, f'{kind}, theta 2', 3) for kind in ('interconnected', 'high gain'))
    everything = [run for runs in (*quiet.values(), *noisy.values()) for run in runs]
    most = max(run.most for run in everything)
    named = [n for run in noisy['interconnected, theta 2', 2] for n in run.named]
    share = 100.0 * np.mean(named)
    return [
        Requirement('case 1, theta 80: Fp <= 0.7 s, Fu <= 0.55 s', f'{slashed(settled)} s',
                    settled[0] <= 0.7 and settled[1] <= 0.55),
        Requirement('never NaN, flows <= 5 times nominal', f'{most:.2f}',
                    all(run.finite and run.most <= 5.0 + 1e-9 for run in everything)),
        Requirement('theta 2: RMS <= 0.8 / 2.0 %, every seed', f'{slashed(calm)} %',
                    calm[0] <= 0.8 and calm[1] <= 2.0),
        Requirement('case 3, theta 2: interconnected <= 1/3 of plain',
                    f'{slashed(fed / plain)} of it', bool((fed <= plain / 3.0).all())),
        Requirement('faulty valve named 2 s after the fault in >= 95 %',
                    f'{share:.0f} % of {len(named)}', share >= 95.0),
    ]  # fmt: skip


def middle(runs: Runs, label: str, case: int) -> Array:
    """Return the median RMS of Fp and Fu over the seeds (%)."""
    return np.asarray(np.median([run.rms for run in runs[label, case]], axis=0))


def beside(ours: str, reference: str) -> str:
    """Return our figures and the specification's in brackets, where it has any."""
    return f'{ours} ({reference})' if reference else ours
