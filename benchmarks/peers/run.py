"""Our default search beside other ways to estimate the same windows to the same target.

Three tanks (1000 samples, 20 dB) and Lorenz (5 time units, 500 samples, 40 dB), six unknowns each.
A window is solved when the squares are within 0.1025 d sigma^2 of the best known optimum. Peers are
an optional extra (`make peers`); one that is missing is skipped by name.
"""

import contextlib
import functools
import os
import time
import warnings
from importlib import metadata
from typing import NamedTuple

import numpy as np

from benchmarks.common import machine, on_all_cores, options, publish
from benchmarks.peers.problem import Filtered, Oracle, Problem, Stopped
from benchmarks.peers.registry import OURS, PEERS, Solve
from benchmarks.peers.report import report
from obs_ros.core.typing import Array

CASES = ('three tanks 1000, 20 dB', 'Lorenz 5')
WARM_SEED = 1
REPEATS, QUICK = 3, 0.2  # what takes less seconds is measured so often
PACKAGES = ('pygmo', 'pymoo', 'cma', 'casadi', 'do-mpc', 'filterpy')


class Window(NamedTuple):
    """Which window, how many starts its judge takes, and then the optimum it found."""

    case: str
    seed: int
    starts: int
    best: float = np.nan


class Task(NamedTuple):
    """One peer on one window, stopped after `cap` seconds of process time."""

    window: Window
    peer: str
    cap: float


class Measured(NamedTuple):
    """What came of a task: process times in s, ours on the same window just before beside it.

    `excess` over the judge's optimum in sigma^2 (NaN: it does not minimise squares); errors are
    root mean squares over the parameters, and over the states at the window's end, in their boxes.
    """

    case: str
    seed: int
    peer: str
    seconds: float
    ours: float
    build: float
    excess: float
    reached: bool
    parameter_error: float
    state_error: float


def main(arguments: list[str] | None = None) -> list[Measured]:
    """Judge, measure, print, and write the report."""
    parser = options(__doc__)
    parser.add_argument('--windows', type=int, default=10, help='per case')
    parser.add_argument('--slow-windows', type=int, default=3, help='per case, for slow peers')
    parser.add_argument('--seed', type=int, default=8000, help='of the first window')
    parser.add_argument('--starts', type=int, default=6, help='of the judge, beside the truth')
    parser.add_argument('--cap', type=float, default=60.0, help='process time per solve, in s')
    parser.add_argument('--peers', nargs='+', choices=[*PEERS], default=[*PEERS], metavar='NAME')
    parser.add_argument('--cases', nargs='+', choices=CASES, default=[*CASES], metavar='CASE')
    chosen = parser.parse_args(arguments)
    missing = [name for name in chosen.peers if not PEERS[name].present]
    for name in missing:
        print(f'{name}: skipped, {PEERS[name].package} is not installed (make peers)')
    # All threads count; on matrices this small, more than one of them only costs.
    os.environ['OPENBLAS_NUM_THREADS'] = os.environ['OMP_NUM_THREADS'] = '1'
    seeds = range(chosen.seed, chosen.seed + chosen.windows)
    windows = [Window(case, seed, chosen.starts) for case in chosen.cases for seed in seeds]
    best = on_all_cores(judged, windows, 'judge')
    tasks = [
        Task(window._replace(best=least), name, chosen.cap)
        for name in dict.fromkeys([OURS, *chosen.peers])
        if name not in missing
        for window, least in zip(windows, best, strict=True)
        if not PEERS[name].slow or window.seed < chosen.seed + chosen.slow_windows
    ]
    results = on_all_cores(measured, tasks, 'solve')
    parts = report(results, missing, chosen.results, chosen.cap, seeds)
    title = 'Peers: the same windows to the same target'
    publish(chosen.results, 'peers', title, parts, machine(*versions()))
    return results


def versions() -> list[str]:
    """Return the versions of the peers that are there."""
    found = []
    for name in PACKAGES:
        try:
            found.append(f'{name} {metadata.version(name)}')
        except metadata.PackageNotFoundError:
            continue
    return found


def judged(window: Window) -> float:
    """Return the best known optimum of a window, in sigma^2."""
    problem = Problem.of(window.case, window.seed)
    return problem.judged(window.starts, window.seed)


def measured(task: Task) -> Measured:
    """Solve a window by ourselves, then by the peer, in this process."""
    problem = Problem.of(task.window.case, task.window.seed)
    solve, build = prepared(task.peer, task.window.case)
    ours, _ = prepared(OURS, task.window.case)
    own = repeated(ours, problem, task)[0]
    seconds, oracle, filtered = repeated(solve, problem, task)
    found = filtered or problem.at_end(oracle.best)
    n = len(problem.model.states)
    return Measured(
        case=task.window.case,
        seed=task.window.seed,
        peer=task.peer,
        seconds=seconds,
        ours=own,
        build=build,
        excess=np.nan if filtered else oracle.least - task.window.best,
        reached=oracle.reached,
        parameter_error=error(found.parameters, problem.truth[n:], problem.width[n:]),
        state_error=error(found.state, problem.end, problem.width[:n]),
    )


@functools.cache
def prepared(peer: str, case: str) -> tuple[Solve, float]:
    """Return a peer ready for a case, warm, and the process time in s that this took."""
    problem = Problem.of(case, WARM_SEED)
    begin = time.process_time()
    with warnings.catch_warnings():
        warnings.simplefilter('ignore')
        solve = PEERS[peer].prepare(problem)
    build = time.process_time() - begin
    # Reached at once, or after the first of its points: compiles and loads all that a solve needs.
    timed(solve, Oracle(problem, np.inf if peer != OURS else 0.0, 1.0), WARM_SEED)
    return solve, build


def repeated(solve: Solve, problem: Problem, task: Task) -> tuple[float, Oracle, Filtered | None]:
    """Return the median time of a solve, several times the same if quick, and its last outcome."""
    times: list[float] = []
    while not times or (times[0] < QUICK and len(times) < REPEATS):
        oracle = Oracle(problem, task.window.best + problem.room, task.cap)
        seconds, filtered = timed(solve, oracle, task.window.seed)
        times.append(seconds)
    return float(np.median(times)), oracle, filtered


def timed(solve: Solve, oracle: Oracle, seed: int) -> tuple[float, Filtered | None]:
    """Return the process time of one solve, all threads together, and what it returned."""
    filtered = None
    with warnings.catch_warnings(), np.errstate(all='ignore'):
        warnings.simplefilter('ignore')
        begin = time.process_time()
        oracle.start()
        with contextlib.suppress(Stopped):
            filtered = solve(oracle, seed)
        return time.process_time() - begin, filtered


def error(found: Array, truth: Array, width: Array) -> float:
    """Return the root mean square error in units of the box."""
    return float(np.sqrt(np.mean(((found - truth) / width) ** 2)))
