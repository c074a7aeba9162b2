"""Observers on the plants of Porter & Passino 1995: who runs what."""

from collections.abc import Mapping, Sequence
from typing import Any

from benchmarks.papers.observed import Outcome
from benchmarks.play import Contestant

LINEAR, OSCILLATOR = 'linear_second_order', 'glycolytic_oscillator'
OWN = 'benchmarks.papers.porter.scenarios'
CASES = {  # of the paper's figures
    LINEAR: 'linear',
    OSCILLATOR: 'base',
    f'{OSCILLATOR}_chaotic': 'chaotic',
    f'{OSCILLATOR}_disturbed': 'disturbed',
    f'{OSCILLATOR}_gaussian': 'Gaussian',
    f'{OSCILLATOR}_mismatch': 'mismatch',
}
CONSTANT = {f'{OWN}:LINEAR': 'linear, constant', f'{OWN}:OSCILLATOR': 'oscillator, constant'}
SCENARIOS = CASES | CONSTANT
LINEAR_PLANTS = (LINEAR, f'{OWN}:LINEAR')

# Section 4.2: what differs from the linear plant, whose values are the observer's defaults.
NONLINEAR: dict[str, Any] = {
    'least_gains': (0.0, -9.9), 'most_gains': (9.9, -0.01), 'alpha2': 80.0, 'tolerance': 5e-5
}  # fmt: skip
TRIES = 10  # that gains out of their domain are bred again: the paper has a limit, but not which
# By pole placement, poles 0.9 and 0.91 of the Euler model, of the oscillator about its start.
PLACED = {LINEAR: (0.1125, -0.0351), OSCILLATOR: (0.20, -0.35)}

PAPER = 'GAO, paper'
CLAMPED, BRED = 'GAO, clamped', 'GAO, bred again'
BASE_2 = 'GAO, base 2'
L1_FIXED, L2_FIXED = 'GAO, L1 fixed', 'GAO, L2 fixed'
ANY_SIGN = 'GAO, gains of any sign'
FEW_CHANGES = 'GAO, p_c 0.1, p_m 0.02'
# Values that the paper does not choose for the oscillator, about the ones that it does.
GAMMAS = {f'GAO, gamma {value:g}': value for value in (5e-7, 5e-6, 5e-4, 5e-3)}
ALPHAS = {f'GAO, alpha2 {value:g}': value for value in (20.0, 40.0, 160.0, 320.0)}
EKF, EKF_BLIND, UKF = 'EKF from (0, 0.5)', 'EKF from (0, 0)', 'UKF from (0, 0)'
PLACED_GAIN = 'constant gain'

Outcomes = Mapping[tuple[str, str], Sequence[Outcome]]  # by scenario and observer


def ways(scenario: str) -> list[Contestant]:
    """Return the observers on one scenario."""
    linear = scenario in LINEAR_PLANTS
    own: dict[str, Any] = {} if linear else NONLINEAR
    paper = {**own, 'freeze': True, 'tries': TRIES}
    variants = 'benchmarks.papers.porter.variants'
    found = [
        Contestant(PAPER, 'gao', paper, seeded=True),
        Contestant(CLAMPED, 'gao', {**own, 'tries': 0}, seeded=True),
        Contestant(BRED, 'gao', {**own, 'tries': TRIES}, seeded=True),
    ]
    if scenario in CASES:
        found.append(Contestant(BASE_2, f'{variants}:BinaryObserver', paper, seeded=True))
    if scenario == OSCILLATOR:
        any_sign = {**paper, 'least_gains': (-9.9,), 'most_gains': (9.9,)}
        few = {**paper, 'crossover': 0.1, 'mutation': 0.02}
        found += [
            Contestant(L1_FIXED, f'{variants}:FirstGainFixed', paper, seeded=True),
            Contestant(L2_FIXED, f'{variants}:SecondGainFixed', paper, seeded=True),
            Contestant(ANY_SIGN, 'gao', any_sign, seeded=True),
            Contestant(FEW_CHANGES, 'gao', few, seeded=True),
        ]
        varied = [
            *((label, {'tolerance': value}) for label, value in GAMMAS.items()),
            *((label, {'alpha2': value}) for label, value in ALPHAS.items()),
        ]
        found += [Contestant(label, 'gao', {**paper, **one}, seeded=True) for label, one in varied]
    return found + plain_ways(scenario)


def plain_ways(scenario: str) -> list[Contestant]:
    """Return the observers on one scenario that are not genetic."""
    half, zero = ({'parameters': (), 'initial': {'x1': 0.0, 'x2': x2}} for x2 in (0.5, 0.0))
    gains = PLACED[LINEAR if scenario in LINEAR_PLANTS else OSCILLATOR]
    return [
        Contestant(PLACED_GAIN, 'constant gain', {'gains': gains}),
        Contestant(EKF, 'ekf', half),
        Contestant(EKF_BLIND, 'ekf', zero),
        Contestant(UKF, 'ukf', zero),
    ]
