"""The claims of Porter & Passino 1995 on gains and the settings that choose them."""

import itertools
from collections.abc import Collection

from benchmarks.papers.claims import (
    Claim,
    Verdict,
    below,
    every,
    opposite,
    rarely,
    share,
)
from benchmarks.papers.observed import diverged
from benchmarks.papers.porter.plan import (
    ALPHAS,
    ANY_SIGN,
    BRED,
    CASES,
    EKF,
    FEW_CHANGES,
    GAMMAS,
    L1_FIXED,
    L2_FIXED,
    LINEAR,
    OSCILLATOR,
    PAPER,
    PLACED_GAIN,
    Outcomes,
)
from benchmarks.papers.porter.scores import (
    ALIKE,
    SIMILAR,
    alike,
    apart,
    ends,
    errors,
    fail_ends,
    failures,
    median,
    median_text,
    rms_text,
)

PLANTS = (LINEAR, OSCILLATOR)


def fluctuations(outcomes: Outcomes) -> Claim:
    """Judge whether gains that go on changing cost accuracy."""
    both = [[ends(errors(outcomes[s, w])) for w in (PAPER, BRED)] for s in PLANTS]
    found = '; '.join(
        f'{CASES[s]}: {rms_text(outcomes, s, PAPER)} frozen, {rms_text(outcomes, s, BRED)} not'
        for s in PLANTS
    )
    return Claim(
        '3.2', 'changing gains make x2 fluctuate; their average alleviates that',
        'RMS x2, median', found, every(below(*pair) for pair in both), 'no freeze',
    )  # fmt: skip


def placed(outcomes: Outcomes) -> Claim:
    """Judge whether gains designed beforehand do better on the linear plant."""
    one = outcomes[LINEAR, PLACED_GAIN][0]
    times = [run.settled for run in outcomes[LINEAR, PAPER]]
    return Claim(
        '4.1', 'gains designed a priori would perform better', 'time until x2 is within 0.05',
        f'poles 0.9, 0.91: {one.settled:.3g} s; GAO: {median_text(times, " s")}',
        below((one.settled, one.settled), ends(times)),
        f'EKF: {median_text([run.settled for run in outcomes[LINEAR, EKF]], " s")}',
    )  # fmt: skip


def signs(outcomes: Outcomes) -> Claim:
    """Judge whether the frozen gains of the linear plant have the signs of pole placement."""
    found = outcomes[LINEAR, PAPER]
    wrong = sum(not (one.last['L1'] > 0.0 > one.last['L2']) for one in found)
    return Claim(
        '4.2', 'the GA isolates the correct signs in the linear case',
        'share of runs that freeze with others than L1 > 0 > L2', share(wrong, len(found)),
        rarely(wrong, len(found)), 'the same ranges',
    )  # fmt: skip


def helped(outcomes: Outcomes) -> Claim:
    """Judge whether the oscillator needs ranges with the right signs."""
    any_sign, own = (failures(outcomes, OSCILLATOR, way) for way in (ANY_SIGN, PAPER))
    worse = below(*(fail_ends(outcomes, OSCILLATOR, way) for way in (PAPER, ANY_SIGN)))
    return Claim(
        '4.2', 'for the oscillator it must be helped by limits of the right signs',
        'share of runs that fail', f'without: {share(*any_sign)}; with: {share(*own)}',
        worse, 'limits are settings',
    )  # fmt: skip


def different(outcomes: Outcomes) -> Claim:
    """Judge whether the cases of the oscillator end with different gains."""
    last = {
        name: [median(one.last[gain] for one in outcomes[s, PAPER]) for gain in ('L1', 'L2')]
        for s, name in CASES.items()
        if s != LINEAR
    }
    pairs = [
        any(apart(a[1:], b[1:]) for a, b in zip(*pair, strict=True))
        for pair in itertools.combinations(last.values(), 2)
    ]
    return Claim(
        '4.2', 'the final gains are different in each case',
        'medians of L1 / L2; holds if for every two cases the intervals of one gain are apart',
        ', '.join(f'{name} {one[0]:.3g} / {two[0]:.3g}' for name, (one, two) in last.items())
        + f'; apart in {sum(pairs)} of {len(pairs)}',
        Verdict.HOLDS if all(pairs) else Verdict.NOT_SHOWN,
    )  # fmt: skip


def first_fixed(outcomes: Outcomes) -> Claim:
    """Judge whether a fixed L1 serves."""
    lost = failures(outcomes, OSCILLATOR, L1_FIXED)
    return Claim(
        '4.2', 'L1 fixed by the tolerance, L2 free: still good performance',
        'share of runs of the oscillator that fail',
        f'{share(*lost)}; RMS x2 {rms_text(outcomes, OSCILLATOR, L1_FIXED)}',
        rarely(*lost), 'both free',
    )  # fmt: skip


def second_fixed(outcomes: Outcomes) -> Claim:
    """Judge whether a fixed L2 is worse than a fixed L1."""
    both = (ends(errors(outcomes[OSCILLATOR, way])) for way in (L1_FIXED, L2_FIXED))
    lost = failures(outcomes, OSCILLATOR, L2_FIXED)
    return Claim(
        '4.2', 'L2 fixed, L1 free: poor performance', 'RMS x2, median, above that with L1 fixed',
        f'{rms_text(outcomes, OSCILLATOR, L2_FIXED)}; {share(*lost)} fail',
        below(*both), 'both free',
    )  # fmt: skip


def tolerant(outcomes: Outcomes) -> Claim:
    """Judge which plant bears gains that change with every sample."""
    found = {s: [one.rms[1] / one.size[1] for one in outcomes[s, BRED]] for s in PLANTS}
    return Claim(
        '5', 'the linear system is more tolerant of changes of the gains',
        'RMS x2 by the RMS of x2 itself without the freeze, medians',
        ', '.join(f'{CASES[s]} {median_text(found[s])}' for s in PLANTS),
        below(*(ends(found[s]) for s in PLANTS)),
    )  # fmt: skip


def dependent(outcomes: Outcomes, sentence: str, others: Collection[str]) -> Claim:
    """Judge what a setting changes on the oscillator by several values, lower and higher."""
    same = [alike(outcomes, OSCILLATOR, PAPER, way) for way in others]
    ways = (PAPER, *others)
    return Claim(
        '5', f'the nonlinear system is very dependent on {sentence}',
        'RMS x2, median, and share of runs that fail; holds if one value changes them by more '
        f'than a factor of {SIMILAR:g} or by {ALIKE:g}',
        '; '.join(
            f'{way.removeprefix("GAO, ")} {rms_text(outcomes, OSCILLATOR, way)}, '
            f'{share(*failures(outcomes, OSCILLATOR, way))}' for way in ways
        ),
        opposite(every(same)),
    )  # fmt: skip


def large_changes(outcomes: Outcomes) -> Claim:
    """Judge whether more runs of the oscillator fail with small probabilities of the operators."""
    other, own = (failures(outcomes, OSCILLATOR, way) for way in (FEW_CHANGES, PAPER))
    return Claim(
        '5', 'large p_c and p_m are required',
        f'share of runs that fail, {FEW_CHANGES.removeprefix("GAO, ")}',
        f"{share(*other)}; the paper's: {share(*own)}",
        below(*(fail_ends(outcomes, OSCILLATOR, way) for way in (PAPER, FEW_CHANGES))),
    )  # fmt: skip


def unstable(outcomes: Outcomes) -> Claim:
    """Judge whether another choice of settings can make the observer diverge: one run shows it."""
    found = {way: outcomes[OSCILLATOR, way] for way in (*GAMMAS, *ALPHAS, FEW_CHANGES)}
    lost = {way: sum(map(diverged, own)) for way, own in found.items()}
    return Claim(
        '5', 'a poor choice of settings sometimes results in unstable behavior',
        'share of runs that diverge; one is enough',
        ', '.join(f'{way.removeprefix("GAO, ")}: {share(lost[way], len(own))}'
                  for way, own in found.items()),
        Verdict.HOLDS if any(lost.values()) else Verdict.NOT_SHOWN,
    )  # fmt: skip
