"""Tables of the genetic observers beside the papers' figures and beside filters."""

import numpy as np

from benchmarks.genetic_papers.plan import (
    JETS,
    LINEAR_1995,
    MINIMUM,
    NON_MINIMUM,
    SCENARIOS_1995,
    Outcomes,
    ways_1995,
    ways_2000,
)
from benchmarks.genetic_papers.run import diverged
from benchmarks.play import followed, played, samples_of
from benchmarks.report import Requirement, filled, requirements, slashed, table
from obs_ros import load_observer
from obs_ros.core.typing import Array
from plant_sim.scenarios import load_scenario

MOST_RMS = {  # of x2, mean over the runs of GAO
    'base': 0.08, 'chaotic': 0.08, 'Gaussian': 0.05, 'disturbed': 0.5, 'mismatch': 0.3
}  # fmt: skip
PAPER_2000 = {MINIMUM: (4328.79, 2008.48), NON_MINIMUM: (7244.04, 2563.16)}
LUENBERGER_2000 = {MINIMUM: (4365.23, 3427.46), NON_MINIMUM: (6320.00, 8348.10)}
WITHIN, LUENBERGER_WITHIN = 0.3, 0.005  # of the paper's means
MOST_TIME = {'ekf': 20.0, 'ukf': 60.0}  # us for a sample, at 6 joint states
PLANTS_2000 = {MINIMUM: 'minimum phase', NON_MINIMUM: 'non-minimum phase'}
SAMPLES = 3000  # through the Kalman filters
SETTLED = 2.5  # s, the median asked of GAO, frozen


def report(outcomes: Outcomes, runs: int, drawn: str) -> str:
    """Return the report, with the pictures at its end."""
    return filled(
        'genetic_papers/report',
        porter=porter_table(outcomes),
        porter_asked=requirements(porter_asked(outcomes)),
        runs=runs,
        gremling=gremling_table(outcomes),
        gremling_asked=requirements(gremling_asked(outcomes)),
        jet=jet_table(outcomes),
        times=times_table(outcomes),
        count=SAMPLES,
        **filters_tables(SAMPLES),
        pictures=drawn,
    )


def porter_table(outcomes: Outcomes) -> str:
    """Tell divergences, errors and settling times on the plants of the first paper."""
    rows = []
    for scenario, name in SCENARIOS_1995.items():
        for way in ways_1995(scenario):
            found = outcomes[scenario, way.label]
            rms = [one.rms[1] for one in found]
            settled = [one.settled for one in found]
            rows.append({
                'scenario': name,
                'observer': way.label,
                'runs': len(found),
                'diverged': sum(map(diverged, found)),
                'RMS x2, mean': number(np.mean(rms)),
                'median': number(np.median(rms)),
                'most': number(np.max(rms)),
                'settled at (s), median': number(np.median(settled)),
                'settled': np.isfinite(settled).sum(),
            })  # fmt: skip
    return table(rows)


def porter_asked(outcomes: Outcomes) -> list[Requirement]:
    """Judge the genetic observer; nothing is asked of most of the others."""
    rows = []
    for scenario, name in SCENARIOS_1995.items():
        found = outcomes[scenario, 'GAO']
        lost, mean = sum(map(diverged, found)), np.mean([one.rms[1] for one in found])
        limit = MOST_RMS.get(name, np.inf)
        small = f', mean RMS <= {limit:g}' if np.isfinite(limit) else ''
        asked, told = f'{name}: GAO never diverges{small}', f'{lost} of {len(found)}, {mean:.3g}'
        rows.append(Requirement(asked, told, lost == 0 and bool(mean <= limit)))
    settled = [one.settled for one in outcomes[LINEAR_1995, 'GAO, frozen']]
    late, middle = np.isinf(settled).sum(), np.median(settled)
    asked = f'linear: GAO, frozen always settles, median <= {SETTLED:g} s'
    told = f'{late} not, {number(middle)} s'
    return [*rows, Requirement(asked, told, late == 0 and bool(middle <= SETTLED))]


def squares(outcomes: Outcomes, scenario: str, label: str) -> Array:
    """Return the sums (runs, 2) of squared errors of the hidden states."""
    return np.array([one.squares[1:] for one in outcomes[scenario, label]])


def gremling_table(outcomes: Outcomes) -> str:
    """Tell sums of squared errors on the linear plants of the second paper, beside its own."""
    rows = []
    for scenario, name in PLANTS_2000.items():
        printed = {'GASE, paper': PAPER_2000, 'adaptive Luenberger': LUENBERGER_2000}
        for way in ways_2000(scenario):
            own = squares(outcomes, scenario, way.label)
            least, most = slashed(own.min(axis=0), '.0f'), slashed(own.max(axis=0), '.0f')
            paper = printed.get(way.label)
            rows.append({
                'plant': name,
                'observer': way.label,
                'runs': len(own),
                'Es x2 / x3': slashed(own.mean(axis=0), '.0f'),
                'from - to': f'{least} to {most}' if len(own) > 1 else '',
                "the paper's": slashed(paper[scenario], '.0f') if paper else '',
            })  # fmt: skip
    return table(rows)


def gremling_asked(outcomes: Outcomes) -> list[Requirement]:
    """Judge the sums of squared errors by those that the second paper prints."""
    rows = []
    for scenario, name in PLANTS_2000.items():
        for label, printed, within in (
            ('GASE, paper', PAPER_2000, WITHIN),
            ('adaptive Luenberger', LUENBERGER_2000, LUENBERGER_WITHIN),
        ):
            off = squares(outcomes, scenario, label).mean(axis=0) / printed[scenario] - 1.0
            asked = f"{name}: {label} within {100.0 * within:g} % of the paper's means"
            told = slashed(100.0 * off, '+.1f') + ' %'
            rows.append(Requirement(asked, told, bool((np.abs(off) <= within).all())))
    return rows


def jet_table(outcomes: Outcomes) -> str:
    """Tell sums of squared errors on the jet engine."""
    rows = []
    for scenario, name in JETS.items():
        for way in ways_2000(scenario):
            own = squares(outcomes, scenario, way.label)
            mean = slashed(own.mean(axis=0), '.3g')
            rows.append({'case': name, 'observer': way.label, 'runs': len(own), 'Es R / Phi': mean})
    return table(rows)


def times_table(outcomes: Outcomes) -> str:
    """Tell process times per sample."""
    wanted = [
        (LINEAR_1995, 'GAO', 'GAO, m 20'),
        (MINIMUM, 'GASE, window_end', 'GASE, N 200, W 50, g_t 10'),
        (MINIMUM, 'GASE, paper', 'GASE, N 200, W 50, g_t 10, paper'),
        ('jet_engine_case1', 'GASE, window_end', 'GASE, N 200, W 100, g_t 10, jet engine'),
        (MINIMUM, 'joint EKF', 'EKF, 9 joint states'),
        (MINIMUM, 'joint UKF', 'UKF, 9 joint states'),
        (MINIMUM, 'adaptive Luenberger', 'adaptive Luenberger, order 3'),
        (MINIMUM, 'RLS + Luenberger', 'RLS + Luenberger, order 3'),
    ]
    rows = []
    for scenario, label, name in wanted:
        each = [1e6 * one.seconds for one in outcomes[scenario, label]]
        rows.append({
            'observer': name,
            'runs': len(each),
            'least (us)': f'{np.min(each):.0f}',
            'median (us)': f'{np.median(each):.0f}',
        })  # fmt: skip
    return table(rows)


def filters_tables(count: int) -> dict[str, str]:
    """Measure the Kalman filters on three tanks, six joint states, against the time asked."""
    samples = samples_of(played('three_tank', count))
    rows, asked = [], []
    for name, most in MOST_TIME.items():
        observer = load_observer(name)(load_scenario('three_tank').model)
        least, median = np.quantile(1e6 * followed(observer, samples)[1], (0.05, 0.5), axis=0)
        rows.append({
            'observer': name,
            'absorb, 5 % (us)': f'{least[0]:.1f}',
            'absorb, median (us)': f'{median[0]:.1f}',
            'with its estimate (us)': f'{median[1]:.1f}',
        })  # fmt: skip
        claim = f'{name}: absorb, median <= {most:g} us'
        asked.append(Requirement(claim, f'{median[0]:.1f} us', bool(median[0] <= most)))
    return {'filters': table(rows), 'filters_asked': requirements(asked)}


def number(value: float) -> str:
    """Return a number with three significant digits, or that there is none."""
    return f'{value:.3g}' if np.isfinite(value) else 'never'
