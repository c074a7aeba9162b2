"""Windows that two source trees solve in turns: process times, and whether bits are the same."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from benchmarks.runner import ROOT, progress
from benchmarks.trees import Tree

Cell = TypeVar('Cell', bound=tuple[Any, ...])


class Cost(NamedTuple):
    """Process time (s) of one window or some, their values as text, bit by bit, and an outcome."""

    seconds: float
    values: tuple[str, ...]
    outcome: str = ''


class Pair(NamedTuple):
    """What this tree and another one took for the same."""

    own: Cost
    other: Cost

    @property
    def ratio(self) -> float:
        """Process time in that of the other."""
        return self.own.seconds / self.other.seconds

    @property
    def same(self) -> bool:
        """Whether all values are the same to the last bit."""
        return self.own.values == self.other.values


def in_turns(
    other: Path, solved: Callable[..., Cost], cells: Sequence[Cell], seeds: Sequence[int]
) -> Mapping[Cell, Sequence[Pair]]:
    """Call `solved`, a module's function, with each cell and seed in both trees."""
    runs = [(cell, seed) for cell in cells for seed in seeds]
    found: dict[Cell, list[Pair]] = {cell: [] for cell in cells}
    with Tree(ROOT) as own, Tree(other) as theirs:
        for cell in cells:  # compile
            own.call(solved, *cell, seeds[0])
            theirs.call(solved, *cell, seeds[0])
        for turn, (cell, seed) in enumerate(progress(runs, 'cost', len(runs))):
            ways = (own, theirs) if turn % 2 else (theirs, own)
            first, last = (way.call(solved, *cell, seed) for way in ways)
            found[cell].append(Pair(first, last) if turn % 2 else Pair(last, first))
    return found
