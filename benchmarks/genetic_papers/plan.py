"""Observers on the plants of Porter & Passino 1995 and Gremling & Passino 2000: who runs what."""

from collections.abc import Mapping, Sequence
from typing import Any

from benchmarks.genetic_papers.run import Outcome
from benchmarks.play import Contestant
from obs_ros import load_model
from plant_sim.scenarios import load_scenario

# Porter & Passino, section 4: gains and weights of the linear plant are the observer's defaults.
NONLINEAR: dict[str, Any] = {
    'least_gains': (0.0, -9.9), 'most_gains': (9.9, -0.01), 'alpha2': 80.0, 'tolerance': 5e-5
}  # fmt: skip
LINEAR_1995 = 'linear_second_order'
OSCILLATOR = 'glycolytic_oscillator'
SCENARIOS_1995 = {
    LINEAR_1995: 'linear',
    OSCILLATOR: 'base',
    f'{OSCILLATOR}_chaotic': 'chaotic',
    f'{OSCILLATOR}_disturbed': 'disturbed',
    f'{OSCILLATOR}_gaussian': 'Gaussian',
    f'{OSCILLATOR}_mismatch': 'mismatch',
}
GAINS_1995 = (0.20, -0.35)  # poles 0.9 and 0.91 of the oscillator about its start

MINIMUM, NON_MINIMUM = 'observer_form_third_order', 'observer_form_third_order_nmp'
JETS = {'jet_engine_case1': 'case 1', 'jet_engine_case2': 'case 2'}
WINDOW = 50  # samples W, the estimator's default
JET_START = {'R': 0.05, 'Phi': 1.0}
JET_SETTINGS: dict[str, Any] = {'parents': 66, 'elite': 8, 'window': 100, 'initial': JET_START}

Outcomes = Mapping[tuple[str, str], Sequence[Outcome]]  # by scenario and observer
Plan = dict[tuple[str, str], list[tuple[str, Contestant, int, bool]]]  # see `run`


def ways_1995(scenario: str) -> list[Contestant]:
    """Return the observers on one scenario of the first paper."""
    paper = {} if scenario == LINEAR_1995 else NONLINEAR
    again = {**paper, 'tries': 10}
    half, zero = ({'parameters': (), 'initial': {'x1': 0.0, 'x2': x2}} for x2 in (0.5, 0.0))
    ways = [
        Contestant('GAO', 'gao', paper, seeded=True),
        Contestant('GAO, frozen', 'gao', {**paper, 'freeze': True}, seeded=True),
        Contestant('GAO, bred again', 'gao', again, seeded=True),
        Contestant('EKF from (0, 0.5)', 'ekf', half),
        Contestant('EKF from (0, 0)', 'ekf', zero),
        Contestant('UKF from (0, 0)', 'ukf', zero),
    ]
    if scenario != LINEAR_1995:
        ways.insert(3, Contestant('constant gain', 'constant gain', {'gains': GAINS_1995}))
    return ways


def plan_1995(seeds: int) -> Plan:
    """Return the runs of the first paper; only a random input makes a second run of a filter."""
    return {
        (scenario, way.label): [
            (scenario, way, seed, seed == 0 and way.label.startswith('GAO'))
            for seed in range(seeds if way.seeded or random else 1)
        ]
        for scenario in SCENARIOS_1995
        for random in (scenario.endswith(('gaussian', 'mismatch')),)
        for way in ways_1995(scenario)
    }


def ways_2000(scenario: str) -> list[Contestant]:
    """Return the observers on one scenario of the second paper."""
    jet = scenario in JETS
    own = JET_SETTINGS if jet else {}
    # From the middle of the ranges: the models' nominal values are the truth.
    middle = {
        variable.name: 0.5 * (variable.lower + variable.upper)
        for variable in load_model(load_scenario(scenario).model).parameters
    }
    start = {'initial': {**middle, **(JET_START if jet else {})}}
    ways = [
        Contestant('GASE, paper', 'gase', {**own, 'mode': 'paper'}, seeded=True),
        Contestant('GASE, window_end', 'gase', {**own, 'mode': 'window_end'}, seeded=True),
        Contestant('joint EKF', 'ekf', start),
        Contestant('joint UKF', 'ukf', start),
    ]
    if not jet:
        normalised = {'normalised': scenario == NON_MINIMUM}
        ways += [
            Contestant('adaptive Luenberger', 'adaptive_luenberger', normalised),
            Contestant('RLS + Luenberger', 'rls_luenberger'),
            Contestant('LM on the window', 'window fit', {'window': WINDOW}),
            Contestant('fixed mid-range', 'open loop'),
        ]
    return ways


def plan_2000(runs: int, others: int) -> Plan:
    """Return the runs of the second paper: `runs` of those in its tables, and others."""

    def count(scenario: str, way: Contestant) -> int:
        if not way.seeded:
            return 1
        return runs if way.label == 'GASE, paper' and scenario not in JETS else others

    return {
        (scenario, way.label): [
            (scenario, way, seed, seed == 0) for seed in range(count(scenario, way))
        ]
        for scenario in (MINIMUM, NON_MINIMUM, *JETS)
        for way in ways_2000(scenario)
    }
