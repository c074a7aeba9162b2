"""The claims of Yang, Li & Dahhou 2020 on time, plant and eq. 13, judged."""

import numpy as np

from benchmarks.papers.claims import Claim, verdict
from benchmarks.papers.yang.run import QUICK, Figures
from benchmarks.tanks import PAPER_SAMPLES, paper_levels
from obs_ros.core.typing import Array
from obs_ros.models.three_tank import THREE_TANK

HEADS = (1e-2, 1e-4, 1e-6)  # cm, between two levels
INSIDE = (50.0, 30.0, 50.0)  # cm: h1 = h3, as where levels cross


def real_time(figures: Figures) -> Claim:
    """Judge real time by the effort of a search beside the length of its window."""
    return Claim(
        'Abstract, 4.4.2',
        'a sliding window realises real-time estimation',
        f'process time of a search on a window of {PAPER_SAMPLES} s, once it is compiled; holds if '
        f'below {100.0 * QUICK:g} % of that',
        ('below it' if figures.quick else 'above it')
        + f'; what changes is told at the end of its window, up to {PAPER_SAMPLES} s later',
        verdict(figures.quick),
        'windows may overlap, and a change inside one is found with its time',
    )


def lipschitz() -> Claim:
    """Judge Assumption 1 by the slope of eq. 16 where two levels are nearly the same."""
    found = [slope(head) for head in HEADS]
    return Claim(
        'Assumption 1',
        'f is globally Lipschitz in x',
        'change of eq. 16 with h1, from h1 = h3 on, by that of h1: heads of '
        + ', '.join(f'{head:g}' for head in HEADS)
        + ' cm; holds if it does not grow',
        ', '.join(f'{each:.3g}' for each in found)
        + ' 1/s: as 1 over the root of the head, without bound; levels cross in T1',
        verdict(found[-1] <= 1.01 * found[0]),
        'no such assumption; integration is refined where levels cross',
    )


def slope(head: float) -> float:
    """Return the largest change of a rate of eq. 16 by that of h1 (1/s), `head` cm beyond h3."""
    p = tuple(variable.nominal for variable in THREE_TANK.parameters)
    u = tuple(variable.nominal for variable in THREE_TANK.inputs)

    def rates(h1: float) -> Array:
        return np.array(THREE_TANK.dynamics(0.0, (h1, *INSIDE[1:]), u, p))

    return float(np.abs(rates(INSIDE[0] + head) - rates(INSIDE[0])).max() / head)


def euclidean() -> Claim:
    """Judge eq. 13 as eq. 14 is judged: by an output that is another one scaled and shifted."""
    y = paper_levels('T2')[:, 0]
    same, other = (0.5 * float(np.sum((y - own) ** 2)) for own in (y, 0.5 * y + 10.0))
    return Claim(
        '4.2.1, eq. 13',
        'half the squared distance is 0 only where both outputs are the same',
        'h1 of T2 beside itself, and beside 0.5 h1 + 10 cm',
        f'{same:g} and {other:.3g} cm2; section 5.1 takes the sum of the distances of both outputs '
        'in its place, which orders candidates otherwise and has the same zero',
        verdict(same == 0.0 < other),
        'least squares',
    )
