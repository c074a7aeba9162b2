"""How far an estimate can be trusted: standard deviations from the Fisher information.

The covariance is the inverse of J'J / sigma^2, J the Jacobian of the outputs, plus what was known
before. At a bound it stays that of the free unknowns: freezing them makes intervals far too short;
an interval is to be clipped to the box instead.
"""

from dataclasses import dataclass

import numpy as np

from obs_ros.core.model import Model
from obs_ros.core.typing import Array
from obs_ros.inference.assessment.identifiability import UNDETERMINED, undetermined
from obs_ros.inference.jumps.hypothesis import Hypothesis


@dataclass(frozen=True)
class Deviations:
    """Standard deviations in the variables' units; NaN where one would mean nothing.

    Of the initial state (n,), the state at the end (n,) and the parameters there (q,).
    """

    initial: Array
    state: Array
    parameters: Array

    @classmethod
    def withheld(cls, model: Model) -> 'Deviations':
        """Return none."""
        n, q = len(model.states), len(model.parameters)
        return cls(np.full(n, np.nan), np.full(n, np.nan), np.full(q, np.nan))

    @classmethod
    def of(cls, hypothesis: Hypothesis, covariance: Array, inflation: float) -> 'Deviations':
        """Return those of a hypothesis with this joint covariance (D, D) times `inflation`.

        What is not estimated has none, 0. Above a tenth of its box, or on a log scale 30 % of its
        value, a standard deviation says that the value is not determined, and is withheld.
        """
        unknowns = hypothesis.problem.objective.unknowns
        n = len(unknowns.model.states)
        covariance = covariance * inflation
        final = hypothesis.layout.final(hypothesis.point)
        places = {'initial': np.arange(unknowns.dimension), 'final': final}
        found = {}
        limit = undetermined(unknowns)
        for name, where in places.items():
            everything = np.zeros(len(unknowns.model.variables))
            boxes = np.sqrt(np.maximum(np.diagonal(covariance)[where], 0.0))
            slopes = unknowns.slopes(hypothesis.point[where])
            everything[unknowns.index] = np.where(boxes <= limit, boxes * slopes, np.nan)
            found[name] = everything
        g = hypothesis.linearisation.state_jacobian
        state = np.sqrt(np.maximum(((g @ covariance) * g).sum(axis=1), 0.0))
        boxes = np.full(n, np.inf)
        estimated = unknowns.index < n
        boxes[unknowns.index[estimated]] = (unknowns.upper - unknowns.lower)[estimated]
        return cls(
            initial=found['initial'][:n],
            state=np.where(state <= UNDETERMINED * boxes, state, np.nan),
            parameters=found['final'][n:],
        )
