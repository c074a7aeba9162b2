"""Time of windows that take RK4, beside that of another source tree, and whether bits are the same.

Three tanks and the plants of `zoo`; both trees solve every window, in turns.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path

from benchmarks.pairs import Cost, Pair, in_turns
from benchmarks.runner import timed
from benchmarks.zoo import CASES, draw
from obs_ros import Estimate, solve_window

Costs = Mapping[tuple[str], Sequence[Pair]]  # by case

REPEATS = 3  # of a solve, of which the least time counts


def compared(other: Path, cases: Sequence[str], windows: int, seed: int) -> Costs:
    """Solve so many windows of each case with both trees."""
    return in_turns(other, spent, [(case,) for case in cases], range(seed, seed + windows))


def spent(case: str, seed: int) -> Cost:
    """Solve a window again and again."""
    drawn = draw(CASES[case], seed)

    def solve() -> Estimate:
        return solve_window(CASES[case].model, drawn.record, seed=seed, noise=drawn.noise)

    runs = [timed(solve) for _ in range(REPEATS)]
    estimate, seconds = min(runs, key=lambda run: run[1])
    values = (*estimate.initial_state.values(), *estimate.parameters.values())
    return Cost(seconds, tuple(value.hex() for value in values), str(estimate.outcome.value))
