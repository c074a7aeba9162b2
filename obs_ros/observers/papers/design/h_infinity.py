"""Gains of the H-infinity adaptive observer, Alvarado-Méndez et al. 2024, Theorem 1.

`python -m obs_ros.observers.papers.design.h_infinity` solves the matrix inequality for the
suspension and prints L, H, beta and the peak gain that L really has. With `--model NAME` and
`--parameters NAME ...` it does so for any model, about its nominal point; `--keep FILE` keeps the
gains, and the observer takes them by `h_infinity.gains: FILE`. It needs cvxpy with Clarabel:
`pip install cvxpy clarabel`.
"""

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from obs_ros.core.model import Model
from obs_ros.core.typing import AnyArray, Array
from obs_ros.models import load_model
from obs_ros.observers.papers.adaptive_gains import gains_of, write_gains
from obs_ros.observers.papers.design.linearised import linearised, stable_share
from obs_ros.observers.papers.design.peak_gain import peak_gain
from obs_ros.observers.papers.design.plants import LipschitzPlant, suspension

SUSPENSION = 'suspension'
COMMAND = 'python -m obs_ros.observers.papers.design.h_infinity'


@dataclass(frozen=True)
class DesignSettings:
    """Tolerances of a solution, in the plant's own units, where everything is of order one."""

    least_p: float = 1e-6  # least eigenvalue asked of P, which the solver may miss by half
    tolerance: float = 1e-7  # by which the inequality may fail, of its largest entry
    mismatch: float = 1e-4  # by which the equality may fail, of B'P
    excess: float = 1e-6  # of the measured gain above the bound: its grid of frequencies


DESIGN_DEFAULTS = DesignSettings()


@dataclass(frozen=True, eq=False)
class Gains:
    """L (n, r), B (n, l), H (l, r), the certificate P (n, n), and |C e| <= beta |eta| in L2.

    `mismatch` is the size of B'P - HC beside that of B'P: 0 where the theorem's equality holds.
    `peak` is the largest gain from eta to C e over all frequencies, with phi at its steepest.
    """

    L: Array
    B: Array
    H: Array
    P: Array
    beta: float
    peak: float
    mismatch: float
    poles: AnyArray


def design(
    plant: LipschitzPlant,
    *,
    noise: float = 0.0,
    fastest: float | None = None,
    equality: bool = False,
    settings: DesignSettings = DESIGN_DEFAULTS,
) -> Gains:
    """Return the gains with the least beta that satisfy the theorem, checked after the solve.

        [P A - S C + (..)' + C'C + R   P N   P B]
        [             *               -b I   0  ] <= 0,   R = q gamma^2 E'E,  Q = q,  b = beta^2
        [             *                 *    -Q ]

    and L = P^-1 S. The last block has P B in place of the paper's P, for e_Phi = B e_phi. `noise`
    (output per unit of eta) adds a disturbance of the outputs: y = C x + noise nu, with the bound
    on (eta, nu). Without, the least beta wants infinite gains. `fastest` (1/s) keeps the poles of
    A - L C to the right of minus that. `equality` asks for the theorem's B'P = HC; else H is what
    comes closest.

    Raises ValueError with the reason when there is no solution or it does not stand the check, and
    ImportError without cvxpy.
    """
    cp = import_cvxpy()
    a, b, c, n, e = _scaled(plant)
    # A weight on (eta, nu): the bound is then per unit of each.
    weight = noise * plant.disturbance
    order, outputs = a.shape[0], c.shape[0]
    columns = b.shape[1]
    P = cp.Variable((order, order), symmetric=True)
    S = cp.Variable((order, outputs))
    H = cp.Variable((columns, outputs))
    squared, q = cp.Variable(nonneg=True), cp.Variable(nonneg=True)
    drift = P @ a - S @ c
    drift = drift + drift.T
    disturbed = cp.hstack([P @ n, -weight * S]) if weight else P @ n
    count = disturbed.shape[1]
    inequality = cp.bmat([
        [drift + c.T @ c + q * e.T @ e, disturbed, P @ b],
        [disturbed.T, -squared * np.eye(count), np.zeros((count, columns))],
        [b.T @ P, np.zeros((columns, count)), -q * np.eye(columns)],
    ])  # fmt: skip
    constraints = [P >> settings.least_p * np.eye(order), 0.5 * (inequality + inequality.T) << 0]
    if fastest is not None:
        constraints.append(drift + 2.0 * fastest * P >> 0)
    if equality:
        constraints.append(H @ c == b.T @ P)
    _solve(cp, cp.Problem(cp.Minimize(squared), constraints))
    bound = float(np.sqrt(squared.value))
    return checked(plant, P.value, S.value, bound, inequality.value, equality, settings)


def checked(
    plant: LipschitzPlant,
    P: Array,
    S: Array,
    bound: float,
    inequality: Array,
    equality: bool,
    settings: DesignSettings = DESIGN_DEFAULTS,
) -> Gains:
    """Return a solver's solution in the plant's units again, if it is one.

    Raises ValueError when P is not positive definite, the inequality does not hold, A - L C is not
    stable, the equality fails or the measured gain is above the bound.
    """
    least = float(np.linalg.eigvalsh(P).min())
    if not least > 0.5 * settings.least_p:
        raise ValueError(
            f'the solver returned an indefinite P: its least eigenvalue is {least:.2g}'
        )
    worst = float(np.linalg.eigvalsh(0.5 * (inequality + inequality.T)).max())
    if worst > settings.tolerance * np.abs(inequality).max():
        raise ValueError(f'the matrix inequality does not hold: largest eigenvalue {worst:.2g}')
    to_plant = np.diag(plant.scale)
    L = to_plant @ np.linalg.solve(P, S)
    poles = np.linalg.eigvals(plant.A - L @ plant.C)
    if not poles.real.max() < 0.0:
        raise ValueError(f'A - L C is not stable: a pole lies at {poles.real.max():.3g} 1/s')
    certificate = np.linalg.inv(to_plant) @ P @ np.linalg.inv(to_plant)
    H, mismatch = nearest_h(certificate, plant.B, plant.C)
    if equality and mismatch > settings.mismatch:
        raise ValueError(f"B'P = HC does not hold: it is off by {100 * mismatch:.2g} %")
    beta, peak = bound / plant.disturbance, peak_gain(plant, L)
    if peak > beta * (1.0 + settings.excess):
        raise ValueError(f'the gain reaches {peak:.4g}, above the bound beta = {beta:.4g}')
    return Gains(L, plant.B, H, certificate, beta, peak, mismatch, poles)


def nearest_h(P: Array, b: Array, c: Array) -> tuple[Array, float]:
    """Return H (l, r) with HC nearest to B'P, and how far off that is, relative to B'P."""
    wanted = b.T @ P
    H = wanted @ np.linalg.pinv(c)
    return H, float(np.linalg.norm(wanted - H @ c) / np.linalg.norm(wanted))


def import_cvxpy() -> Any:
    """Return cvxpy; raises ImportError with what to do when it is missing."""
    try:
        import cvxpy
    except ImportError as error:
        raise ImportError(
            'the design of H-infinity gains needs cvxpy: pip install cvxpy clarabel, or '
            '`make design`; the observer itself runs without, on the gains stored'
        ) from error
    return cvxpy


def _solve(cp: Any, problem: Any) -> None:
    try:
        problem.solve(solver=cp.CLARABEL)
        status = str(problem.status)
    except cp.SolverError as error:
        status = f'failed: {error}'
    if status != cp.OPTIMAL:
        raise ValueError(f'the matrix inequality has no solution: Clarabel says {status!r}')


def _scaled(plant: LipschitzPlant) -> tuple[Array, Array, Array, Array, Array]:
    """Return A, B gamma, C, N, E in units of `scale` and `disturbance`."""
    to_plant, from_plant = np.diag(plant.scale), np.diag(1.0 / plant.scale)
    return (
        from_plant @ plant.A @ to_plant,
        from_plant @ plant.B * plant.gamma,
        plant.C @ to_plant,
        from_plant @ plant.N * plant.disturbance,
        plant.E @ to_plant,
    )


def options() -> argparse.ArgumentParser:
    """Return the parser of the command."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        '--model',
        default=SUSPENSION,
        help='a built-in name or package.module:ATTRIBUTE (default: suspension)',
    )
    parser.add_argument(
        '--parameters', nargs='+', metavar='NAME', help='those to adapt (default: kt)'
    )
    parser.add_argument(
        '--disturbances',
        nargs='+',
        metavar='NAME',
        default=[],
        help='parameters that push the plant; without any, every state is pushed',
    )
    parser.add_argument(
        '--share',
        type=float,
        default=0.2,
        help='share of the parameters that is uncertain (default: %(default)s)',
    )
    parser.add_argument(
        '--fastest',
        type=float,
        default=200.0,
        help='bound of the poles, 1/s (default: %(default)s)',
    )
    parser.add_argument(
        '--noise',
        type=float,
        help='output noise beside a unit of the disturbance (default: 0.01 m per '
        "300 N of the suspension; 0.01 of the output's unit else)",
    )
    parser.add_argument(
        '--printed', action='store_true', help="the paper's own for the suspension, with B'P = HC"
    )
    parser.add_argument(
        '--wheel-speed', action='store_true', help='measure vus of the suspension as well'
    )
    parser.add_argument('--keep', type=Path, metavar='FILE', help='keep the gains there, as JSON')
    return parser  # fmt: skip


def designed(given: argparse.Namespace) -> tuple[Model, tuple[str, ...], Gains]:
    """Return the model, the parameters to adapt and the gains that a command line asks for.

    Raises ValueError and ImportError as `design` does, and for what does not go together.
    """
    model = load_model(given.model)
    if model.name == SUSPENSION and given.parameters in (None, ['kt']):
        plant = suspension(
            share=None if given.printed else given.share, wheel_speed=given.wheel_speed
        )
        parameters, noise = ('kt',), 0.01 / 300.0
        if given.disturbances:
            raise ValueError('leave --disturbances out: for kt of the suspension it is the damper')
    elif given.printed or given.wheel_speed:
        raise ValueError('leave --printed and --wheel-speed out: they are for kt of the suspension')
    elif not given.parameters:
        raise ValueError('give --parameters NAME ...: those that shall be adapted')
    else:
        parameters, noise = tuple(given.parameters), 0.01
        plant = linearised(model, parameters, share=given.share, disturbances=given.disturbances)
    own = noise if given.noise is None else given.noise
    gains = design(
        plant,
        noise=0.0 if given.printed else own,
        fastest=None if given.printed else given.fastest,
        equality=given.printed,
    )
    return model, parameters, gains


def main(arguments: list[str] | None = None) -> int:
    """Solve, print, and keep if asked."""
    given = options().parse_args(arguments)
    try:
        model, parameters, gains = designed(given)
        if given.keep and given.wheel_speed:
            raise ValueError('leave --keep out: the suspension has no output vus')
    except (ImportError, ValueError) as error:
        print(f'refused: {error}')
        return 1
    with np.printoptions(precision=8, suppress=True):
        print(f'L =\n{gains.L}\nH =\n{gains.H}\npoles of A - L C (1/s): {gains.poles}')
    print(f'beta = {gains.beta:.6g}, measured peak gain {gains.peak:.6g}')
    print(f"B'P and HC differ by {100.0 * gains.mismatch:.3g} %")
    if not given.wheel_speed:
        print('A - L C is stable at {} of {} random points'.format(*stable_share(model, gains.L)))
    if given.keep:
        kept = gains_of(model, parameters, gains.L, gains.B, gains.H,
                        beta=gains.beta, peak=gains.peak, origin=COMMAND)  # fmt: skip
        try:
            write_gains(given.keep, model, kept)
        except OSError as error:
            print(f'refused: give --keep a file that can be written: {error}')
            return 1
        print(f'kept: give the observer h_infinity.gains: {given.keep}')
    return 0


if __name__ == '__main__':
    raise SystemExit(main())
