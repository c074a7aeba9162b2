"""Peers on windows, each beside ours on the same window moments before, in the same process."""

import contextlib
import functools
import os
import warnings
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from benchmarks.peers.problem import Filtered, Oracle, Problem, Stopped
from benchmarks.peers.registry import OURS, PEERS, Solve
from benchmarks.report import rms
from benchmarks.runner import monte_carlo, timed

CASES = ('three tanks 1000, 20 dB', 'Lorenz 5')
WARM_SEED = 1
REPEATS, QUICK = 3, 0.2  # what takes less seconds is measured so often


class Measured(NamedTuple):
    """Process times of a task in s, ours on the same window just before beside it, and errors.

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


def solved(
    cases: Sequence[str],
    peers: Sequence[str],
    seeds: Sequence[int],
    slow: Sequence[int],
    starts: int,
    cap: float,
) -> list[Measured]:
    """Judge the windows of every case, then solve them by every peer; slow ones solve fewer."""
    # All threads count; on matrices this small, more than one of them only costs.
    os.environ['OPENBLAS_NUM_THREADS'] = os.environ['OMP_NUM_THREADS'] = '1'
    windows = {case: [(case, seed, starts) for seed in seeds] for case in cases}
    best = monte_carlo(judged, windows, 'judge')
    tasks = {
        peer: [
            (peer, case, seed, least, cap)
            for case in cases
            for seed, least in zip(seeds, best[case], strict=True)
            if not PEERS[peer].slow or seed in slow
        ]
        for peer in peers
    }
    return [one for own in monte_carlo(measured, tasks, 'solve').values() for one in own]


def judged(case: str, seed: int, starts: int) -> float:
    """Return the best optimum of a window, in sigma^2, that its judge finds from so many starts."""
    return Problem.of(case, seed).judged(starts, seed)


def measured(peer: str, case: str, seed: int, best: float, cap: float) -> Measured:
    """Solve a window by ourselves, then by the peer, in this process.

    Each is stopped at the optimum known as the `best`, or after `cap` s of process time.
    """
    problem = Problem.of(case, seed)
    solve, build = prepared(peer, case)
    ours, _ = prepared(OURS, case)
    own = repeated(ours, problem, seed, best, cap)[0]
    seconds, oracle, filtered = repeated(solve, problem, seed, best, cap)
    found = filtered or problem.at_end(oracle.best)
    n = len(problem.model.states)
    return Measured(
        case=case,
        seed=seed,
        peer=peer,
        seconds=seconds,
        ours=own,
        build=build,
        excess=np.nan if filtered else oracle.least - best,
        reached=oracle.reached,
        parameter_error=float(rms((found.parameters - problem.truth[n:]) / problem.width[n:])),
        state_error=float(rms((found.state - problem.end) / problem.width[:n])),
    )


@functools.cache
def prepared(peer: str, case: str) -> tuple[Solve, float]:
    """Return a peer ready for a case, warm, and the process time in s that this took."""
    problem = Problem.of(case, WARM_SEED)
    with warnings.catch_warnings():
        warnings.simplefilter('ignore')
        solve, build = timed(lambda: PEERS[peer].prepare(problem))
    # Reached at once, or after the first of its points: compiles and loads all that a solve needs.
    run(solve, Oracle(problem, np.inf if peer != OURS else 0.0, 1.0), WARM_SEED)
    return solve, build


def repeated(
    solve: Solve, problem: Problem, seed: int, best: float, cap: float
) -> tuple[float, Oracle, Filtered | None]:
    """Return the median time of a solve, several times the same if quick, and its last outcome."""
    times: list[float] = []
    while not times or (times[0] < QUICK and len(times) < REPEATS):
        oracle = Oracle(problem, best + problem.room, cap)
        filtered, seconds = run(solve, oracle, seed)
        times.append(seconds)
    return float(np.median(times)), oracle, filtered


def run(solve: Solve, oracle: Oracle, seed: int) -> tuple[Filtered | None, float]:
    """Return the result of one solve, and its process time in s, all threads together."""

    def until_stopped() -> Filtered | None:
        oracle.start()
        with contextlib.suppress(Stopped):
            return solve(oracle, seed)
        return None

    with warnings.catch_warnings(), np.errstate(all='ignore'):
        warnings.simplefilter('ignore')
        return timed(until_stopped)
