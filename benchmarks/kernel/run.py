"""The compiled three-tank rollout, hand-written C and NumPy, timed in turn; the Kalman filter."""

import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.c_twin import CHUNK, Rollout, c_rollout
from benchmarks.runner import cpu_seconds, repeats_for
from benchmarks.tanks import random_window
from obs_ros.core.typing import Array
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid
from obs_ros.models.three_tank import THREE_TANK

LANES = (1, 16, 32, 64)
MEASUREMENT = 0.005  # s of process time
NUMPY_ROUNDS = 3
PLAIN_LANES = 32  # of the rollouts that a filter's pass is measured in
WALK, NOISE = 0.05, 0.1  # cm per root of a second, cm


class Row(NamedTuple):
    """Medians at one number of lanes: ns per candidate-step, ratio to C, s per call of ours."""

    lanes: int
    ours: float
    c: float
    numpy: float
    ratio: float
    call: float


def rows_of(samples: int, rounds: int) -> list[Row]:
    """Measure every number of lanes on a random window of so many samples."""
    grid = Grid.of(THREE_TANK, random_window(1, samples, 20.0).record, np.ones(2))
    prefixes = np.array([samples])
    compiled, vectorised = kernels_for(THREE_TANK), kernels_for(THREE_TANK, 'numpy')

    def ours(x0: Array, p: Array) -> Array:
        return compiled.squares(grid, prefixes, x0, p)[0]

    def numpy(x0: Array, p: Array) -> Array:
        return vectorised.squares(grid, prefixes, x0, p)[0]

    with tempfile.TemporaryDirectory() as folder:
        c = c_rollout(grid, Path(folder))
        return [measured(lanes, samples, rounds, ours, c, numpy) for lanes in LANES]


class Pass(NamedTuple):
    """Medians of a filter's pass: ns per sample, the same in candidate-steps, allocations.

    Allocations are those of compiled code in a window ten times as long, beyond those in this.
    """

    ns: float
    steps: float
    allocations: int


def filter_pass(samples: int, rounds: int) -> Pass:
    """Measure the filter's pass on random windows, in turn with plain rollouts."""
    kernels, window = kernels_for(THREE_TANK), random_window(1, samples, 20.0)
    grid, prefixes = Grid.of(THREE_TANK, window.record, np.ones(2)), np.array([samples])
    rng = np.random.default_rng(PLAIN_LANES)
    x0, p = rng.uniform(5.0, 95.0, (3, PLAIN_LANES)), rng.uniform(0.2, 1.0, (3, PLAIN_LANES))

    def plain() -> None:
        kernels.squares(grid, prefixes, x0, p)

    times: dict[str, list[float]] = {'filter': [], 'plain': []}
    calls = {'filter': partial(filtered, grid), 'plain': plain}
    counts = {name: repeats_for(call, MEASUREMENT) for name, call in calls.items()}
    for _ in range(rounds):
        for name, call in calls.items():
            times[name].append(cpu_seconds(call, counts[name]))
    long = Grid.of(THREE_TANK, random_window(1, 10 * samples, 20.0).record, np.ones(2))
    work = PLAIN_LANES * (samples - 1)
    return Pass(
        ns=1e9 * float(np.median(times['filter'])) / samples,
        steps=float(np.median(np.divide(times['filter'], times['plain']))) * work / samples,
        allocations=allocations(partial(filtered, long)) - allocations(partial(filtered, grid)),
    )


def filtered(grid: Grid) -> None:
    """Run the filter along a window, with walks on all levels."""
    x0, p, walks = np.array([50.0, 40.0, 45.0]), np.full(3, 0.5), np.repeat([WALK, 0.0], 3)
    kernels_for(THREE_TANK).filter(grid, x0, p, walks, np.full(2, NOISE))


def allocations(call: Callable[[], None]) -> int:
    """Count the allocations of compiled code in one call."""
    from numba.core.runtime import _nrt_python, rtsys

    _nrt_python.memsys_enable_stats()
    before = rtsys.get_allocation_stats().alloc
    call()
    return int(rtsys.get_allocation_stats().alloc - before)


def measured(
    lanes: int, samples: int, rounds: int, ours: Rollout, c: Rollout | None, numpy: Rollout
) -> Row:
    """Interleave the measurements of all at one number of lanes, after checking that they agree."""
    rng = np.random.default_rng(lanes)
    x0, p = rng.uniform(5.0, 95.0, (3, lanes)), rng.uniform(0.2, 1.0, (3, lanes))
    expected = numpy(x0, p)
    np.testing.assert_allclose(ours(x0, p), expected, rtol=1e-9)
    count = repeats_for(lambda: ours(x0, p), MEASUREMENT)
    times: dict[str, list[float]] = {'ours': [], 'c': [], 'numpy': []}
    if c is not None:
        # C gets its lanes padded beforehand, as its caller would keep them.
        wide = tuple(np.pad(a, ((0, 0), (0, -lanes % CHUNK)), 'edge') for a in (x0, p))
        np.testing.assert_allclose(c(*wide)[:, :lanes], expected, rtol=1e-6)
    for number in range(rounds):
        times['ours'].append(cpu_seconds(lambda: ours(x0, p), count))
        if c is not None:
            times['c'].append(cpu_seconds(lambda: c(*wide), count))
        if number < NUMPY_ROUNDS:
            times['numpy'].append(cpu_seconds(lambda: numpy(x0, p)))
    unit = 1e9 / (lanes * (samples - 1))
    ours_s, c_s, numpy_s = (float(np.median(t)) if t else np.nan for t in times.values())
    ratio = float(np.median(np.divide(times['ours'], times['c']))) if c else np.nan
    return Row(lanes, ours_s * unit, c_s * unit, numpy_s * unit, ratio, ours_s)
