"""The information of a window about its parameters, without what noise feigns.

At rest a parameter has no influence. But the initial state is fitted to noise, and around a state
that is off by its standard deviation the parameter does have some: noise must not pass for
information. With J the Jacobian about the parameters, M that projects out the initial state and
D_k the change of J by one standard deviation of the state along its k-th direction, a direction v
counts as informed if

    v' (J' M J + G) v >= kappa sum_k v' D_k' M D_k v,

with G the information of priors that the user gives, which no noise feigns. The generalised
eigenvectors of both forms tell them apart.
"""

import functools
from dataclasses import dataclass

import numpy as np

from obs_ros.core.jit import accelerated
from obs_ros.core.linear_algebra import cholesky, eigen, inverted, scaled_inverse
from obs_ros.core.typing import Array
from obs_ros.inference.jumps.hypothesis import Hypothesis
from obs_ros.inference.prior import Prior


@dataclass(frozen=True)
class SubspaceSettings:
    """Limits in telling informed directions from the others.

    - `kappa`: times as much information as noise in the initial state would feign;
    - `smallest`: eigenvalue, of the large ones beside it, below which there is but rounding.
    """

    kappa: float = 10.0
    smallest: float = 1e-10


SUBSPACE = SubspaceSettings()


def informed_information(hypothesis: Hypothesis) -> Array:
    """Return the information (q, q) about the parameters, in boxes, by window and given priors.

    The initial state is unknown, and directions that the window does not inform are left out. The
    hypothesis has no jump in it.
    """
    problem, gram = hypothesis.problem, hypothesis.linearisation.gram
    n, prior = problem.objective.unknowns.n_states, problem.prior
    alone, spread = _states_apart(gram, prior, n)
    information = _with_given(alone, prior)
    if not n or n == len(gram):
        return information
    noise = _feigned_in(hypothesis, spread)
    if not np.isfinite(noise).all() or _all_informed(information, noise):
        return information
    values, vectors = eigen(noise)
    # Rounding leaves values that are too small, or negative.
    least = SUBSPACE.smallest * (values[-1] + np.trace(information) + 1.0)
    roots = vectors / np.sqrt(np.maximum(values, least))
    ratios, rotation = eigen(roots.T @ information @ roots)
    directions = roots @ rotation
    enough = ratios >= SUBSPACE.kappa
    if enough.all():
        return information
    informed = directions[:, enough] @ inverted(directions)[enough]
    return _with_given(informed.T @ alone @ informed, prior)


def marginal_information(hypothesis: Hypothesis, states: int) -> Array:
    """Return the information (q, q) about the parameters by window and given priors.

    The initial state is unknown, but for a prior that is given.
    """
    d, prior = hypothesis.layout.dimension, hypothesis.problem.prior
    gram = hypothesis.linearisation.gram[:d, :d]
    return _with_given(_states_apart(gram, prior, states)[0], prior)


def _with_given(information: Array, prior: Prior) -> Array:
    """Return the information (q, q) about the parameters with that of given priors."""
    if prior.given is None:
        return information
    return np.asarray(information + prior.information(len(information)))


def _states_apart(gram: Array, prior: Prior, n: int) -> tuple[Array, Array]:
    """Return the products (q, q) of a Jacobian without its part along the n initial states.

    `gram` (d, d) are those of the whole Jacobian. With them comes the covariance (n, n) of the
    states, had the parameters been known.
    """
    if not n:
        return gram, gram[:0, :0]
    spread = scaled_inverse(gram[:n, :n] + prior.precision[:n, :n])
    along = gram[:n, n:]
    return np.asarray(gram[n:, n:] - along.T @ spread @ along), spread


def _all_informed(information: Array, noise: Array) -> bool:
    """Whether all directions surely are, by information (q, q) and what noise (q, q) feigns.

    The form that must not be negative is positive even with twice what rounding may have lost.
    """
    q = len(noise)
    least = SUBSPACE.smallest * (np.trace(noise) + np.trace(information) + 1.0)
    rest = information - SUBSPACE.kappa * (noise + 2.0 * least * np.eye(q))
    return bool(np.isfinite(cholesky(rest)[0, 0]))


def _feigned_in(hypothesis: Hypothesis, spread: Array) -> Array:
    """Return the information (q, q) that noise in the initial state feigns, of covariance (n, n).

    It is the sum of D_k' M D_k.
    """
    problem, jacobian = hypothesis.problem, hypothesis.linearisation.jacobian
    grid, n, z = problem.objective.grid, len(spread), hypothesis.point
    step = np.where(z[n:] > 0.5, -1.0, 1.0) * problem.settings.probe_step
    points = _around(z, cholesky(spread), problem.limits, step)
    outputs = np.ascontiguousarray(grid.shown(problem.roll(points)[1]))
    return _feigned(outputs, grid.weight, jacobian, spread, step)


@functools.cache
def prepare() -> None:
    """Compile what is below, or load it compiled."""
    a, one, pair = np.ones(1), np.ones((1, 1)), np.ones((2, 2))
    _around(a.repeat(2), one, pair, a)
    _feigned(pair[None, :1], one, pair[:1], one, a)


@accelerated
def _around(z: Array, roots: Array, limits: Array, step: Array) -> Array:
    """Return points (n (1 + q), d) moved by the columns of roots (n, n), the states' deviations.

    After each such point come those with a parameter moved by its step (q,) besides.
    """
    n, q = len(roots), step.size
    points = np.empty((n * (1 + q), z.size))
    moved = np.empty((2, n))
    for k in range(n):
        room = np.zeros(2)
        for side in range(2):
            for i in range(n):
                there = z[i] + roots[i, k] * (1.0 - 2.0 * side)
                there = min(max(there, limits[0, i]), limits[1, i])
                moved[side, i] = there
                room[side] += (there - z[i]) ** 2
        # Towards the side with more room: beyond its bounds a state may mean nothing.
        side = 1 if room[1] > room[0] else 0
        for row in range(k * (1 + q), (k + 1) * (1 + q)):
            for i in range(z.size):  # assigning arrays compiles a message on their shapes
                points[row, i] = moved[side, i] if i < n else z[i]
        for j in range(q):
            points[k * (1 + q) + 1 + j, n + j] += step[j]
    return points


@accelerated
def _feigned(outputs: Array, weight: Array, jacobian: Array, spread: Array, step: Array) -> Array:
    """Return the sum (q, q) of D_k' M D_k by outputs (K, r, n (1 + q)) of the points around."""
    nodes, count, _ = outputs.shape
    n, q = len(spread), step.size
    found, change = np.zeros((q, q)), np.empty(q)
    for k in range(n):
        crossed, row = np.zeros((n, q)), 0
        for node in range(nodes):
            for i in range(count):
                if weight[node, i] > 0.0:
                    base = outputs[node, i, k * (1 + q)]
                    for j in range(q):
                        off = outputs[node, i, k * (1 + q) + 1 + j] - base
                        change[j] = weight[node, i] * off / step[j] - jacobian[row, n + j]
                    for j in range(q):
                        for h in range(q):
                            found[j, h] += change[j] * change[h]
                        for h in range(n):
                            crossed[h, j] += jacobian[row, h] * change[j]
                    row += 1
        for j in range(q):
            for h in range(q):
                for a in range(n):
                    for b in range(n):
                        found[j, h] -= crossed[a, j] * spread[a, b] * crossed[b, h]
    return found
