"""The claims of Porter & Passino 1995, judged by the figures."""

import numpy as np

from benchmarks.papers.claims import Claim, below, counted, every, rarely, share, verdict
from benchmarks.papers.porter import gain_claims as gains
from benchmarks.papers.porter.plan import (
    ALPHAS,
    BASE_2,
    CASES,
    CONSTANT,
    EKF,
    GAMMAS,
    LINEAR,
    OSCILLATOR,
    PAPER,
    Outcomes,
)
from benchmarks.papers.porter.scores import (
    ALIKE,
    DEFAULT,
    ends,
    errors,
    fail_alike,
    failures,
    median_text,
    rms_text,
    unsettled,
)

FIGURES = {  # what the paper says of the errors in its figures, by case
    LINEAR: ('4.1, Fig. 1', 'relatively good tracking performance'),
    OSCILLATOR: ('4.2, Fig. 3', 'overall, the GAO performs quite well'),
    f'{OSCILLATOR}_chaotic': ('4.2, Fig. 5', 'chaotic input: good accuracy still obtained'),
    f'{OSCILLATOR}_disturbed': ('4.2, Fig. 7', 'noise on the output: reasonable estimates'),
    f'{OSCILLATOR}_gaussian': ('4.2, Fig. 9', 'white Gaussian input: reasonable estimates'),
    f'{OSCILLATOR}_mismatch': ('4.2, Fig. 11', 'model mismatch: reasonable estimates'),
}
FROZEN = {LINEAR: ('4.1, Fig. 2', 3.5), OSCILLATOR: ('4.2, Fig. 4', 3.0)}  # printed times, s


def claims(outcomes: Outcomes) -> list[Claim]:
    """Return the claims in the order of the paper."""
    return [
        driven_to_zero(outcomes),
        base_2(outcomes),
        gains.fluctuations(outcomes),
        tracking(outcomes, LINEAR),
        freeze(outcomes, LINEAR),
        gains.placed(outcomes),
        gains.signs(outcomes),
        gains.helped(outcomes),
        tracking(outcomes, OSCILLATOR),
        freeze(outcomes, OSCILLATOR),
        *(tracking(outcomes, case) for case in FIGURES if case not in FROZEN),
        largest(outcomes),
        model_not_input(outcomes),
        *(constant_input(outcomes, scenario) for scenario in CONSTANT),
        gains.different(outcomes),
        gains.first_fixed(outcomes),
        gains.second_fixed(outcomes),
        gains.tolerant(outcomes),
        gains.dependent(outcomes, 'gamma', GAMMAS),
        gains.dependent(outcomes, 'the alphas', ALPHAS),
        gains.large_changes(outcomes),
        gains.unstable(outcomes),
    ]


def beside(outcomes: Outcomes, scenario: str) -> str:
    """Return failures of our default on a scenario, and the error of a filter there."""
    lost = share(*failures(outcomes, scenario, DEFAULT))
    return f'no freeze: {lost} fail; EKF: RMS {rms_text(outcomes, scenario, EKF)}'


def tracking(outcomes: Outcomes, scenario: str) -> Claim:
    """Judge a figure of errors: few runs of the paper's mode fail."""
    lost = failures(outcomes, scenario, PAPER)
    place, sentence = FIGURES[scenario]
    return Claim(
        place, sentence, "share of runs of the paper's mode that fail",
        f'{share(*lost)}; RMS x2 {rms_text(outcomes, scenario, PAPER)}',
        rarely(*lost), beside(outcomes, scenario),
    )  # fmt: skip


def freeze(outcomes: Outcomes, scenario: str) -> Claim:
    """Judge the time of the freeze: the printed one is among 95 % of the runs."""
    place, printed = FROZEN[scenario]
    times = [one.frozen for one in outcomes[scenario, PAPER]]
    low, high = np.quantile(times, (0.025, 0.975), method='nearest')
    found = f'{median_text(times, " s")}; 95 % of the runs {low:.3g} to {high:.3g} s'
    return Claim(
        place, f'the tolerance of eq. 11 is met at about {printed:g} s',
        'time; holds if among 95 % of the runs, of population 20, which is not in print', found,
        verdict(low <= printed <= high), 'adapts for good',
    )  # fmt: skip


def base_2(outcomes: Outcomes) -> Claim:
    """Judge whether another coding fails as often, case by case."""
    pairs = [[failures(outcomes, case, way) for way in (PAPER, BASE_2)] for case in CASES]
    alike = [fail_alike(outcomes, case, PAPER, BASE_2) for case in CASES]
    ten, two = np.sum(pairs, axis=0).tolist()
    found = f'base 10: {share(*ten)}, base 2: {share(*two)}, all cases; {counted(alike)}'
    return Claim(
        '2', 'base 10 is not critical, base 2 works in a similar manner',
        f'share of runs that fail, {len(CASES)} cases, 24 bits, the same p_c and p_m; holds if in '
        f'every case they are at most {ALIKE:g} apart', found, every(alike), 'base 10',
    )  # fmt: skip


def driven_to_zero(outcomes: Outcomes) -> Claim:
    """Judge the abstract on the plants of sections 4.1 and 4.2."""
    late = {s: sum(map(unsettled, outcomes[s, PAPER])) for s in FROZEN}
    runs = {s: len(outcomes[s, PAPER]) for s in FROZEN}
    return Claim(
        'Abstract', 'the state estimation error is driven to zero',
        'share of runs in which x2 is not within 0.05 for good by 20 s',
        '; '.join(f'{CASES[s]} {share(late[s], runs[s])}' for s in FROZEN),
        every(rarely(late[s], runs[s]) for s in FROZEN),
        '; '.join(f'{CASES[s]} EKF: {median_text(errors(outcomes[s, EKF]))} RMS' for s in FROZEN),
    )  # fmt: skip


def largest(outcomes: Outcomes) -> Claim:
    """Judge which of the oscillator's cases have the largest errors."""
    found = {n: ends(errors(outcomes[s, PAPER])) for s, n in CASES.items() if s != LINEAR}
    told = [found.pop(name) for name in ('disturbed', 'mismatch')]
    return Claim(
        '4.2', 'output noise and model mismatch show the largest error',
        'RMS x2, medians; holds if both lie above all others',
        ', '.join(f'{CASES[s]} {rms_text(outcomes, s, PAPER)}' for s in CASES if s != LINEAR),
        every(below(other, one) for one in told for other in found.values()),
        ', '.join(f'{CASES[s]} {np.median(errors(outcomes[s, DEFAULT])):.3g}' for s in CASES
                  if s != LINEAR),
    )  # fmt: skip


def model_not_input(outcomes: Outcomes) -> Claim:
    """Judge whether a wrong model changes the error more than another input does."""
    inputs = [f'{OSCILLATOR}{case}' for case in ('', '_chaotic', '_gaussian')]
    wrong = f'{OSCILLATOR}_mismatch'
    found = {s: ends(errors(outcomes[s, PAPER])) for s in (*inputs, wrong)}
    (low, high), same = found[wrong], found[inputs[-1]]
    model = low / same[1], high / same[0]
    lows, highs = zip(*(found[s] for s in inputs), strict=True)
    other = max(lows) / min(highs), max(highs) / min(lows)
    lost = ', '.join(f'{CASES[s]} {share(*failures(outcomes, s, PAPER))}' for s in (*inputs, wrong))
    return Claim(
        '4.2', 'highly dependent on the model, not as much on the input',
        'RMS x2, medians: mismatch over the same input without, beside largest over smallest of '
        'the inputs; holds if larger',
        f'{model[0]:.3g} to {model[1]:.3g} and {other[0]:.3g} to {other[1]:.3g}; fail: {lost}',
        below(other, model),
    )  # fmt: skip


def constant_input(outcomes: Outcomes, scenario: str) -> Claim:
    """Judge whether the error goes to zero under a constant input."""
    late = {way: sum(map(unsettled, outcomes[scenario, way])) for way in (PAPER, DEFAULT)}
    runs = len(outcomes[scenario, PAPER])
    return Claim(
        '4.2', f'constant input ({CONSTANT[scenario].split(",")[0]}): the error goes to zero',
        'share of runs in which x2 is not within 0.05 for good by 20 s', share(late[PAPER], runs),
        rarely(late[PAPER], runs), f'no freeze: {share(late[DEFAULT], runs)}',
    )  # fmt: skip
