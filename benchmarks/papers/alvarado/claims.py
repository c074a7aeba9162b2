"""The claims of Alvarado-Méndez et al. 2024, judged by the figures."""

import numpy as np

from benchmarks.intervals import median_interval
from benchmarks.papers.alvarado.printed import (
    PAPERS_START,
    RIGHT_START,
    hidden_in_psi,
    least_freedom,
    lipschitz,
    sign_choices,
)
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
from benchmarks.papers.claims import Claim, Verdict, reliable, share, verdict
from benchmarks.play import Contestant
from obs_ros.models.suspension import KT, SUSPENSION
from obs_ros.observers.papers.adaptive_gains import stored_gains
from obs_ros.observers.papers.design.linearised import stable_share
from obs_ros.observers.papers.design.peak_gain import peak_gain
from obs_ros.observers.papers.design.plants import suspension

OUTPUTS = (('Fig. 5', 'x1'), ('Fig. 6', 'x3'), ('Fig. 7', 'z_def'))
KEPT = f'share with kt within {100 * NEAR:g} % from {SOON:g} s after the first bump begins on'


def claims(figures: Figures) -> list[Claim]:
    """Return the claims in the order of the paper."""
    return [
        *theory(),
        bound(),
        signs(figures),
        as_printed(figures),
        scaled(figures),
        start(figures),
        *attenuation(figures),
        despite_disturbance(figures),
        deterioration(figures),
        disturbance(figures),
    ]


def theory() -> list[Claim]:
    """Judge what can be computed from the equations alone."""
    freedom, hidden, (slope, told) = least_freedom(), hidden_in_psi(), lipschitz()
    gains = stored_gains(SUSPENSION, 'designed')
    return [
        Claim(
            'Theorem 1, section 5',
            'the matrix inequality gives L and H for this plant',
            "norm of C B, by NumPy: B'P = HC forces B'PB = H C B, and B'PB > 0 where P > 0",
            f'{freedom:g}, so that no P > 0 exists' if not freedom else f'{freedom:g}',
            verdict(freedom > 0.0),
            f'without the equality: L with beta = {gains.beta:.3g} m/N',
        ),
        Claim(
            'eq. 37',
            'the hysteresis of the damper is a Psi(y, u)',
            'share of the argument of rho that no combination of the outputs tells',
            f'{hidden:.2f}',
            verdict(hidden < 1e-9),
            'rho of the estimated states',
        ),
        Claim(
            'eq. 40',
            'the Lipschitz constant of Phi is 1/mus',
            'slope of Phi at the true kt, in 1/s2',
            f'{slope:.1f} beside {told:.5f}',
            verdict(abs(slope - told) <= 1e-3 * slope),
            f'kt off by a fifth: {0.2 * slope:.1f}',
        ),
    ]


def bound() -> Claim:
    """Judge the bound of the theorem on the gain of the printed observer."""
    plant = suspension()
    gains = {name: stored_gains(SUSPENSION, name) for name in ('printed', 'designed')}
    peaks = {name: peak_gain(plant, each.L) for name, each in gains.items()}
    return Claim(
        'Theorem 1, eq. 25',
        "the L2 gain from eta to the outputs' error is below beta",
        'no beta is printed; largest gain over frequencies and kt within +-20 %, m/N',
        f'{peaks["printed"]:.3g}, with L = 0 {peak_gain(plant, 0.0 * gains["printed"].L):.3g}',
        Verdict.CANNOT_BE_JUDGED,
        f'{peaks["designed"]:.3g}, below beta = {gains["designed"].beta:.3g}',
    )


def signs(figures: Figures) -> Claim:
    """Tell what the printed gains may have been."""
    choices = sign_choices()
    stable = [one for one in choices if one.stable]
    stored = stored_gains(SUSPENSION, 'printed').L
    taken = next(i for i, one in enumerate(stable) if np.allclose(one.L, stored))
    spread = ' / '.join(f'{error:.3g}' for error in figures.signs)
    return Claim(
        'section 5',
        'these are L and H',
        "choices of a sign for each row that make the paper's A - L C stable, minus signs being "
        'lost; and the RMS of kt with each, no noise, theta in 1e5 N/m',
        f'{len(stable)} of {len(choices)}: {spread} %; taken is number {taken + 1}',
        Verdict.CANNOT_BE_JUDGED,
        'stable at {} of {} points of the box'.format(
            *stable_share(SUSPENSION, stored_gains(SUSPENSION, 'designed').L)
        ),
    )


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


def despite_disturbance(figures: Figures) -> Claim:
    """Judge the estimate of kt under the disturbance; noise on the outputs is future work there."""
    found = runs(figures, PAPER, TRAPEZOID)
    lost = sum(not run.kept for run in found)
    return Claim(
        'section 6',
        'states and parameters are estimated despite disturbances',
        f'{KEPT}, {TRAPEZOID.label}, theta in 1e5 N/m',
        kept(figures, PAPER, TRAPEZOID),
        verdict(reliable(lost, len(found))),
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
        verdict(paper[2] <= 100 * NEAR),
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
        f'{figures.seeds} seeds, median',
        interval(paper, '.0f'),
        verdict(paper[0] <= NEAR * force),
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
