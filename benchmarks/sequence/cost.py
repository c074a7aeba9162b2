"""Table 7: the time that jump search and intervals add to a warm window."""

import contextlib
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from unittest import mock

import numpy as np

from benchmarks.report import table as markdown
from benchmarks.runner import cpu_seconds, progress
from benchmarks.sequence.plants import Run
from benchmarks.sequence.scenes import Scene, run_of
from obs_ros import Estimate, Record
from obs_ros.core.deadline import Deadline
from obs_ros.core.rng import random_generator
from obs_ros.core.typing import Array
from obs_ros.horizon.moving_horizon import MovingHorizon
from obs_ros.horizon.solver import Solver
from obs_ros.inference.assessment.informed_subspace import marginal_information
from obs_ros.inference.assessment.uncertainty import Uncertainty
from obs_ros.inference.jumps.hypothesis import Hypothesis
from obs_ros.inference.jumps.jump_search import JumpSearch

Solve = Callable[[int, Record], Estimate]

FULL, NO_JUMPS, NO_INTERVALS, BARE, PLAIN = (
    'with jump search and intervals',
    'without jump search',
    'without intervals',
    'without both',
    '`solve_window` with `previous`',
)


def costs(scenes: Mapping[str, Sequence[Scene]]) -> Mapping[str, Mapping[str, Array]]:
    """Return process times (W,) in s of all warm windows, by cell and way."""
    pairs = [(cell, scene) for cell, own in scenes.items() for scene in own]
    runs: dict[str, list[Mapping[str, Array]]] = {cell: [] for cell in scenes}
    for cell, scene in progress(pairs, 'cost', len(pairs)):
        runs[cell].append(timed(run_of(scene)))
    return {
        cell: {way: np.concatenate([run[way] for run in own]) for way in own[0]}
        for cell, own in runs.items()
    }


def timed(run: Run) -> Mapping[str, Array]:
    """Solve every window in all ways, one after the other; the first is not warm."""
    ways = {
        FULL: sequence(run),
        NO_JUMPS: sequence(run, jumps=False),
        NO_INTERVALS: sequence(run, intervals=False),
        BARE: sequence(run, jumps=False, intervals=False),
        PLAIN: chain(run),
    }
    records = run.records(run.plant.period)
    times = [
        [cpu_seconds(partial(solve, i, record)) for solve in ways.values()]
        for i, record in enumerate(records)
    ]
    return dict(zip(ways, np.array(times[1:]).T, strict=True))


def sequence(run: Run, *, jumps: bool = True, intervals: bool = True) -> Solve:
    """Return a solver of windows in sequence, with one stage or both put out of action."""
    windows = MovingHorizon(Solver.of(run.plant.model))

    def solve(i: int, record: Record) -> Estimate:
        with contextlib.ExitStack() as changed:
            if not jumps:
                changed.enter_context(
                    mock.patch.object(JumpSearch, 'run', lambda own, **_: own.best)
                )
            if not intervals:
                for stage, without in (
                    ('uncertainty_of', by_the_parabola),
                    ('with_intervals', lambda uncertainty, *_: uncertainty),
                ):
                    changed.enter_context(
                        mock.patch(f'obs_ros.horizon.moving_horizon.{stage}', without)
                    )
            return windows.solve(record, random_generator(0, i), Deadline(None))

    return solve


def by_the_parabola(best: Hypothesis) -> Uncertainty:
    """Return the uncertainty of a window as if it told everything."""
    states = best.problem.objective.unknowns.n_states
    return Uncertainty(best, best.covariance, marginal_information(best, states))


def chain(run: Run) -> Solve:
    """Return a solver of windows that has nothing but the previous estimate to start from."""
    solver = Solver.of(run.plant.model)
    previous: Estimate | None = None

    def solve(i: int, record: Record) -> Estimate:
        nonlocal previous
        previous = solver.solve(record, random_generator(0, i), Deadline(None), previous)
        return previous

    return solve


def ratio(times: Mapping[str, Array], way: str) -> float:
    """Return the median of the full window's time over that of the same window another way."""
    return float(np.median(times[FULL] / times[way]))


def table(cells: Mapping[str, Mapping[str, Array]]) -> str:
    """Tell medians in ms, and ratios."""
    rows = []
    for cell, times in cells.items():
        rows.append({
            'windows': cell,
            'number': len(times[FULL]),
            **{way: f'{1e3 * np.median(own):.2f}' for way, own in times.items()},
            '95 % with both': f'{1e3 * np.quantile(times[FULL], 0.95):.2f}',
            'ratio to neither': f'{ratio(times, BARE):.2f}',
            'to `solve_window`': f'{ratio(times, PLAIN):.2f}',
        })  # fmt: skip
    return markdown(rows)
