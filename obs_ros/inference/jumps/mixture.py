"""Mixture of the hypotheses that explain a window nearly as well as the best one.

A near-tie that the winner took would age into certainty. With E_k = -2 log evidence, the posterior
probabilities and the second moment of a value v about the published one, v_0, are

    w_k ~ exp(-E_k / 2),    S = sum_k w_k (C_k + (v_k - v_0)(v_k - v_0)'),

v_k and C_k mean and covariance by hypothesis k (Hoeting et al. 1999, Statistical Science 14,
382-417). Hypotheses of one set of parameters are represented by the best of them.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from obs_ros.core.residual_tests import inflation_by
from obs_ros.core.typing import Array
from obs_ros.inference.jumps.hypothesis import Hypothesis, discounted


@dataclass(frozen=True)
class Mixture:
    """Hypotheses about one window, the best one first, with their probabilities `weights` (H,).

    `inflation`: the factor by which the correlation of what the best fit leaves raises variances;
    `still`: probability that nothing jumped, however small.
    """

    hypotheses: tuple[Hypothesis, ...]
    weights: Array
    inflation: float = 1.0
    still: float = 1.0

    @classmethod
    def only(cls, best: Hypothesis) -> 'Mixture':
        """Return the mixture of one hypothesis."""
        return cls((best,), np.ones(1), still=0.0 if best.jumps else 1.0)

    @classmethod
    def of(cls, best: Hypothesis, tried: Sequence[Hypothesis], correlation: float) -> 'Mixture':
        """Return the mixture of `best` and the best of each other set of parameters tried.

        Squares count for less where the least residual is more correlated than noise of this lag-1
        `correlation`, as in the search. At the kinks of a model determinants mean little: they
        gain nothing for one with more jumps.
        """
        settings = best.problem.settings
        others = {
            h.parameters: h
            for h in sorted(tried, key=lambda h: -h.neg2_log_evidence)
            if np.isfinite(h.neg2_log_evidence) and h.parameters != best.parameters
        }
        if not others or not np.isfinite(best.neg2_log_evidence):
            return cls.only(best)
        every = (best, *others.values())
        least = min(every, key=lambda h: h.squares)
        inflation = inflation_by(least.trajectory[1], correlation)
        evidence = np.array([discounted(h, inflation) for h in every])
        cost = np.array([h.cost - h.squares * (1.0 - 1.0 / inflation) for h in every])
        more = np.array([h.jumps > best.jumps for h in every])
        evidence[more] = np.maximum(evidence, evidence[0] + cost - cost[0])[more]
        weights = probabilities(evidence)
        counts = np.flatnonzero(weights >= settings.least_weight)
        order = [0, *sorted(counts[counts > 0].tolist(), key=lambda k: -float(weights[k]))]
        kept = weights[order]
        still = sum(float(w) for h, w in zip(every, weights, strict=True) if not h.jumps)
        return cls(tuple(every[k] for k in order), kept / kept.sum(), inflation, still)

    @property
    def best(self) -> Hypothesis:
        """The hypothesis that is published."""
        return self.hypotheses[0]

    @property
    def alternatives(self) -> list[Hypothesis]:
        """Those with other sets of parameters that explain the window nearly as well."""
        least = self.weights[0] * self.best.problem.settings.least_weight
        return [
            h for h, w in zip(self.hypotheses[1:], self.weights[1:], strict=True) if w > least
        ]  # fmt: skip

    def about(self, best: Hypothesis) -> 'Mixture':
        """Return the same with the best one solved anew, under other scales or another prior."""
        return replace(self, hypotheses=(best, *self.hypotheses[1:]))


def probabilities(neg2_log_evidences: Array) -> Array:
    """Return the posterior probabilities (H,) of hypotheses with these -2 log evidences (H,)."""
    least = neg2_log_evidences.min()
    weights = np.exp(-0.5 * (neg2_log_evidences - least))
    return np.asarray(weights / weights.sum())


def at_end(hypothesis: Hypothesis) -> tuple[Array, Array]:
    """Return state and parameters (n + q,) at the end of a window, and their Jacobian (n + q, D).

    States are in their units, estimated parameters in boxes.
    """
    linear, final = hypothesis.linearisation, hypothesis.final_parameters
    rows = np.zeros((linear.state.size + final.size, hypothesis.point.size))
    rows[: linear.state.size] = linear.state_jacobian
    rows[linear.state.size + np.arange(final.size), final] = 1.0
    return np.append(linear.state, hypothesis.point[final]), rows


def excess(mixture: Mixture, covariance: Array) -> Array | None:
    """Return the second moment (n + q, n + q) of the end about the best one's, in excess of its.

    `covariance` (D, D) is the best point's; None for a mixture of one.
    """
    if len(mixture.hypotheses) == 1:
        return None
    centre, rows = at_end(mixture.best)
    own = rows @ covariance @ rows.T
    total = np.zeros_like(own)
    for weight, other in zip(mixture.weights[1:], mixture.hypotheses[1:], strict=True):
        value, rows = at_end(other)
        apart = value - centre
        total += weight * (rows @ other.covariance @ rows.T + np.outer(apart, apart) - own)
    return total
