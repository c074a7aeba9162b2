"""The point that a search found, and why it is believed to be the optimum."""

from dataclasses import dataclass
from typing import NamedTuple

from obs_ros.core.typing import Array
from obs_ros.optimization.acceptance import Acceptance


class Effort(NamedTuple):
    """Effort of a search, such as 2 rounds."""

    number: int
    unit: str

    def __str__(self) -> str:
        """Return '1 round', '2 rounds'."""
        return f'{self.number} {self.unit if self.number == 1 else self.units}'

    @property
    def units(self) -> str:
        """Return the unit's plural."""
        return f'{self.unit}s'


@dataclass(frozen=True)
class Found:
    """Best point z (d,) of the unit box and its cost.

    `converged`: the last local search saw nothing left to gain; `accepted`: the rule by which the
    point is believed to be the optimum, None if none holds. `curvature` (d,) is the diagonal of the
    squares' Hessian J'J about there, None if that is not known.
    """

    z: Array
    cost: float
    converged: bool
    accepted: Acceptance | None
    effort: Effort
    curvature: Array | None = None
