"""Inputs from one output to the next, and over a few of them with what was measured."""

from typing import NamedTuple

from obs_ros.core.typing import Array, BoolArray, IntArray

# Candidates are stepped in chunks of so many: of fewer LLVM unrolls the loop over the lanes instead
# of vectorising it.
LANES = 16


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


class Stretch(NamedTuple):
    """A window of K nodes and K - 1 intervals.

    Interval k begins at t[k] s (K - 1,), takes dt[k] s (K - 1,) under inputs u[k] (K - 1, m); y
    (K, r) are the outputs measured at the nodes, where known (K, r); weight (r,) is one over the
    outputs' scales.
    """

    t: Array
    dt: Array
    u: Array
    y: Array
    known: BoolArray
    weight: Array


def lanes(count: int) -> int:
    """Return the width of the arrays that `count` candidates need: whole chunks."""
    return count + -count % LANES
