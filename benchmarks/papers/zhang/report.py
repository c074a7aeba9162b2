"""Tables of the observers of the flows, and the acceptance."""

import numpy as np

from benchmarks.papers.claims import share
from benchmarks.papers.zhang.plants import COLD, FAULTS, MOVING, PROCESS, UTILITY, Case
from benchmarks.papers.zhang.run import (
    CONTESTANTS,
    OURS,
    PAPER,
    RATED,
    Figures,
)
from benchmarks.papers.zhang.scores import bracketed, middle, named, quiet, times
from benchmarks.papers.zhang.window_report import window_acceptance, window_tables
from benchmarks.report import Requirement, filled, requirements, slashed, table
from obs_ros.core.typing import Array


def report(figures: Figures) -> str:
    """Return the tables of the report."""
    return filled(
        'papers/zhang/report',
        few=len(figures.noisy[CONTESTANTS[2].label, MOVING.label]),
        settling=settling_table(figures),
        noise=noise_table(figures),
        motion=motion_table(figures),
        naming=naming_table(figures),
        **window_tables(figures.windows),
        acceptance=requirements([*acceptance(figures), *window_acceptance(figures.windows)]),
    )


def settling_table(figures: Figures) -> str:
    """Settling without noise."""
    rows = []
    for one in CONTESTANTS:
        first, fp, fu = (quiet(figures, one, case) for case in (COLD, PROCESS, UTILITY))
        rows.append({
            'observer': one.label,
            'case 1: settled (s)': times(first.settled),
            'largest flow (of nominal)': f'{first.most:.2f}',
            'case 2: settled after Fp@150 / Fu@80 (s)':
                times(np.array([fp.settled[0], fu.settled[1]])),
        })  # fmt: skip
    return table(rows)


def noise_table(figures: Figures) -> str:
    """RMS in case 2: of Fp after its valve's fault, and of Fu after its own."""
    rows = []
    for one in CONTESTANTS:
        row = {'observer': one.label}
        for name, i, case in (('Fp', 0, PROCESS), ('Fu', 1, UTILITY)):
            errors = rms_of(figures, one.label, case)[:, i]
            row[f'RMS of {name} (%): median (95 % interval), largest'] = (
                f'{bracketed(errors)}, {errors.max():.2f}'
            )
            row[f'seeds of {name}'] = str(errors.size)
        rows.append(row)
    return table(rows)


def rms_of(figures: Figures, label: str, case: Case) -> Array:
    """Return the RMS (N, 2) of Fp and Fu in all runs with noise."""
    return np.array([run.rms for run in figures.noisy[label, case.label]])


def motion_table(figures: Figures) -> str:
    """RMS in case 3."""
    return table(
        {'observer': one.label}
        | {
            f'RMS of {name} (%)': bracketed(rms_of(figures, one.label, MOVING)[:, i])
            for i, name in enumerate(('Fp', 'Fu'))
        }
        for one in CONTESTANTS
    )


def naming_table(figures: Figures) -> str:
    """Tell the share of runs in which the residuals name the faulty valve."""
    rows = []
    for one in RATED:
        shares = {}
        for case in FAULTS:
            runs = figures.noisy[one.label, case.label]
            shares[case.label.removeprefix('case 2, ')] = share(
                sum(run.named for run in runs), len(runs)
            )
        rows.append({'observer': one.label, **shares})
    return table(rows)


def acceptance(figures: Figures) -> list[Requirement]:
    """Judge the observers by the specification's acceptance."""
    settled = quiet(figures, PAPER, COLD).settled
    calm = np.array([
        rms_of(figures, OURS.label, case)[:, i].max() for i, case in enumerate((PROCESS, UTILITY))
    ])  # fmt: skip
    plain = next(one for one in CONTESTANTS if one.label == 'high gain, theta 2')
    ratio = middle(figures.noisy, OURS, MOVING) / middle(figures.noisy, plain, MOVING)
    sets = (*figures.quiet.values(), *figures.noisy.values(), *figures.slow.values())
    everything = [run for runs in (*sets, figures.starts) for run in runs]
    most, (hits, count) = max(run.most for run in everything), named(figures, OURS)
    return [
        Requirement('case 1, theta 80: Fp <= 0.7 s, Fu <= 0.55 s', f'{times(settled)} s',
                    settled[0] <= 0.7 and settled[1] <= 0.55),
        Requirement('never NaN, flows <= 5 times nominal', f'{most:.2f}',
                    all(run.finite and run.most <= 5.0 + 1e-9 for run in everything)),
        Requirement('theta 2: RMS <= 0.8 / 2.0 %, every seed', f'{slashed(calm)} %',
                    calm[0] <= 0.8 and calm[1] <= 2.0),
        Requirement('case 3, theta 2: interconnected <= 1/3 of plain', f'{slashed(ratio)} of it',
                    bool((ratio <= 1.0 / 3.0).all())),
        Requirement('faulty valve named 2 s after the fault in >= 95 %', share(hits, count),
                    hits >= 0.95 * count),
    ]  # fmt: skip
