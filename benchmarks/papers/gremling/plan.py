"""Observers on the plants of Gremling & Passino 2000: who runs what."""

from collections.abc import Mapping, Sequence
from typing import Any

from benchmarks.papers.observed import Outcome
from benchmarks.play import Contestant
from obs_ros import load_model
from plant_sim.scenarios import load_scenario

MINIMUM, NON_MINIMUM = 'observer_form_third_order', 'observer_form_third_order_nmp'
LINEAR = {MINIMUM: 'minimum phase', NON_MINIMUM: 'non-minimum phase'}
JETS = {'jet_engine_case1': 'case 1', 'jet_engine_case2': 'case 2'}
WINDOW = 50  # samples W, the estimator's default
JET_START = {'R': 0.05, 'Phi': 1.0}
JET_SETTINGS: dict[str, Any] = {'parents': 66, 'elite': 8, 'window': 100, 'initial': JET_START}

PAPER, DEFAULT = 'GASE, paper', 'GASE, window_end'
BASE_2 = 'GASE, base 2'
EKF, UKF = 'joint EKF', 'joint UKF'
LUENBERGER, RLS = 'adaptive Luenberger', 'RLS + Luenberger'
LEAST_SQUARES, MIDDLE = 'LM on the window', 'fixed mid-range'

Outcomes = Mapping[tuple[str, str], Sequence[Outcome]]  # by scenario and observer


def ways(scenario: str) -> list[Contestant]:
    """Return the observers on one scenario."""
    jet = scenario in JETS
    own = JET_SETTINGS if jet else {}
    # From the middle of the ranges: the models' nominal values are the truth.
    middle = {
        variable.name: 0.5 * (variable.lower + variable.upper)
        for variable in load_model(load_scenario(scenario).model).parameters
    }
    start = {'initial': {**middle, **(JET_START if jet else {})}}
    found = [
        Contestant(PAPER, 'gase', {**own, 'mode': 'paper'}, seeded=True),
        Contestant(DEFAULT, 'gase', {**own, 'mode': 'window_end'}, seeded=True),
        Contestant(
            BASE_2,
            'benchmarks.papers.gremling.variants:BinaryEstimator',
            {**own, 'mode': 'paper'},
            seeded=True,
        ),
        Contestant(EKF, 'ekf', start),
        Contestant(UKF, 'ukf', start),
    ]
    if not jet:
        normalised = {'normalised': scenario == NON_MINIMUM}
        found += [
            Contestant(LUENBERGER, 'adaptive_luenberger', normalised),
            Contestant(RLS, 'rls_luenberger'),
            Contestant(LEAST_SQUARES, 'window fit', {'window': WINDOW}),
            Contestant(MIDDLE, 'open loop'),
        ]
    return found
