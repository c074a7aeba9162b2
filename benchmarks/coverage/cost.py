"""The cost of windows beside that of another tree, interleaved, and whether values are the same."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from benchmarks.coverage.run import KINDS, WAYS, alone, timed_sequence, values_of
from benchmarks.intervals import median_interval
from benchmarks.runner import ROOT, progress, timed
from benchmarks.trees import Tree
from benchmarks.zoo.experiments import EXPERIMENTS, run

REPEATS = 3  # of a solve, of which the least time counts
IN_RUN = 3  # windows in sequence; all but the first are warm, and count


class Solved(NamedTuple):
    """The process time (s) of a window, or of warm ones, and the values as text, bit by bit."""

    seconds: float
    values: tuple[str, ...]


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
    with Tree(ROOT) as own, Tree(other) as theirs:
        for cell in cells:  # compile
            own.call(solved, *cell, seed)
            theirs.call(solved, *cell, seed)
        for turn, (cell, one) in enumerate(progress(runs, 'cost', len(runs))):
            ways = (own, theirs) if turn % 2 else (theirs, own)
            first, last = (way.call(solved, *cell, one) for way in ways)
            found[cell].append(Pair(first, last) if turn % 2 else Pair(last, first))
    return found


def solved(name: str, rich: bool, sequence: bool, seed: int) -> Solved:
    """Solve a window alone, or some in sequence, again and again."""
    repeats = [_solved(name, rich, IN_RUN if sequence else 1, seed) for _ in range(REPEATS)]
    return min(repeats, key=lambda one: one.seconds)


def _solved(name: str, rich: bool, windows: int, seed: int) -> Solved:
    experiment = EXPERIMENTS[name]
    drawn = run(experiment, seed, rich, windows)
    if windows > 1:
        found = timed_sequence(experiment, drawn, seed)[1:]
    else:
        found = [timed(lambda: alone(experiment, drawn, seed)[0])]
    values = (value.hex() for estimate, _ in found for value in values_of(estimate).values())
    return Solved(sum(seconds for _, seconds in found), tuple(values))


def ratio(pairs: Sequence[Pair]) -> tuple[float, float, float]:
    """Return the median of ratios with its 95 % interval (percentile bootstrap)."""
    return median_interval([pair.ratio for pair in pairs])
