"""Time of windows that take RK4, beside that of another source tree, and whether bits are the same.

Three tanks and the plants of `zoo`; both trees solve every window, in turns.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from benchmarks.runner import ROOT, progress, timed
from benchmarks.trees import Tree
from benchmarks.zoo import CASES, draw
from obs_ros import Estimate, solve_window

REPEATS = 3  # of a solve, of which the least time counts


class Spent(NamedTuple):
    """Process time of a window in s, its outcome, and its values as text, bit by bit."""

    seconds: float
    outcome: str
    values: tuple[str, ...]


class Pair(NamedTuple):
    """A window of a case, solved by this tree and by the other one."""

    case: str
    own: Spent
    other: Spent

    @property
    def ratio(self) -> float:
        """Process time in that of the other."""
        return self.own.seconds / self.other.seconds

    @property
    def same(self) -> bool:
        """Whether all values are the same to the last bit."""
        return self.own.values == self.other.values


def compared(other: Path, cases: Sequence[str], windows: int, seed: int) -> list[Pair]:
    """Solve so many windows of each case with both trees."""
    runs = [(case, seed + i) for case in cases for i in range(windows)]
    pairs = []
    with Tree(ROOT) as own, Tree(other) as theirs:
        for case in cases:  # compile
            own.call(spent, case, seed)
            theirs.call(spent, case, seed)
        for turn, run in enumerate(progress(runs, 'cost', len(runs))):
            ways = (own, theirs) if turn % 2 else (theirs, own)
            first, last = (way.call(spent, *run) for way in ways)
            pairs.append(Pair(run[0], *((first, last) if turn % 2 else (last, first))))
    return pairs


def spent(case: str, seed: int) -> Spent:
    """Solve a window again and again."""
    drawn = draw(CASES[case], seed)

    def solve() -> Estimate:
        return solve_window(CASES[case].model, drawn.record, seed=seed, noise=drawn.noise)

    runs = [timed(solve) for _ in range(REPEATS)]
    estimate, seconds = min(runs, key=lambda run: run[1])
    values = (*estimate.initial_state.values(), *estimate.parameters.values())
    return Spent(seconds, str(estimate.outcome.value), tuple(value.hex() for value in values))
