"""The cost of windows beside that of another tree, interleaved, and whether values are the same."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from benchmarks.coverage.run import KINDS, WAYS, alone, timed_sequence, values_of
from benchmarks.intervals import median_interval
from benchmarks.pairs import Cost, Pair, in_turns
from benchmarks.runner import timed
from benchmarks.zoo.experiments import EXPERIMENTS, run

REPEATS = 3  # of a solve, of which the least time counts
IN_RUN = 3  # windows in sequence; all but the first are warm, and count


Cell = tuple[str, bool, bool]  # experiment, rich, in sequence


def compared(
    other: Path, plants: Sequence[str], windows: int, seed: int
) -> Mapping[Cell, Sequence[Pair]]:
    """Solve so many windows of each cell with both trees, in turns."""
    cells = [(name, rich, way) for name in plants for rich in KINDS for way in WAYS]
    return in_turns(other, solved, cells, range(seed, seed + windows))


def solved(name: str, rich: bool, sequence: bool, seed: int) -> Cost:
    """Solve a window alone, or some in sequence, again and again."""
    repeats = [_solved(name, rich, IN_RUN if sequence else 1, seed) for _ in range(REPEATS)]
    return min(repeats, key=lambda one: one.seconds)


def _solved(name: str, rich: bool, windows: int, seed: int) -> Cost:
    experiment = EXPERIMENTS[name]
    drawn = run(experiment, seed, rich, windows)
    if windows > 1:
        found = timed_sequence(experiment, drawn, seed)[1:]
    else:
        found = [timed(lambda: alone(experiment, drawn, seed)[0])]
    values = (value.hex() for estimate, _ in found for value in values_of(estimate).values())
    return Cost(sum(seconds for _, seconds in found), tuple(values))


def ratio(pairs: Sequence[Pair]) -> tuple[float, float, float]:
    """Return the median of ratios with its 95 % interval (percentile bootstrap)."""
    return median_interval([pair.ratio for pair in pairs])
