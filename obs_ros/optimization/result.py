"""What a search found."""

from dataclasses import dataclass

from obs_ros.core.typing import Array


@dataclass(frozen=True)
class Found:
    """Best point z (d,) of the unit box and its cost.

    `converged`: the last local search saw nothing left to gain; `accepted` names the rule by which
    the point is believed to be the optimum, empty if none holds; `white`: whether its residual
    looks like noise, None where nobody looked; `effort` says what was spent, such as '2 rounds'.
    """

    z: Array
    cost: float
    converged: bool
    accepted: str
    white: bool | None
    effort: str


def counted(number: int, thing: str) -> str:
    """Return '1 thing', '2 things'."""
    return f'{number} {thing}' if number == 1 else f'{number} {thing}s'
