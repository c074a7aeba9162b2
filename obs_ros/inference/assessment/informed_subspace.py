"""The directions of the parameters that a window informs, and those that the prior has to hold.

At rest a parameter has no influence. But the initial state is fitted to noise, and around a state
that is off by its standard deviation the parameter does have some: noise must not pass for
information. With J the Jacobian about the parameters, M that projects out the initial state and
D_k the change of J by one standard deviation of the state along its k-th direction, a direction v
counts as informed if

    v' (J' M J + G) v >= kappa sum_k v' D_k' M D_k v,

with G the information of priors that the user gives, which no noise feigns; the prior holds the
others. The generalised eigenvectors of both forms tell them apart.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from obs_ros.core.linear_algebra import cholesky, eigen, inverted, scaled_inverse
from obs_ros.core.typing import Array
from obs_ros.inference.jumps.hypothesis import Hypothesis
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.prior import Prior, box_variances


@dataclass(frozen=True)
class SubspaceSettings:
    """Limits in telling informed directions from the others.

    - `kappa`: times as much information as noise in the initial state would feign;
    - `smallest`: eigenvalue, of the large ones beside it, below which there is but rounding;
    - `hold`: precision in boxes that holds a direction;
    - `known`: standard deviation of a direction by the prior, of that of the box, below which it
      is known from elsewhere.
    """

    kappa: float = 10.0
    smallest: float = 1e-10
    hold: float = 1e10
    known: float = 0.5


SUBSPACE = SubspaceSettings()


@dataclass(frozen=True)
class InformedSubspace:
    """Projection `informed` (q, q) onto the parameters' directions that a window informs.

    `information` (q, q) is that about the parameters by window and given priors, in boxes, with the
    initial state unknown and the uninformed directions left out; `held` (h, q) are the forms that
    the prior holds. Where no prior is given they vanish on the informed directions; where one is,
    they leave the window to move each parameter as far as its prior is wide.
    """

    information: Array
    informed: Array
    held: Array

    @classmethod
    def of(cls, hypothesis: Hypothesis) -> 'InformedSubspace':
        """Return the subspace of the window of a hypothesis without a jump in it."""
        problem, z = hypothesis.problem, hypothesis.point
        n = problem.objective.unknowns.n_states
        q = z.size - n
        jp = hypothesis.linearisation.jacobian[:, n:]
        spread, free = _states_apart(hypothesis.linearisation.jacobian[:, :n], problem.prior)
        alone, prior = jp.T @ free(jp), problem.prior
        information = _with_given(alone, prior)
        everything = cls(information, np.eye(q), np.zeros((0, q)))
        if not n or not q:
            return everything
        noise = np.zeros((q, q))
        for change in _changes(hypothesis, jp, cholesky(spread)):
            noise += change.T @ free(change)
        if not np.isfinite(noise).all():
            return everything
        values, vectors = eigen(noise)
        # Rounding leaves values that are too small, or negative.
        least = SUBSPACE.smallest * (values[-1] + np.trace(information) + 1.0)
        roots = vectors / np.sqrt(np.maximum(values, least))
        ratios, rotation = eigen(roots.T @ information @ roots)
        directions = roots @ rotation
        enough = ratios >= SUBSPACE.kappa
        if enough.all():
            return everything
        forms = inverted(directions)
        informed = directions[:, enough] @ forms[enough]
        held = forms[~enough]
        if prior.given is not None:
            held = directions[:, ~enough].T @ prior.precision[n:, n:]
        information = _with_given(informed.T @ alone @ informed, prior)
        return cls(information, informed, np.asarray(held))

    def known(self, problem: PiecewiseProblem) -> bool:
        """Whether the prior of a problem knows all uninformed directions, so that it may hold them."""
        n = problem.prior.mean.size - self.informed.shape[0]
        variances = scaled_inverse(problem.prior.precision)[n:, n:]
        deviations = (self.held @ variances * self.held).sum(axis=1)
        anywhere = self.held**2 @ box_variances(problem.objective.unknowns)
        return bool((deviations < SUBSPACE.known**2 * anywhere).all())

    def holding(self, prior: Prior) -> Prior:
        """Return the prior that holds the uninformed directions where its mean has them."""
        n = prior.mean.size - self.informed.shape[0]
        forms = self.held / np.linalg.norm(self.held, axis=1, keepdims=True)
        precision = prior.precision.copy()
        precision[n:, n:] += SUBSPACE.hold * forms.T @ forms
        return replace(prior, precision=precision)

    def covariance(self, hypothesis: Hypothesis) -> Array:
        """Return the joint covariance (d, d), of the held directions the prior's alone."""
        jacobian = hypothesis.linearisation.jacobian.copy()
        n = jacobian.shape[1] - self.informed.shape[0]
        jacobian[:, n:] = jacobian[:, n:] @ self.informed
        return scaled_inverse(jacobian.T @ jacobian + hypothesis.problem.prior.precision)


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
