"""The claims of Gremling & Passino 2000, judged by the figures."""

from collections.abc import Callable

import numpy as np

from benchmarks.intervals import ratio_interval
from benchmarks.papers.claims import (
    AS_WELL,
    Claim,
    Interval,
    Ratio,
    Verdict,
    below,
    every,
    rarely,
    share,
    verdict,
    within,
)
from benchmarks.papers.gremling import count_claims as counts
from benchmarks.papers.gremling.kalman import FAR
from benchmarks.papers.gremling.plan import (
    BASE_2,
    DEFAULT,
    EKF,
    JETS,
    LINEAR,
    LUENBERGER,
    MIDDLE,
    MINIMUM,
    NON_MINIMUM,
    PAPER,
)
from benchmarks.papers.gremling.run import Figures
from benchmarks.papers.gremling.scores import (
    LATE,
    intervals,
    mean_interval,
    mean_text,
    squares,
    unbounded,
    undetected,
)
from benchmarks.papers.observed import GROWN
from benchmarks.report import slashed

TABLES = {MINIMUM: ('Table 1', (4328.79, 2008.48)), NON_MINIMUM: ('Table 2', (7244.04, 2563.16))}
JET_TABLES = {'Table 3': ('jet_engine_case1', (310.91, 1116.81)),
              'Table 4': ('jet_engine_case2', (186.77, 226.11))}  # fmt: skip
LUENBERGER_SUMS = {MINIMUM: ('4.2', (4365.23, 3427.46)), NON_MINIMUM: ('5.2', (6320.0, 8348.1))}
PRINTED_RUNS = 50
LUENBERGER_WITHIN = 0.005
SIMILAR = 1.5  # factor of sums
ZERO = 0.05  # of a state's own RMS: an error below is called none


def claims(figures: Figures) -> list[Claim]:
    """Return the claims in the order of the paper."""
    return [
        to_zero(figures),
        higher_performance(figures),
        base_2(figures),
        counts.operations(figures),
        counts.whole_draws(figures),
        counts.real_draws(figures),
        printed_sums(figures, MINIMUM),
        luenberger(figures, MINIMUM),
        as_well(figures),
        printed_sums(figures, NON_MINIMUM),
        luenberger(figures, NON_MINIMUM),
        outperformed(figures),
        *(jet_sums(figures, table) for table in JET_TABLES),
        *(detection(figures, case) for case in JETS),
        surge(),
        never_fails(figures),
        kalman(figures),
    ]


def to_zero(figures: Figures) -> Claim:
    """Judge the abstract's error that is driven to zero, on the linear plants."""
    relative = {
        way: {s: np.array([one.rms[1:] / one.size[1:] for one in figures.outcomes[s, way]])
              for s in LINEAR}
        for way in (PAPER, DEFAULT)
    }  # fmt: skip
    texts = {
        way: '; '.join(f'{LINEAR[s]} {mean_text(each, ".3f")}' for s, each in own.items())
        for way, own in relative.items()
    }
    small = every(
        within(ends, (-np.inf, ZERO)) for own in relative[PAPER].values() for ends in intervals(own)
    )
    return Claim(
        'Abstract', 'the state estimation error is driven to zero',
        'RMS x2 / x3 over the second half, by the RMS of the state: means of '
        f'{len(relative[PAPER][MINIMUM])} runs; holds if below {ZERO:g}', texts[PAPER],
        small, texts[DEFAULT],
    )  # fmt: skip


def higher_performance(figures: Figures) -> Claim:
    """Judge the main conclusion beside a Kalman filter that estimates the parameters, too."""
    found: list[str] = []
    better: list[Verdict] = []
    for case, name in JETS.items():
        own, other = (squares(figures.outcomes, case, way) for way in (PAPER, EKF))
        found.append(f'{name}: {mean_text(own, ".3g")}, {EKF} {mean_text(other, ".3g")}')
        better += map(below, intervals(own), intervals(other))
    ours = '; '.join(
        f'{name}: {mean_text(squares(figures.outcomes, case, DEFAULT), ".3g")}'
        for case, name in JETS.items()
    )
    return Claim(
        'Abstract, 7', 'for nonlinear systems, potentially higher performance than other methods',
        'Es R / Phi of the jet engine, means', '; '.join(found), every(better), ours,
    )  # fmt: skip


def base_2(figures: Figures) -> Claim:
    """Judge whether another coding serves as well, plant by plant."""
    found = {
        name: [
            Ratio(*ratio_interval([own], [other]))
            for own, other in zip(
                squares(figures.outcomes, scenario, BASE_2).T,
                squares(figures.outcomes, scenario, PAPER).T,
                strict=True,
            )
        ]
        for scenario, name in (LINEAR | JETS).items()
    }
    return Claim(
        '2', 'a base-2 GA could just as easily be used',
        f'Es of base 2 over those of base 10, medians of {len(figures.outcomes[MINIMUM, BASE_2])} '
        f'runs, x2 / x3 or R / Phi; holds if within a factor of {SIMILAR:g}',
        '; '.join(f'{name}: {" / ".join(map(str, own))}' for name, own in found.items()),
        every(
            within(one.ends, (1.0 / SIMILAR, SIMILAR)) for own in found.values() for one in own
        ),
        'base 10',
    )  # fmt: skip


def printed_sums(figures: Figures, scenario: str) -> Claim:
    """Judge a table: its means lie where the mean of as many further runs would."""
    place, printed = TABLES[scenario]
    own = squares(figures.outcomes, scenario, PAPER)
    _, low, high = mean_interval(own, PRINTED_RUNS)
    inside = bool(((low <= printed) & (printed <= high)).all())
    return Claim(
        place, f'Es x2 / x3, mean of {PRINTED_RUNS} runs: {slashed(printed, ".0f")}',
        f'{len(own)} runs of our reading, `gase` in mode `paper`; 95 % of the means of '
        f'{PRINTED_RUNS} others lie within {slashed(low, ".0f")} to {slashed(high, ".0f")}',
        mean_text(own), verdict(inside),
        mean_text(squares(figures.outcomes, scenario, DEFAULT)),
    )  # fmt: skip


def luenberger(figures: Figures, scenario: str) -> Claim:
    """Judge the sums of the adaptive Luenberger observer."""
    place, printed = LUENBERGER_SUMS[scenario]
    own = squares(figures.outcomes, scenario, LUENBERGER)
    off = own[0] / printed - 1.0
    return Claim(
        place, f'adaptive Luenberger observer: Es x2 / x3 {slashed(printed, ".0f")}',
        f'one run, no randomness; within {100.0 * LUENBERGER_WITHIN:g} %', mean_text(own),
        verdict(bool((np.abs(off) <= LUENBERGER_WITHIN).all())),
    )  # fmt: skip


def as_well(figures: Figures) -> Claim:
    """Judge whether the GA is no worse than the adaptive Luenberger observer, minimum phase."""
    return _beside_luenberger(
        figures, MINIMUM, '4.2', 'the GA performs as well as the adaptive Luenberger observer',
        f'below {AS_WELL:g} times those of the observer',
        lambda own, sums: below(own, (AS_WELL * sums[0], AS_WELL * sums[1])),
    )  # fmt: skip


def outperformed(figures: Figures) -> Claim:
    """Judge whether the adaptive Luenberger observer is better, non-minimum phase."""
    return _beside_luenberger(
        figures, NON_MINIMUM, '5.2', 'the GA was somewhat outperformed by the Luenberger observer',
        'above those of the observer', lambda own, sums: below(sums, own),
    )  # fmt: skip


def _beside_luenberger(
    figures: Figures,
    scenario: str,
    place: str,
    claim: str,
    rule: str,
    compare: Callable[[Interval, Interval], Verdict],
) -> Claim:
    """Judge by intervals of the GA's sums, beside those of the adaptive Luenberger observer."""
    own, other = (squares(figures.outcomes, scenario, way) for way in (PAPER, LUENBERGER))
    return Claim(
        place, claim, f'Es x2 / x3, mean of {len(own)} runs; holds if both are {rule}',
        f'{mean_text(own)}; Luenberger {mean_text(other)}',
        every(map(compare, intervals(own), intervals(other))), middle(figures, scenario),
    )  # fmt: skip


def middle(figures: Figures, scenario: str) -> str:
    """Return the sums of our default, and of no estimation at all, as text."""
    own, fixed = (squares(figures.outcomes, scenario, way) for way in (DEFAULT, MIDDLE))
    return f'{mean_text(own)}; {MIDDLE}, in open loop: {mean_text(fixed)}'


def jet_sums(figures: Figures, place: str) -> Claim:
    """Tell the sums on the jet engine: the reference is drawn in a figure only."""
    case, printed = JET_TABLES[place]
    return Claim(
        place, f'Es R / Phi, mean of {PRINTED_RUNS} runs: {slashed(printed, ".0f")}',
        'the reference is not in print; under our ramp',
        mean_text(squares(figures.outcomes, case, PAPER), '.3g'), Verdict.CANNOT_BE_JUDGED,
        mean_text(squares(figures.outcomes, case, DEFAULT), '.3g'),
    )  # fmt: skip


def detection(figures: Figures, case: str) -> Claim:
    """Judge whether estimated stall cells grow when the true ones do."""
    missed = {
        way: (sum(map(undetected, figures.outcomes[case, way])), len(figures.outcomes[case, way]))
        for way in (PAPER, EKF)
    }
    return Claim(
        '6.2, 7', f'the growth of stall cells is detected ({JETS[case]})',
        f'share of runs in which the estimated R does not pass {GROWN:g} within {LATE:g} s of the '
        'true R',
        share(*missed[PAPER]), rarely(*missed[PAPER]),
        f'{EKF}: {"missed" if missed[EKF][0] else "detected"}',
    )  # fmt: skip


def surge() -> Claim:
    """Tell why the onset of surge is not judged."""
    return Claim(
        '6.2, 7', 'the onset of surge is detected',
        'surge is an oscillation of Phi (6.1), and the reference that brings it about is not in '
        'print', 'under our ramp Phi does not oscillate', Verdict.CANNOT_BE_JUDGED,
    )  # fmt: skip


def never_fails(figures: Figures) -> Claim:
    """Judge whether the estimator never fails on the jet engine, as filters are judged there."""
    found = [one for case in JETS for one in figures.outcomes[case, PAPER]]
    lost = sum(map(unbounded, found))
    return Claim(
        '6.3', 'the genetic estimator never failed',
        f'share of runs that start again or have a state off by more than {FAR:g}, both cases',
        share(lost, len(found)), rarely(lost, len(found)),
    )  # fmt: skip


def kalman(figures: Figures) -> Claim:
    """Tell how many extended Kalman filters are unstable: the paper's own is not in print."""
    counts = {
        kept: [bad for one, bad in figures.filters.items() if one.kept == kept]
        for kept in (True, False)
    }
    told = '; '.join(
        f'{sum(bad)} of {len(bad)} {"with" if kept else "without"} R >= 0 kept'
        for kept, bad in counts.items()
    )
    return Claim(
        '6.3', 'an extended Kalman filter with small covariances becomes unstable in all runs',
        'initial covariance and reference are not in print; filters tried under our ramp',
        f'unstable: {told}', Verdict.CANNOT_BE_JUDGED,
        f'{EKF}: ' + '; '.join(
            mean_text(squares(figures.outcomes, case, EKF), '.3g') for case in JETS
        ),
    )  # fmt: skip
