"""What a plant is fed from one output to the next."""

from typing import NamedTuple

from obs_ros.typing import Array, IntArray

LANES = 16  # candidates are stepped in chunks of so many


class Path(NamedTuple):
    """From one output to the next, in pieces on which every input is a straight line.

    Piece k begins at t[k] s and takes dt[k] s in steps[k] integration steps; s seconds into it the
    inputs are u[k] + s slope[k], with u and slope (K, m). Row `pieces` of t and u is the end. There
    may be more rows; the next path overwrites them.
    """

    pieces: int
    t: Array
    dt: Array
    steps: IntArray
    u: Array
    slope: Array


def lanes(count: int) -> int:
    """Return the width of the arrays that `count` candidates need: whole chunks."""
    return count + -count % LANES
