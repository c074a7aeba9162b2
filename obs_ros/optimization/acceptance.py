"""The rules by which a search believes its best point to be the optimum."""

from enum import StrEnum

from obs_ros.core.residual_tests import is_white, like_noise
from obs_ros.core.typing import Array
from obs_ros.optimization.problem import Problem


class Acceptance(StrEnum):
    """The rule by which a point is believed to be the optimum, in words."""

    LIKE_NOISE = 'the residual is as small as the noise'
    PROCESS_NOISE = 'process noise explains the residual'
    AS_BEFORE = 'process noise explains the window as well as earlier ones'
    KNOWN_JUMP = 'a known jump explains the window'
    ROUNDS = 'two rounds agree'
    WHITE_ROUNDS = 'two rounds agree and the residual is white'
    WHITE_SURVIVORS = 'two survivors agree and the residual is white'
    GATHERED = 'the population has gathered in one point'
    POLISHED = 'half of the polished candidates agree'
    METHOD = 'the search method has converged'


def acceptance_with_noise(
    squares: float, freedom: int, *, converged: bool, rounds: int
) -> Acceptance | None:
    """Return the rule for a residual in units of the noise, of so many degrees of freedom.

    `converged`: its local search saw nothing left to gain; `rounds`: how many rounds ended there.
    """
    if converged and like_noise(squares, freedom):
        return Acceptance.LIKE_NOISE
    return Acceptance.ROUNDS if rounds >= 2 else None


def acceptance_without_noise(
    problem: Problem,
    z: Array,
    squares: float,
    *,
    rounds: int,
    flat: int,
    survivors: int,
    negligible: float,
) -> Acceptance | None:
    """Return the rule for a point z (d,) of these squares, in units that are but a guess.

    `rounds` is how many rounds ended there, `flat` how many nearly as low, `survivors` how many
    starts of the last round did;
    below `negligible`, of the signal's root mean square, the residual is rounding, which is not
    white and need not be.
    """
    if flat < 2 and survivors < 2:
        return None
    rounding = negligible**2 * problem.signal * problem.count(problem.nodes)
    if squares <= rounding or is_white(problem.residuals(z)):
        if survivors >= 2:
            return Acceptance.WHITE_SURVIVORS
        return Acceptance.WHITE_ROUNDS if rounds >= 2 else None
    # More rounds would find nothing better: what is left is no fault of the search.
    return Acceptance.ROUNDS if flat >= 2 else None
