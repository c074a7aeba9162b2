"""The claims of Alvarado-Méndez et al. 2024, judged by the figures."""

import numpy as np

from benchmarks.intervals import median_interval
from benchmarks.papers.alvarado import theory_claims as theory
from benchmarks.papers.alvarado.printed import PAPERS_START, RIGHT_START
from benchmarks.papers.alvarado.roads import LONG, SOFTENING, TRAPEZOID, Case, truth_of
from benchmarks.papers.alvarado.run import (
    DESIGNED,
    FILTERED,
    NEAR,
    NO_GAIN,
    PAPER,
    PRINTED,
    SCALE,
    SOON,
    WINDOWS,
    Figures,
    Measured,
    percent,
)
from benchmarks.papers.claims import Claim, Verdict, rarely, share, verdict, within
from benchmarks.play import Contestant
from benchmarks.report import slashed
from obs_ros.models.suspension import KT

OUTPUTS = (('Fig. 5', 'x1'), ('Fig. 6', 'x3'), ('Fig. 7', 'z_def'))
ZERO = 0.01  # of kt: an error below is called none
KEPT = f'share with kt within {100 * NEAR:g} % from {SOON:g} s after the first bump begins on'


def claims(figures: Figures) -> list[Claim]:
    """Return the claims in the order of the paper."""
    return [
        theory.effort(),
        without_disturbance(figures),
        *theory.theory(),
        theory.bound(),
        theory.signs(figures),
        as_printed(figures),
        scaled(figures),
        start(figures),
        *attenuation(figures),
        speeds(figures),
        despite_disturbance(figures),
        deterioration(figures),
        disturbance(figures),
    ]


def as_printed(figures: Figures) -> Claim:
    """Judge Fig. 4 with theta in N/m."""
    run = figures.found[1.0, RIGHT_START]
    moved = float(np.nanmax(np.abs(run.kt - 0.5 * KT)))
    return Claim(
        'Fig. 4, section 4',
        'with Gamma = 125 kt is estimated in adequate time',
        f'how far kt moves in {LONG:g} s, theta in N/m, no noise; holds if it ends within '
        f'{100 * NEAR:g} % of the truth',
        f'{moved:.2g} N/m of the {0.5 * KT:g} that are missing',
        verdict(bool(abs(run.kt[-1] / KT - 1.0) <= NEAR)),
        default_error(figures, TRAPEZOID),
    )


def scaled(figures: Figures) -> Claim:
    """Judge Fig. 4 with theta in a unit that the print does not have."""
    return Claim(
        'Fig. 4',
        'the same, were theta in 1e5 N/m and xhat(0) = 0',
        f'RMS of kt from {TRAPEZOID.counted:g} to {LONG:g} s, no noise; neither is printed',
        f'{late_error(figures, RIGHT_START):.2f} %',
        Verdict.CANNOT_BE_JUDGED,
        default_error(figures, TRAPEZOID),
    )


def start(figures: Figures) -> Claim:
    """Judge the paper's start by the error where it counts, after the first bump."""
    wrong, right = (late_error(figures, x0) for x0 in (PAPERS_START, RIGHT_START))
    return Claim(
        'section 5',
        f'from xhat(0) = {PAPERS_START:g} kt is estimated',
        f'RMS of kt from {TRAPEZOID.counted:g} to {LONG:g} s, no noise, theta in 1e5 N/m; holds if '
        f'below {100 * NEAR:g} %',
        f'{wrong:.3g} %; from xhat(0) = 0 {right:.3g} %',
        verdict(wrong <= 100 * NEAR),
        'starts from 0 and stays within the bounds of kt',
    )


def late_error(figures: Figures, x0: float) -> float:
    """Return the RMS of kt (%) of the printed observer after the first bump, theta in 1e5 N/m."""
    truth = truth_of(TRAPEZOID.scenario, True, 0.0, LONG)
    return percent(figures.found[SCALE, x0].kt[truth.t > TRAPEZOID.counted] / KT - 1.0)


def attenuation(figures: Figures) -> list[Claim]:
    """Judge the disturbance's effect on the outputs' estimates, beside that without a gain."""
    rows = []
    for i, (place, name) in enumerate(OUTPUTS):
        none, printed, own = (figures.known[gain][0, i] for gain in (NO_GAIN, PRINTED, DESIGNED))
        rows.append(Claim(
            place,
            f'the observer attenuates the effect of eta on {name}',
            'RMS of the estimate under 300 N in mm, kt known, no noise, beside L = 0',
            f'{printed:.3f}, with L = 0 {none:.3f}',
            verdict(printed < none),
            f'{own:.3f}',
        ))  # fmt: skip
    return rows


def speeds(figures: Figures) -> Claim:
    """Judge the states that nobody measures, which the paper does not show."""
    none, printed, own = (figures.speeds[gain] for gain in (NO_GAIN, PRINTED, DESIGNED))
    return Claim(
        'sections 1, 6',
        'the unknown states are estimated, even in the presence of disturbances',
        'the speeds x2 and x4, which are not measured: RMS of the error under 300 N in % of that '
        f'of the speed, kt known, no noise; holds if both are below {100 * NEAR:g}',
        f'{slashed(printed, ".1f")}, with L = 0 {slashed(none, ".1f")}',
        verdict(bool((printed <= 100 * NEAR).all())),
        slashed(own, '.1f'),
    )


def without_disturbance(figures: Figures) -> Claim:
    """Judge the convergence without disturbance by where the errors end."""
    found = figures.calm
    ends = {key: found[key].kt[-1] / KT - 1.0 for key in found}
    units = {1.0: 'N/m', SCALE: '1e5 N/m'}
    return Claim(
        'section 2.2, Theorem 1',
        'for eta = 0 the errors of states and parameter converge to zero',
        f'error of kt after {LONG:g} s over both bumps, no noise; holds if from xhat(0) = '
        f'{PAPERS_START:g} it is below {100 * ZERO:g} % with theta in either unit',
        '; '.join(
            f'theta in {unit}: {100 * ends[scale, PAPERS_START]:.3g} %, from xhat(0) = 0 '
            f'{100 * ends[scale, RIGHT_START]:.3g} %'
            for scale, unit in units.items()
        )
        + f'; states off by at most {max(figures.calm_states, 1e-9):.0e} m or m/s, the plant rests',
        verdict(any(abs(ends[scale, PAPERS_START]) <= ZERO for scale in units)),
        'a deviation that is withheld while the road tells nothing',
    )


def despite_disturbance(figures: Figures) -> Claim:
    """Judge the estimate of kt under the disturbance; noise on the outputs is future work there."""
    found = runs(figures, PAPER, TRAPEZOID)
    lost = sum(not run.kept for run in found)
    return Claim(
        'section 6',
        'states and parameters are estimated despite disturbances',
        f'{KEPT}, {TRAPEZOID.label}, theta in 1e5 N/m',
        kept(figures, PAPER, TRAPEZOID),
        rarely(lost, len(found)),
        f'{kept(figures, WINDOWS, TRAPEZOID)} ({WINDOWS.label}); '
        f'{kept(figures, FILTERED, TRAPEZOID)} (h_infinity)',
    )


def deterioration(figures: Figures) -> Claim:
    """Judge the estimate of kt after the tyre has softened."""
    paper, own = (
        median_interval([run.rms for run in runs(figures, one, SOFTENING)])
        for one in (PAPER, WINDOWS)
    )
    return Claim(
        'section 5',
        'the estimate of kt monitors the deterioration of the tyre',
        f'RMS of kt once the tyre has lost a fifth, {SOFTENING.label}, theta in 1e5 N/m; median of '
        f'{len(runs(figures, PAPER, SOFTENING))} seeds; holds if below {100 * NEAR:g} %',
        f'{interval(paper, ".2f")} %',
        within(paper[1:], (0.0, 100 * NEAR)),
        f'{interval(own, ".2f")} %',
    )


def disturbance(figures: Figures) -> Claim:
    """Judge whether the disturbance is estimated."""
    paper, own = (
        median_interval([run.force for run in runs(figures, one, TRAPEZOID)])
        for one in (PAPER, WINDOWS)
    )
    force = TRAPEZOID.force
    return Claim(
        'abstract',
        'the observer performs well in estimating the induced disturbance',
        f'RMS of eta in N under {force:g} N; eq. 4 has no estimate of it; '
        f'{figures.seeds} seeds, median; holds if below {100 * NEAR:g} % of the force',
        interval(paper, '.0f'),
        within(paper[1:], (0.0, NEAR * force)),
        interval(own, '.1f'),
    )


def runs(figures: Figures, one: Contestant, case: Case) -> list[Measured]:
    """Return a contestant's runs on a road."""
    return figures.runs[one.label, case.label]


def kept(figures: Figures, one: Contestant, case: Case) -> str:
    """Return the share of runs that find kt and keep it."""
    found = runs(figures, one, case)
    return share(sum(run.kept for run in found), len(found))


def default_error(figures: Figures, case: Case) -> str:
    """Return the error of kt by our windows."""
    errors = [run.rms for run in runs(figures, WINDOWS, case)]
    return f'{interval(median_interval(errors), ".2f")} % with noise'


def interval(figure: tuple[float, float, float], form: str) -> str:
    """Return a median with its interval."""
    middle, low, high = (format(value, form) for value in figure)
    return f'{middle} ({low} to {high})'
