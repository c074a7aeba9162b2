"""The cost of windows beside that of another tree, interleaved, and whether values are the same."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.coverage.run import KINDS, WAYS
from benchmarks.coverage.tree import OWN, Solved, tree
from benchmarks.runner import progress

DRAWS = 2000  # of the bootstrap


class Pair(NamedTuple):
    """A window, or warm ones, solved by this tree and by the other one."""

    own: Solved
    other: Solved

    @property
    def ratio(self) -> float:
        """Process time in that of the other."""
        return self.own.seconds / self.other.seconds

    @property
    def same(self) -> bool:
        """Whether all values are the same to the last bit."""
        return self.own.values == self.other.values


Cell = tuple[str, bool, bool]  # experiment, rich, in sequence


def compared(
    other: Path, plants: Sequence[str], windows: int, seed: int
) -> Mapping[Cell, Sequence[Pair]]:
    """Solve so many windows of each cell with both trees, in turns."""
    cells = [(name, rich, way) for name in plants for rich in KINDS for way in WAYS]
    runs = [(cell, seed + i) for cell in cells for i in range(windows)]
    found: dict[Cell, list[Pair]] = {cell: [] for cell in cells}
    with tree(OWN) as own, tree(other) as theirs:
        for cell in cells:  # compile
            own.solved(*cell, seed)
            theirs.solved(*cell, seed)
        for turn, (cell, one) in enumerate(progress(runs, 'cost', len(runs))):
            ways = (own, theirs) if turn % 2 else (theirs, own)
            first, last = (way.solved(*cell, one) for way in ways)
            found[cell].append(Pair(first, last) if turn % 2 else Pair(last, first))
    return found


def ratio(pairs: Sequence[Pair], seed: int = 0) -> tuple[float, float, float]:
    """Return the median of ratios with its 95 % interval (percentile bootstrap)."""
    ratios = np.array([pair.ratio for pair in pairs])
    drawn = np.random.default_rng(seed).integers(ratios.size, size=(DRAWS, ratios.size))
    low, high = np.quantile(np.median(ratios[drawn], axis=1), (0.025, 0.975))
    return float(np.median(ratios)), float(low), float(high)
