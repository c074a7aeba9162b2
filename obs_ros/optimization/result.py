"""The point that a search found, and why it is believed to be the optimum."""

from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple

from obs_ros.core.typing import Array


class Acceptance(StrEnum):
    """The rule by which a point is believed to be the optimum, in words."""

    LIKE_NOISE = 'the residual is as small as the noise'
    KNOWN_JUMP = 'a known jump explains the window'
    ROUNDS = 'two rounds agree'
    WHITE_ROUNDS = 'two rounds agree and the residual is white'
    WHITE_SURVIVORS = 'two survivors agree and the residual is white'
    GATHERED = 'the population has gathered in one point'
    POLISHED = 'half of the polished candidates agree'
    METHOD = 'the search method has converged'


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
    point is believed to be the optimum, None if none holds.
    """

    z: Array
    cost: float
    converged: bool
    accepted: Acceptance | None
    effort: Effort
