"""The theorems of Zhang et al. 2020, judged on the plant of case 1.

The stored text of the print has lost fractions and minus signs; what stands here follows from the
proofs: with V = e'S1 e and Delta = diag(I, I/theta), eta2 comes with 1/theta.
"""

import math

import numpy as np

from benchmarks.papers.claims import Claim, verdict
from benchmarks.papers.zhang.plants import COLD, truth_of
from benchmarks.papers.zhang.run import C_PROCESS, C_UTILITY, K1, K2, PAPERS_START
from benchmarks.report import slashed
from obs_ros.core.typing import Array
from obs_ros.models import heat_exchanger as plant
from plant_sim.scenarios.heat_exchanger import NOMINAL

S1 = np.array([[1.0, -1.0], [-1.0, 2.0]])  # eq. 13 with theta 1
INLETS = np.array([plant.TPI, plant.TUI])  # degC


def theorems() -> list[Claim]:
    """Return the claims of Theorems 1 to 3, in their order."""
    return [bounded_gain(), process_observer(), actuator_observer(), interconnection()]


def bounded_gain() -> Claim:
    """Judge the assumption that lets g be inverted."""
    t, _, y, _ = truth_of(COLD)
    away = np.abs(INLETS - y)
    crossed = [bool((np.diff(np.sign(INLETS - y), axis=0)[:, i] != 0.0).any()) for i in range(2)]
    when = f', Tp passes its inlet at {t[away[:, 0].argmin()]:.2f} s' if crossed[0] else ''
    least = np.where(crossed, 0.0, away.min(axis=0))
    return Claim(
        'Assumption 2, Theorem 1',
        'g is bounded away from zero, so that the gain has its inverse',
        'least distance of Tp / Tu from the temperature of its inlet in case 1 (K), which is g '
        'times the volume; F is printed in place of g, and is no square matrix',
        slashed(least) + when,
        verdict(bool((least > 0.0).all())),
        f'kept away from 0 by {plant.HEAT_EXCHANGER.least_gain[0] * plant.VP:g} K',
    )


def process_observer() -> Claim:
    """Judge whether a theta can be above eta1 from the paper's start."""
    found = least_eta1()
    return Claim(
        'Theorem 1',
        'the process observer converges with a relatively high theta > eta1',
        'eta1 by theta for Fp / Fu at the start of case 1, at least: of the proof, eta1 >= 2 mu '
        "cond(S1), and mu, the largest g'/g, has 2 theta e / (Ti - T); holds if below 1",
        slashed(found, '.1f') + '; sufficient only: the flows do settle',
        verdict(bool((found < 1.0).all())),
        'starts at the measured temperatures, where e = 0 and mu does not grow with theta',
    )


def least_eta1() -> Array:
    """Return a lower bound (2,) of eta1 / theta, from the observer's start in case 1."""
    start = np.array([PAPERS_START['initial'][name] for name in ('Tp', 'Tu')])
    _, _, y, _ = truth_of(COLD)
    mu = 2.0 * np.abs(start - y[0]) / np.abs(INLETS - start)
    return np.asarray(2.0 * mu * np.linalg.cond(S1))


def actuator_observer() -> Claim:
    """Judge Assumption 6 by the poles of the valves' errors, where the flow is exact."""
    found = np.array(slowest_poles())
    return Claim(
        'Theorem 2',
        "the actuator's observer converges",
        'slowest poles of the errors of (X1, V1) / (X2, V2) with the printed k1 to k4 (1/s), flows '
        'and parameters known: below 0 they have the function of Assumption 6',
        slashed(found),
        verdict(bool((found < 0.0).all())),
        'the same poles with k = 0',
    )


def slowest_poles() -> list[float]:
    """Return the largest real parts (1/s) of the poles of the utility and the process valve."""
    found = []
    for c, k in zip((C_UTILITY, C_PROCESS), NOMINAL[2:], strict=True):
        A = [
            [-K1 * c, 1.0],
            [-k / plant.STEM_MASS - K2 * c, -plant.FRICTION / plant.STEM_MASS],
        ]
        found.append(float(np.linalg.eigvals(A).real.max()))
    return found


def interconnection() -> Claim:
    """Judge the condition of Theorem 3."""
    values = [condition(10.0**k) for k in (1, 3, 5)]
    return Claim(
        'Theorem 3',
        'a relatively high theta can be chosen that satisfies the condition',
        'the condition, >= 0, wants theta > eta1, as Theorem 1 does; eta1 by theta at the start of '
        'case 1, at least',
        f'{slashed(least_eta1(), ".1f")}; were all constants 1, whatever theta is, the condition '
        f'at theta 10, 1e3, 1e5 would be {slashed(values, ".3g")}',
        verdict(bool((least_eta1() < 1.0).all())),
        'starts at the measured temperatures',
    )


def condition(theta: float, eta: tuple[float, ...] = (1.0, 1.0, 1.0), alpha: float = 1.0) -> float:
    """Return the left side of the condition of Theorem 3, which has to be >= 0."""
    first, second, third = eta
    return 1.0 - (third + second / theta) / (2.0 * math.sqrt(alpha * (theta - first)))
