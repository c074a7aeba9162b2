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

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

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
    problem, z = hypothesis.problem, hypothesis.point
    n = problem.objective.unknowns.n_states
    q = z.size - n
    jp = hypothesis.linearisation.jacobian[:, n:]
    spread, free = _states_apart(hypothesis.linearisation.jacobian[:, :n], problem.prior)
    alone, prior = jp.T @ free(jp), problem.prior
    information = _with_given(alone, prior)
    if not n or not q:
        return information
    noise = np.zeros((q, q))
    for change in _changes(hypothesis, jp, cholesky(spread)):
        noise += change.T @ free(change)
    if not np.isfinite(noise).all():
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
    jacobian = hypothesis.linearisation.jacobian[:, : hypothesis.layout.dimension]
    jp, prior = jacobian[:, states:], hypothesis.problem.prior
    return _with_given(jp.T @ _states_apart(jacobian[:, :states], prior)[1](jp), prior)


def _with_given(information: Array, prior: Prior) -> Array:
    """Return the information (q, q) about the parameters with that of given priors."""
    if prior.given is None:
        return information
    return np.asarray(information + prior.information(len(information)))


def _states_apart(jx: Array, prior: Prior) -> tuple[Array, Callable[[Array], Array]]:
    """Return the covariance (n, n) of initial states, and the projection that takes them out.

    That is a function of columns (M, any), whose part along the Jacobian jx (M, n) it takes off.
    """
    n = jx.shape[1]
    spread = scaled_inverse(jx.T @ jx + prior.precision[:n, :n]) if n else np.zeros((0, 0))
    return spread, lambda columns: columns - jx @ (spread @ (jx.T @ columns))


def _changes(hypothesis: Hypothesis, jp: Array, roots: Array) -> list[Array]:
    """Return changes (M, q) of the Jacobian jp for each standard deviation of the initial state."""
    z, problem = hypothesis.point, hypothesis.problem
    n, q = len(roots), jp.shape[1]
    limits = problem.limits[:, :n]
    moved = []
    for root in roots.T:
        # Towards the side with more room: beyond its bounds a state may mean nothing.
        ahead, behind = (np.clip(z[:n] + s * root, *limits) - z[:n] for s in (1.0, -1.0))
        moved.append(z[:n] + max(ahead, behind, key=lambda step: float(step @ step)))
    points = np.repeat(z[None], n * (1 + q), axis=0).reshape(n, 1 + q, z.size)
    points[:, :, :n] = np.array(moved)[:, None]
    columns = np.arange(q)
    step = np.where(z[n:] > 0.5, -1.0, 1.0) * problem.settings.probe_step
    points[:, 1 + columns, n + columns] += step
    rows = problem.rows(points.reshape(-1, z.size)).reshape(len(jp), n, 1 + q)
    with np.errstate(invalid='ignore'):  # the model may diverge
        slopes = (rows[:, :, 1:] - rows[:, :, :1]) / step
    return [slopes[:, k] - jp for k in range(n)]
