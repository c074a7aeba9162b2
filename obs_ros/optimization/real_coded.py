"""Numbers as they are, crossed and mutated: what base-10 strings are compared with.

Blend crossover (Eshelman & Schaffer 1993) and Gaussian mutation, in the unit box.
"""

import numpy as np

from obs_ros.core.typing import Array, IntArray

BLEND = 0.5  # how far a child may lie beyond its parents, of their distance: BLX-0.5
DEVIATION = 0.1  # of a mutation, of the box


def offspring(
    z: Array, parents: IntArray, probability: float, rng: np.random.Generator, children: int
) -> Array:
    """Return children (children, d) of parents (P, 2) among z (N, d), inside the unit box.

    Every pair has two; each of their numbers is uniform between the parents' and half their
    distance beyond, then mutates with `probability`. One out of the box becomes a random value.
    """
    a, b = (np.tile(z[row], (2, 1))[:children] for row in parents.T)
    place = rng.uniform(-BLEND, 1.0 + BLEND, a.shape)
    blended = a + place * (b - a)
    changed = rng.random(a.shape) < probability
    blended += np.where(changed, DEVIATION * rng.standard_normal(a.shape), 0.0)
    outside = (blended < 0.0) | (blended > 1.0)
    return np.where(outside, rng.random(a.shape), blended)
