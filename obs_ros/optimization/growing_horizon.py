"""Least squares over a horizon that grows from a prefix of the window to all of it.

On a short prefix even a chaotic plant has few false minima, and what fits it well leads on.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from obs_ros.core.deadline import Deadline
from obs_ros.core.typing import Array, IntArray
from obs_ros.optimization.levenberg_marquardt import LMSettings, levenberg_marquardt
from obs_ros.optimization.problem import Problem


@dataclass(frozen=True)
class HorizonSettings:
    """Begin of a horizon, its growth at each step, and when it is given up."""

    shares: tuple[int, ...] = (16, 8, 32, 4)  # the window over the first prefix, by round
    smallest: int = 16  # nodes of a prefix
    values: int = 4  # measured values on the first prefix, for each unknown
    prefixes: int = 48  # numbers of nodes at which the horizon may end
    iterations: int = 12  # rollouts at most of each step
    bad_share: float = 0.01  # of the signal's mean square: above, a candidate has lost the data
    bad_noise: float = 4.0  # variances of the noise besides, for the same
    # A horizon that no candidate leads on is given up: windows of the zoo that fit need 5 steps.
    most_steps: int = 6
    crawling: int = 2  # steps in a row by one prefix each


HORIZON_DEFAULTS = HorizonSettings()


def first_prefix(objective: Problem, number: int, settings: HorizonSettings) -> int:
    """Return the nodes of the first horizon of a round: a share that still says something."""
    s, nodes = settings, objective.nodes
    prefix = max(nodes // s.shares[number % len(s.shares)], s.smallest)
    while prefix < nodes and objective.count(prefix) < s.values * objective.dimension:
        prefix *= 2
    return min(prefix, nodes)


def grown(
    objective: Problem,
    z: Array,
    nodes: int,
    deadline: Deadline,
    remember: Callable[[Array, Array], None],
    settings: HorizonSettings,
    local: LMSettings,
) -> Array:
    """Polish starts z (P, d) over a horizon that grows as far as the best stays near the data.

    It begins at `nodes`. `remember` gets all candidates (B, d) with their squares (B,) over the
    whole window. Returns the best last, half as many at each step. Where no candidate leads on, as
    in a window that the model cannot explain, the whole window is all that is left.
    """
    total = objective.nodes
    prefixes = np.unique(np.geomspace(nodes, total, settings.prefixes).round().astype(np.int64))
    counts = np.diff([0, *(objective.count(int(prefix)) for prefix in prefixes)])
    steps = crawled = 0
    while nodes < total and steps < settings.most_steps and crawled < settings.crawling:
        if deadline.passed:
            break
        starts = levenberg_marquardt(
            objective, z, nodes, settings.iterations, deadline, settings=local
        )
        z = starts.z[: max(2, len(z) // 2)]
        blocks = objective.block_squares(z, prefixes)
        remember(z, blocks.sum(axis=0))
        variance = starts.squares[0] / max(1, objective.count(nodes) - z.shape[1])
        limit = settings.bad_share * objective.signal + settings.bad_noise * variance
        reached = int(prefixes[_missed(blocks, counts, limit).max()])
        beyond = int(prefixes[prefixes > nodes][0])
        steps += 1
        crawled = crawled + 1 if reached <= beyond else 0
        nodes = max(beyond, reached)
        z = z[np.argsort(blocks[: np.searchsorted(prefixes, nodes) + 1].sum(axis=0))]
    return z


def _missed(blocks: Array, counts: IntArray, limit: float) -> IntArray:
    """Return for every candidate the first block (B,) that it misses; the last if none.

    blocks (G, B) are squares, counts (G,) the numbers of residuals in them; a block is missed
    where its mean square is above the limit.
    """
    bad = ~(blocks < limit * np.maximum(counts, 1)[:, None])
    bad[-1] = True
    return np.asarray(bad.argmax(axis=0))
