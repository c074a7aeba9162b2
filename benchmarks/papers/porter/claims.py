"""The claims of Porter & Passino 1995, judged by the figures."""

import numpy as np

from benchmarks.intervals import share_interval
from benchmarks.papers.claims import Claim, reliable, share, verdict
from benchmarks.papers.porter.plan import (
    ANY_SIGN,
    BASE_2,
    BRED,
    CASES,
    CONSTANT,
    EKF,
    FEW_CHANGES,
    L1_FIXED,
    L2_FIXED,
    LINEAR,
    LINEAR_WEIGHTS,
    OSCILLATOR,
    PAPER,
    PLACED_GAIN,
    Outcomes,
)
from benchmarks.papers.porter.scores import (
    DEFAULT,
    apart,
    errors,
    failed,
    median,
    median_text,
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
        base_2(outcomes),
        fluctuations(outcomes),
        tracking(outcomes, LINEAR),
        freeze(outcomes, LINEAR),
        placed(outcomes),
        signs(outcomes),
        helped(outcomes),
        tracking(outcomes, OSCILLATOR),
        freeze(outcomes, OSCILLATOR),
        *(tracking(outcomes, case) for case in FIGURES if case not in FROZEN),
        largest(outcomes),
        model_not_input(outcomes),
        *(constant_input(outcomes, scenario) for scenario in CONSTANT),
        first_fixed(outcomes),
        second_fixed(outcomes),
        tuned(outcomes, LINEAR_WEIGHTS, 'very dependent on gamma and the alphas'),
        tuned(outcomes, FEW_CHANGES, 'large p_c and p_m are required'),
    ]


def failures(outcomes: Outcomes, scenario: str, way: str) -> tuple[int, int]:
    """Return how many runs failed, and of how many."""
    found = outcomes[scenario, way]
    return sum(map(failed, found)), len(found)


def rms_text(outcomes: Outcomes, scenario: str, way: str) -> str:
    """Return the median RMS error of x2 as text."""
    return median_text(errors(outcomes[scenario, way]))


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
        verdict(reliable(*lost)), beside(outcomes, scenario),
    )  # fmt: skip


def freeze(outcomes: Outcomes, scenario: str) -> Claim:
    """Judge the time of the freeze: the printed one is among 95 % of the runs."""
    place, printed = FROZEN[scenario]
    times = [one.frozen for one in outcomes[scenario, PAPER]]
    low, high = np.quantile(times, (0.025, 0.975), method='nearest')
    found = f'{median_text(times, " s")}; 95 % of the runs {low:.3g} to {high:.3g} s'
    return Claim(
        place, f'the tolerance of eq. 11 is met at about {printed:g} s', 'time, all seeds', found,
        verdict(low <= printed <= high), 'adapts for good',
    )  # fmt: skip


def base_2(outcomes: Outcomes) -> Claim:
    """Judge whether another coding fails as often: in no case do the intervals part."""
    pairs = [[failures(outcomes, case, way) for way in (PAPER, BASE_2)] for case in CASES]
    alike = [not apart(*(share_interval(*lost) for lost in pair)) for pair in pairs]
    ten, two = np.sum(pairs, axis=0).tolist()
    found = f'base 10: {share(*ten)}, base 2: {share(*two)}; alike in {sum(alike)} of {len(alike)}'
    return Claim(
        '2', 'base 10 is not critical, base 2 works in a similar manner',
        'share of runs that fail, six cases, 24 bits', found, verdict(all(alike)), 'base 10',
    )  # fmt: skip


def fluctuations(outcomes: Outcomes) -> Claim:
    """Judge whether gains that go on changing cost accuracy."""
    both = [[median(errors(outcomes[s, w])) for w in (PAPER, BRED)] for s in FROZEN]
    found = '; '.join(
        f'{CASES[s]}: {rms_text(outcomes, s, PAPER)} frozen, {rms_text(outcomes, s, BRED)} not'
        for s in FROZEN
    )
    return Claim(
        '3.2', 'changing gains make x2 fluctuate; their average alleviates that',
        'RMS x2, median', found, verdict(all(frozen[2] < not_[1] for frozen, not_ in both)),
        'no freeze',
    )  # fmt: skip


def placed(outcomes: Outcomes) -> Claim:
    """Judge whether gains designed beforehand do better on the linear plant."""
    one = outcomes[LINEAR, PLACED_GAIN][0]
    times = [run.settled for run in outcomes[LINEAR, PAPER]]
    return Claim(
        '4.1', 'gains designed a priori would perform better', 'time until x2 is within 0.05',
        f'poles 0.9, 0.91: {one.settled:.3g} s; GAO: {median_text(times, " s")}',
        verdict(bool(one.settled < median(times)[1])),
        f'EKF: {median_text([run.settled for run in outcomes[LINEAR, EKF]], " s")}',
    )  # fmt: skip


def signs(outcomes: Outcomes) -> Claim:
    """Judge whether the frozen gains of the linear plant have the signs of pole placement."""
    found = outcomes[LINEAR, PAPER]
    wrong = sum(not (one.last['L1'] > 0.0 > one.last['L2']) for one in found)
    return Claim(
        '4.2', 'the GA isolates the correct signs in the linear case',
        'share of runs that freeze with others than L1 > 0 > L2', share(wrong, len(found)),
        verdict(reliable(wrong, len(found))), 'the same ranges',
    )  # fmt: skip


def helped(outcomes: Outcomes) -> Claim:
    """Judge whether the oscillator needs ranges with the right signs."""
    any_sign, own = (failures(outcomes, OSCILLATOR, way) for way in (ANY_SIGN, PAPER))
    worse = share_interval(*any_sign)[0] > share_interval(*own)[1]
    return Claim(
        '4.2', 'for the oscillator it must be helped by limits of the right signs',
        'share of runs that fail', f'without: {share(*any_sign)}; with: {share(*own)}',
        verdict(worse), 'limits are settings',
    )  # fmt: skip


def largest(outcomes: Outcomes) -> Claim:
    """Judge which of the oscillator's cases have the largest errors."""
    medians = {n: median(errors(outcomes[s, PAPER])) for s, n in CASES.items() if s != LINEAR}
    order = sorted(medians, key=lambda name: medians[name][0], reverse=True)
    found = ', '.join(f'{name} {medians[name][0]:.3g}' for name in order)
    return Claim(
        '4.2', 'output noise and model mismatch show the largest error', 'RMS x2, medians', found,
        verdict(set(order[:2]) == {'disturbed', 'mismatch'}),
        ', '.join(f'{CASES[s]} {np.median(errors(outcomes[s, DEFAULT])):.3g}' for s in FIGURES
                  if s != LINEAR),
    )  # fmt: skip


def model_not_input(outcomes: Outcomes) -> Claim:
    """Judge whether a wrong model matters more than another input does."""
    inputs = [f'{OSCILLATOR}{case}' for case in ('', '_chaotic', '_gaussian')]
    lost = {s: failures(outcomes, s, PAPER) for s in inputs}
    wrong = failures(outcomes, f'{OSCILLATOR}_mismatch', PAPER)
    least, most = (pick(lost.values()) for pick in (min, max))
    alike = not apart(share_interval(*least), share_interval(*most))
    found = ', '.join(f'{CASES[s]} {share(*lost[s])}' for s in inputs)
    return Claim(
        '4.2', 'highly dependent on the model, not as much on the input',
        'share of runs that fail',
        f'{found}, mismatch {share(*wrong)}',
        verdict(alike and share_interval(*wrong)[0] > share_interval(*most)[1]),
    )  # fmt: skip


def constant_input(outcomes: Outcomes, scenario: str) -> Claim:
    """Judge whether the error goes to zero under a constant input."""
    late = {way: sum(map(unsettled, outcomes[scenario, way])) for way in (PAPER, DEFAULT)}
    runs = len(outcomes[scenario, PAPER])
    return Claim(
        '4.2', f'constant input ({CONSTANT[scenario].split(",")[0]}): the error goes to zero',
        'share of runs in which x2 is not within 0.05 for good by 20 s', share(late[PAPER], runs),
        verdict(reliable(late[PAPER], runs)), f'no freeze: {share(late[DEFAULT], runs)}',
    )  # fmt: skip


def first_fixed(outcomes: Outcomes) -> Claim:
    """Judge whether a fixed L1 serves."""
    lost = failures(outcomes, OSCILLATOR, L1_FIXED)
    return Claim(
        '4.2', 'L1 fixed by the tolerance, L2 free: still good performance',
        'share of runs of the oscillator that fail',
        f'{share(*lost)}; RMS x2 {rms_text(outcomes, OSCILLATOR, L1_FIXED)}',
        verdict(reliable(*lost)), 'both free',
    )  # fmt: skip


def second_fixed(outcomes: Outcomes) -> Claim:
    """Judge whether a fixed L2 is worse than a fixed L1."""
    first, second = (median(errors(outcomes[OSCILLATOR, way])) for way in (L1_FIXED, L2_FIXED))
    lost = failures(outcomes, OSCILLATOR, L2_FIXED)
    return Claim(
        '4.2', 'L2 fixed, L1 free: poor performance', 'RMS x2, median, above that with L1 fixed',
        f'{rms_text(outcomes, OSCILLATOR, L2_FIXED)}; {share(*lost)} fail',
        verdict(second[1] > first[2]), 'both free',
    )  # fmt: skip


def tuned(outcomes: Outcomes, way: str, sentence: str) -> Claim:
    """Judge a choice of settings by whether more runs of the oscillator fail with another one."""
    other, own = (failures(outcomes, OSCILLATOR, each) for each in (way, PAPER))
    worse = share_interval(*other)[0] > share_interval(*own)[1]
    return Claim(
        '5', sentence, f'share of runs that fail, {way.removeprefix("GAO, ")}',
        f"{share(*other)}; the paper's: {share(*own)}", verdict(worse),
    )  # fmt: skip
