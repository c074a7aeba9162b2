"""Inputs from one output to the next, and over a few of them with what was measured."""

import functools
from collections.abc import Callable, Sequence
from operator import itemgetter
from typing import Any, NamedTuple

import numpy as np

from obs_ros.core.typing import AnyArray, Array, BoolArray, IntArray

# Candidates lie in chunks of so many lanes, of which only registers that hold some are stepped: one
# of AVX-512 holds 8 numbers. Lanes are counted when the loop runs. Over a constant number below 16
# LLVM does not vectorise where it has to find out first whether arrays overlap.
LANES, REGISTER = 16, 8


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


@functools.lru_cache(maxsize=64)
def always(nodes: int) -> tuple[IntArray, IntArray]:
    """Return the places of the one set of parameters between and at so many nodes."""
    return (np.zeros(nodes, dtype=np.int64),) * 2


def own(path: Path) -> Path:
    """Return a copy of a path that the next one does not overwrite, without unused rows."""
    pieces, t, dt, steps, u, slope = path  # once for every output: no loop over the arrays
    rows = slice(pieces + 1)
    return Path(
        pieces, t[rows].copy(), dt[rows].copy(), steps[rows].copy(), u[rows].copy(),
        slope[rows].copy(),
    )  # fmt: skip


def after(path: Path, gone: float, *, whole: bool = False) -> Path:
    """Return the rest of a path after `gone` s, which are less than it takes.

    With `whole` pieces, as of a discrete model, it begins with the one whose begin is nearest.
    """
    path = own(path)
    ends = np.cumsum(path.dt[: path.pieces])
    k = min(int(np.searchsorted(ends, gone, side='right')), path.pieces - 1)
    if whole:
        k = min(int(np.rint(gone / path.dt[: path.pieces].mean())), path.pieces - 1)
        return mapped(path.pieces - k, lambda array: array[k:].copy(), path)
    s = min(gone - (ends[k] - path.dt[k]), path.dt[k])
    path.t[k] += s
    path.dt[k] -= s
    path.u[k] += s * path.slope[k]
    return mapped(path.pieces - k, lambda array: array[k:].copy(), path)


def joined(paths: Sequence[Path]) -> Path:
    """Return one path from where the first begins to where the last ends, its end row included."""
    if len(paths) == 1:
        return paths[0]
    counts = [path.pieces for path in paths]
    counts[-1] += 1

    def chain(*arrays: AnyArray) -> AnyArray:
        return np.concatenate([a[:count] for a, count in zip(arrays, counts, strict=True)])

    return mapped(sum(counts) - 1, chain, *paths)


def single(path: Path) -> list[Path]:
    """Return the pieces of a path, each as a path."""
    return [mapped(1, itemgetter(slice(k, k + 2)), path) for k in range(path.pieces)]


def mapped(pieces: int, function: Callable[..., Any], *paths: Path) -> Path:
    """Return the path whose every array is the function of those of the given paths."""
    return Path(
        pieces, *(function(*arrays) for arrays in zip(*(p[1:] for p in paths), strict=True))
    )
