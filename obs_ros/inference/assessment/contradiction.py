"""Priors that the user gives, held against what the window says without them.

A prior N(m, s^2) of one unknown makes N(m', v) of what the rest says, N(w, r): 1/v = 1/r + 1/s^2
and m'/v = w/r + m/s^2. Taken off again, it lies

    (w - m) / sqrt(r + s^2)

standard deviations from the rest (Bar-Shalom, Li & Kirubarajan 2001, section 5.4: the normalised
innovation). To first order this holds for any window; correlation of the residual raises r.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from obs_ros.core.typing import Array
from obs_ros.inference.jumps.hypothesis import Hypothesis
from obs_ros.inference.parameterisation import Unknowns


@dataclass(frozen=True)
class ContradictionSettings:
    """Limits beyond which a prior is contradicted.

    - `deviations`: standard deviations between a prior and the window without it; by chance 3 in a
      thousand right priors lie beyond;
    - `rounding`: share of the prior's information below which that of the window is rounding.
    """

    deviations: float = 3.0
    rounding: float = 1e-9


SETTINGS = ContradictionSettings()


class Contradiction(NamedTuple):
    """A prior that the rest contradicts: the unknown's place, its own value, and the distance.

    That is in standard deviations.
    """

    place: int
    value: float
    apart: float

    def words(self, unknowns: Unknowns) -> str:
        """Say which value contradicts which prior."""
        variable = unknowns.model.variables[unknowns.index[self.place]]
        assert variable.prior is not None
        unit = '' if variable.unit == '1' else f' {variable.unit}'
        mean, sd = variable.prior
        return (
            f'{variable.name} = {self.value:.3g}{unit} contradicts its prior {mean:.3g}{unit} '
            f'(sd {sd:.2g}) by {self.apart:.2g} standard deviations'
        )


def contradictions(
    best: Hypothesis,
    inflation: float = 1.0,
    settings: ContradictionSettings = SETTINGS,
) -> list[Contradiction]:
    """Return the given priors that the window of a hypothesis contradicts.

    `inflation` is how much the correlation of the residual raises variances.
    """
    prior, unknowns = best.problem.prior, best.problem.objective.unknowns
    if prior.given is None:
        return []
    d = unknowns.dimension
    optimum, covariance = _optimum(best)
    variances = 1.0 / np.diagonal(prior.precision)
    share = np.diagonal(covariance)[:d] / variances  # 1: the rest says nothing
    told = np.maximum(1.0 - share, settings.rounding)
    off = (optimum[:d] - prior.mean) / told
    apart = np.abs(off) / np.sqrt(variances * (1.0 + inflation * share / told))
    beyond = (prior.given > 0.0) & (1.0 - share > settings.rounding) & (apart > settings.deviations)
    alone = unknowns.scale.values(np.clip(prior.mean + off, *unknowns.limits))
    return [Contradiction(int(i), float(alone[i]), float(apart[i])) for i in np.flatnonzero(beyond)]


def _optimum(best: Hypothesis) -> tuple[Array, Array]:
    """Return the point (D,) one Gauss-Newton step on, and its covariance (D, D).

    A search ends where there is hardly anything to gain; beside a prior far narrower than the
    window, the rest of the way is as long as the window's say.
    """
    problem, point = best.problem, best.point
    jacobian, covariance = best.linearisation.jacobian, best.covariance
    pull = problem.precision(point) @ (point - problem.mean(point))
    gradient = jacobian.T @ best.linearisation.residual + pull
    return point - covariance @ gradient, covariance
