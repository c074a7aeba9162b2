"""Table 7: what the race and the gate add to the time of a warm window."""

import contextlib
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any
from unittest import mock

import numpy as np

from benchmarks.common import Progress, cpu_seconds
from benchmarks.common import table as markdown
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

FULL, NO_RACE, NO_GATE, BARE, PLAIN = (
    'with race and gate',
    'without race',
    'without gate',
    'without both',
    '`solve_window` with `previous`',
)


def costs(scenes: Mapping[str, Sequence[Scene]]) -> Mapping[str, Mapping[str, Array]]:
    """Return process times (W,) in s of all warm windows, by cell and way."""
    progress = Progress('cost', sum(map(len, scenes.values())))
    times: dict[str, dict[str, Array]] = {}
    for cell, own in scenes.items():
        runs = []
        for scene in own:
            runs.append(timed(run_of(scene)))
            progress.step()
        times[cell] = {way: np.concatenate([run[way] for run in runs]) for way in runs[0]}
    return times


def timed(run: Run) -> Mapping[str, Array]:
    """Solve every window in all ways, one after the other; the first is not warm."""
    ways = {
        FULL: sequence(run),
        NO_RACE: sequence(run, race=False),
        NO_GATE: sequence(run, gate=False),
        BARE: sequence(run, race=False, gate=False),
        PLAIN: chain(run),
    }
    records = run.records(run.plant.period)
    times = [
        [cpu_seconds(partial(solve, i, record)) for solve in ways.values()]
        for i, record in enumerate(records)
    ]
    return dict(zip(ways, np.array(times[1:]).T, strict=True))


def sequence(run: Run, *, race: bool = True, gate: bool = True) -> Solve:
    """Return what solves the windows in sequence, its race or gate put out of action."""
    windows = MovingHorizon(Solver.of(run.plant.model))

    def solve(i: int, record: Record) -> Estimate:
        with contextlib.ExitStack() as changed:
            if not race:
                changed.enter_context(
                    mock.patch.object(JumpSearch, 'run', lambda own, **_: own.best)
                )
            if not gate:
                changed.enter_context(
                    mock.patch('obs_ros.horizon.moving_horizon.hold_uninformed', ungated)
                )
            return windows.solve(record, random_generator(0, i), Deadline(None))

    return solve


def ungated(best: Hypothesis, *_: Any) -> Uncertainty:
    """Return the uncertainty of a window as if it told everything."""
    states = best.problem.objective.unknowns.n_states
    return Uncertainty(best, best.covariance, marginal_information(best, states))


def chain(run: Run) -> Solve:
    """Return what solves the windows with nothing but the previous estimate to start from."""
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
        medians = [f'{1e3 * np.median(own):.2f}' for own in times.values()]
        high = f'{1e3 * np.quantile(times[FULL], 0.95):.2f}'
        ratios = [f'{ratio(times, way):.2f}' for way in (BARE, PLAIN)]
        rows.append((cell, len(times[FULL]), *medians, high, *ratios))
    ways = next(iter(cells.values()))
    head = ('windows', 'number', *ways, '95 % with both', 'ratio to neither', 'to `solve_window`')
    return markdown(head, rows)
