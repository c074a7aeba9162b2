"""The claims of Zhang et al. 2020, judged by the figures."""

import itertools

import numpy as np

from benchmarks.intervals import share_interval
from benchmarks.papers.claims import (
    Claim,
    Verdict,
    below,
    every,
    never,
    rarely,
    share,
    verdict,
)
from benchmarks.papers.zhang import theorem_claims
from benchmarks.papers.zhang.plants import (
    CALM,
    CLOGGED,
    COLD,
    HARDENED,
    PROCESS,
    SETTLED,
    UTILITY,
    flow_ratio,
    steady,
)
from benchmarks.papers.zhang.run import (
    BAND,
    OURS,
    PAPER,
    PULLS,
    SLOW_NOISE,
    THETAS,
    UNKNOWN,
    Figures,
    settling,
)
from benchmarks.papers.zhang.scores import (
    ALIKE,
    alike,
    bracketed,
    middle,
    middle_ends,
    named,
    quiet,
    signed,
    times,
)
from benchmarks.report import slashed
from plant_sim.scenarios.heat_exchanger import NOISE, NOMINAL

NOISY = f'noise of {NOISE:g} K over 0.1 s, of which the print says that it is coloured'
NO_TUNING = "no tuning of the rival is printed; its tau here follow the paper's curves"


def claims(figures: Figures) -> list[Claim]:
    """Return the claims in the order of the paper."""
    return [
        *theorem_claims.theorems(),
        one_coefficient(),
        chamber(),
        valve_states(figures),
        faulty_valve(figures),
        gain(figures),
        temperatures(figures),
        *case_1(figures),
        anywhere(figures),
        *tuning(figures),
        *changes(),
        *case_2(figures),
        *robustness(figures),
        supervision(figures),
    ]


def one_coefficient() -> Claim:
    """Judge the one Cv of both valves."""
    here, printed = flow_ratio()
    return Claim(
        'sections 4.1.1, 4.3',
        'both valves have the same Cv',
        'Fu / Fp at rest from the printed constants, beside the printed flows',
        f'{here:.2f} beside {printed:.2f}',
        verdict(abs(here - printed) <= ALIKE * printed),
        'a Cv for each valve, from the printed flows',
    )


def chamber() -> Claim:
    """Tell what became of the pressures in the chambers."""
    return Claim(
        'section 4.1.1, eq. 41, 47',
        'the pressures of both chambers are states, with the command pressures as inputs',
        'V0, pa and the command pressures are not printed; section 4.3 has the pressures measured',
        'left out: the observers here take pc1 and pc2 as inputs, so that k3 and k6 do not occur',
        Verdict.CANNOT_BE_JUDGED,
        'the same',
    )


def valve_states(figures: Figures) -> Claim:
    """Judge the states of valves that are as their model has them."""
    found = figures.valves
    late = np.array([settling(found.t, found.opened[:, i], 0.0, COLD.end) for i in range(2)])
    return Claim(
        'sections 2, 5, eq. 47',
        'the states of the actuators are estimated',
        'no noise: time until X1 / X2 stay within 2 % in case 1, from shut valves on; RMS error of '
        f'V1 / V2 in case 3 in % of their RMS; holds if all settle and V is within '
        f'{100 * BAND:g} %',
        f'{times(late)} s; {slashed(100.0 * found.moving)}',
        verdict(bool(np.isfinite(late).all() and (found.moving <= BAND).all())),
        'the same',
    )


def faulty_valve(figures: Figures) -> Claim:
    """Judge the openings of valves that are no longer as their model has them."""
    off = np.abs(figures.valves.faulty)
    return Claim(
        'sections 2, 4.3.2',
        'local dynamics are monitored: the states of a valve whose parameter has changed',
        'error of X1 after dP1 has fallen, of X2 after k2 has risen, 6 s after each, in %; no '
        f'noise; holds if both are within {100 * BAND:g}',
        slashed(100.0 * off),
        verdict(bool((off <= BAND).all())),
        'the same: the residual tells the fault; windows estimate k2 and X2',
    )


def gain(figures: Figures) -> Claim:
    """Judge eq. 48 to the letter."""
    return Claim(
        'eq. 48',
        'this observer finds the flows',
        'eq. 48 to the letter in case 1, no noise: time until Fp / Fu stay within 2 % (s)',
        times(figures.printed),
        verdict(bool(np.isfinite(figures.printed).all())),
        f'theta^2 / g and c V in its place: {times(quiet(figures, PAPER, COLD).settled)}',
    )


def temperatures(figures: Figures) -> Claim:
    """Judge Figs. 3 and 4."""
    warm = quiet(figures, PAPER, COLD).warm
    return Claim(
        'section 4.3.1, Fig. 3-4',
        'estimated temperatures converge within several seconds',
        'time until both are within 0.1 K, no noise',
        f'{warm:.2f} s',
        verdict(warm <= 5.0),
        f'{quiet(figures, OURS, COLD).warm:.2f} s',
    )


def case_1(figures: Figures) -> list[Claim]:
    """Judge the convergence of the flows in case 1."""
    paper, rival, own = (quiet(figures, one, COLD).settled for one in (PAPER, UNKNOWN, OURS))
    judged = 'time until within 2 % of the flow, no noise'
    return [
        Claim('Fig. 5', 'Fp takes less than 1 s', judged, f'{paper[0]:.2f} s',
              verdict(paper[0] < 1.0), f'{own[0]:.2f} s from this start'),
        Claim('Fig. 6', 'Fu takes less than 0.5 s', judged, f'{paper[1]:.2f} s',
              verdict(paper[1] < 0.5), f'{own[1]:.2f} s from this start'),
        Claim('Fig. 5-6', 'the unknown-input observer takes 5 s for Fp and 1.5 s for Fu',
              f'{judged}; {NO_TUNING}', times(rival), Verdict.CANNOT_BE_JUDGED, times(own)),
        Claim('Fig. 5-6', 'the proposed observer is obviously faster than that', judged,
              f'{times(paper)} beside {times(rival)}', verdict(bool((paper < rival).all())),
              times(own)),
    ]  # fmt: skip


def anywhere(figures: Figures) -> Claim:
    """Judge the convergence from random starts."""
    runs = figures.starts
    good = sum(bool(np.isfinite(run.settled).all()) for run in runs)
    return Claim(
        'section 4.3.1',
        'whatever the initial flows are, convergence is guaranteed',
        f'share of {len(runs)} starts within 2 % after {SETTLED:g} s: flows from 0 to 5 times '
        'nominal, temperatures between those of the inlets; no noise; one that is not refutes it',
        share(good, len(runs)),
        never(len(runs) - good, len(runs)),
    )


def tuning(figures: Figures) -> list[Claim]:
    """Judge what is said of larger tuning parameters."""
    tuned = [figures.tuned[theta] for theta in THETAS]
    pulled = [figures.pulled[factor] for factor in PULLS]
    faster = all((b < a).all() for a, b in itertools.pairwise(tuned))
    helps = all((b < a).all() for a, b in itertools.pairwise(pulled))
    loud, calm = (middle(figures.noisy, one, UTILITY) for one in (PAPER, OURS))
    ends = (middle_ends(figures.noisy, one, UTILITY) for one in (OURS, PAPER))
    return [
        Claim('section 4.3.1', 'a larger theta ensures a shorter convergence',
              f'settling of Fp / Fu in case 1 with theta {slashed(THETAS, "g")}, no noise',
              ', '.join(times(one) for one in tuned), verdict(faster)),
        Claim('section 4.3.1', 'larger k1 to k4 ensure a shorter convergence',
              f'the same, theta 80, with the printed k times {slashed(PULLS, "g")}',
              ', '.join(times(one) for one in pulled), verdict(helps),
              'k = 0: larger ones pull the model of a faulty valve to the flow, and hide it'),
        Claim('section 4.3.1', 'a large theta is too sensitive to noise',
              f'median RMS of Fp / Fu in %, {NOISY}', slashed(loud),
              every(map(below, *ends)), slashed(calm)),
    ]  # fmt: skip


def changes() -> list[Claim]:
    """Judge the temperatures of case 2, by the steady states of the paper's own equations."""
    rest = [np.array(steady(p)) for p in (NOMINAL, CLOGGED, HARDENED)]
    first, second = rest[1] - rest[0], rest[2] - rest[1]
    judged = f"steady states of the paper's equations; sign, and size within {100 * ALIKE:g} %"
    return [
        Claim('Fig. 7-8', 'at 80 s Tp and Tu drop by 0.2 K', judged,
              f'{signed(first)} K', verdict(alike(first, (-0.2, -0.2)))),
        Claim('Fig. 7-8', 'at 150 s Tp drops by 0.9 K and Tu by 0.5 K', judged,
              f'{signed(second)} K', verdict(alike(second, (-0.9, -0.5)))),
        Claim('section 4.3.2', 'noise hides the change at 80 s from the eye',
              f'the noise is not printed; change beside {NOISE:g} K',
              f'{np.abs(first).min() / NOISE:.0f} standard deviations', Verdict.CANNOT_BE_JUDGED),
    ]  # fmt: skip


def case_2(figures: Figures) -> list[Claim]:
    """Judge the convergence after the faults."""
    rows = []
    for place, name, i, case in (('Fig. 9', 'Fp', 0, PROCESS), ('Fig. 10', 'Fu', 1, UTILITY)):
        paper, rival, own = (quiet(figures, one, case).settled[i] for one in (PAPER, UNKNOWN, OURS))
        judged = 'time after the fault until within 2 % of the flow, no noise'
        if case == PROCESS:
            rows.append(Claim(place, 'the unknown-input observer finds Fp 1.5 s after 150 s',
                              f'{judged}; {NO_TUNING}', f'{rival:.2f} s',
                              Verdict.CANNOT_BE_JUDGED, f'{own:.2f} s'))  # fmt: skip
        rows.append(Claim(place, f'the proposed observer finds {name} sooner', judged,
                          f'{paper:.2f} s beside {rival:.2f} s', verdict(paper < rival),
                          f'{own:.2f} s'))  # fmt: skip
    return rows


def robustness(figures: Figures) -> list[Claim]:
    """Judge the robustness to noise, seed by seed beside the rival."""
    rows = []
    for place, name, i, case in (('Fig. 5, 9', 'Fp', 0, PROCESS), ('Fig. 6, 10', 'Fu', 1, UTILITY)):
        paper, rival, own = (
            np.array([run.rms[i] for run in figures.noisy[one.label, case.label]])
            for one in (PAPER, UNKNOWN, OURS)
        )
        hits = int((paper < rival).sum())
        rows.append(Claim(
            place,
            f'{name} is more robust to noise than by the unknown-input observer',
            f'share of {paper.size} seeds with the smaller RMS; holds if its interval is above a '
            f'half; medians in %; {NOISY}',
            f'{share(hits, paper.size)}; {bracketed(paper)} beside {bracketed(rival)}',
            below((0.5, 0.5), share_interval(hits, paper.size)),
            bracketed(own),
        ))  # fmt: skip
    paper, rival, own = (middle(figures.slow, one, CALM) for one in (PAPER, UNKNOWN, OURS))
    rows.append(Claim(
        'Fig. 5-6, 9-10',
        'the same, should the noise be slower than that',
        f'median RMS of Fp / Fu in %, noise of {NOISE:g} K over {SLOW_NOISE:g} s, '
        f'{len(figures.slow[PAPER.label, CALM.label])} seeds',
        f'{slashed(paper)} beside {slashed(rival)}',
        every(map(below, *(middle_ends(figures.slow, one, CALM) for one in (PAPER, UNKNOWN)))),
        slashed(own),
    ))  # fmt: skip
    return rows


def supervision(figures: Figures) -> Claim:
    """Judge whether the faulty valve can be told."""
    hits, count = named(figures, PAPER)
    return Claim(
        'section 4.3.2, section 5',
        'local supervision tells changes of the actuators that temperatures hide',
        f'share of {count} faults, half of each valve, whose valve has the residual that changes '
        f'most, in the 2nd second; {NOISY}',
        share(hits, count),
        rarely(count - hits, count),
        share(*named(figures, OURS)),
    )
