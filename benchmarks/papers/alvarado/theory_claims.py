"""The claims of Alvarado-Méndez et al. 2024 on equations, gains and signs, judged."""

import numpy as np

from benchmarks.papers.alvarado.printed import (
    hidden_in_psi,
    least_freedom,
    lipschitz,
    sign_choices,
)
from benchmarks.papers.alvarado.run import Figures
from benchmarks.papers.claims import Claim, Verdict, verdict
from obs_ros.models.suspension import SUSPENSION
from obs_ros.observers.papers.adaptive_gains import stored_gains
from obs_ros.observers.papers.design.linearised import stable_share
from obs_ros.observers.papers.design.peak_gain import peak_gain
from obs_ros.observers.papers.design.plants import suspension


def equations() -> int:
    """Return how many scalar differential equations the observer of eq. 4 has."""
    return len(SUSPENSION.states) + 1


def kalman_equations(parameters: int) -> int:
    """Return how many a Kalman filter has: of the unknowns, and of their covariances."""
    unknowns = len(SUSPENSION.states) + parameters
    return unknowns + unknowns * (unknowns + 1) // 2


def effort() -> Claim:
    """Judge the effort of the observer by the differential equations that it integrates."""
    own, other = equations(), kalman_equations(1)
    return Claim(
        'sections 1, 6',
        'no additional differential equations are solved, as a Kalman observer does',
        'scalar differential equations, beside those of a Kalman filter of the states and kt; no '
        'time is printed',
        f'{own} beside {other}',
        verdict(own < other),
        f'{kalman_equations(2)} of the EKF that estimates eta, too; time of a sample: '
        '`benchmarks.observer_costs`',
    )


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
