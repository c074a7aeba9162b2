"""Rollouts of springs by their friction, beside C and another source tree, timed in turn."""

import ctypes
import shutil
import subprocess
from collections.abc import Callable
from contextlib import ExitStack
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.functions.models import FUNCTIONS, PLAIN, STEP, Function, spring
from benchmarks.runner import cpu_seconds, repeats_for
from benchmarks.trees import Tree
from obs_ros import Model, Record
from obs_ros.core.model import Integrator
from obs_ros.core.typing import Array
from obs_ros.integration.compiled import CompiledKernels
from obs_ros.integration.grid import Grid
from obs_ros.integration.vectorised import NumpyKernels

CANDIDATES = 64
SAMPLES = 1000
CHECKED = 50  # samples of the rollout that is compared with NumPy's
MEASUREMENT = 0.004  # s of process time
UNIT = 1e9 / (CANDIDATES * (SAMPLES - 1))  # ns per candidate-step, of s
C_OPTIONS = ('-O3', '-march=native')
FAST = '-ffast-math'

Call = Callable[[], object]


class Row(NamedTuple):
    """Medians in ns per candidate-step; the ratio to the plain spring, and its 95 % interval.

    NaN is what was not measured: C without gcc, and another tree without one.
    """

    name: str
    method: Integrator
    limit: float
    ours: float
    ratio: float
    low: float
    high: float
    c: float
    fast: float
    theirs: float


def rows_of(
    names: list[str], method: Integrator, rounds: int, folder: Path, against: Path | None
) -> list[Row]:
    """Measure springs with these frictions, each in turn with the plain one."""
    with ExitStack() as stack:
        tree = stack.enter_context(Tree(against)) if against else None
        plain = rollout(spring(PLAIN.python, method))
        return [measured(name, method, plain, rounds, folder, tree) for name in names]


def measured(
    name: str, method: Integrator, plain: Call, rounds: int, folder: Path, tree: Tree | None
) -> Row:
    """Measure one spring."""
    function = FUNCTIONS[name]
    calls = {'plain': plain, 'ours': rollout(spring(function.python, method))}
    if method == 'rk4' and shutil.which('gcc'):
        for kind, options in ('c', C_OPTIONS), ('fast', (*C_OPTIONS, FAST)):
            calls[kind] = c_rollout(
                function, options, folder / f'{list(FUNCTIONS).index(name)}_{kind}.so'
            )
    counts = {kind: repeats_for(call, MEASUREMENT) for kind, call in calls.items()}
    times: dict[str, list[float]] = {kind: [] for kind in ('plain', 'ours', 'c', 'fast', 'theirs')}
    for _ in range(rounds):
        for kind, call in calls.items():
            times[kind].append(cpu_seconds(call, counts[kind]) * UNIT)
        if tree is not None:
            times['theirs'].append(tree.call(seconds_of, name, method) * UNIT)
    ratios = np.divide(times['ours'], times['plain'])
    medians = {kind: float(np.median(each)) if each else np.nan for kind, each in times.items()}
    medians.pop('plain')
    low, high = interval(ratios)
    return Row(name, method, function.limit, ratio=float(np.median(ratios)), low=low, high=high,
               **medians)  # fmt: skip


def interval(values: Array) -> tuple[float, float]:
    """Return the 95 % interval of a median: the order statistics of the binomial distribution."""
    n = len(values)
    rank = max(0, int(0.5 * n - 0.98 * np.sqrt(n)))
    ordered = np.sort(values)
    return float(ordered[rank]), float(ordered[n - 1 - rank])


def seconds_of(name: str, method: Integrator) -> float:
    """Return the process time of one rollout, in whatever source tree this runs."""
    call, count = _ready(name, method)
    return cpu_seconds(call, count)


@cache
def _ready(name: str, method: Integrator) -> tuple[Call, int]:
    call = rollout(spring(FUNCTIONS[name].python, method), check=False)
    return call, repeats_for(call, MEASUREMENT)


def rollout(model: Model, check: bool = True) -> Call:
    """Return a call that rolls candidates of the model out, after a check against NumPy."""
    grid, x0, p = window(model)
    prefixes, short = np.array([SAMPLES]), np.array([CHECKED])
    compiled = CompiledKernels(model)
    if check:
        np.testing.assert_allclose(
            compiled.squares(grid, short, x0, p),
            NumpyKernels(model).squares(grid, short, x0, p),
            rtol=1e-9,
        )
    return lambda: compiled.squares(grid, prefixes, x0, p)


def window(model: Model) -> tuple[Grid, Array, Array]:
    """Return a grid of samples one step apart, and states and parameters within the bounds."""
    rng = np.random.default_rng(0)
    u = rng.uniform(0.0, 1.0, (SAMPLES, len(model.inputs)))
    y = np.zeros((SAMPLES, len(model.outputs)))
    grid = Grid.of(model, Record(STEP * np.arange(SAMPLES), u, y), np.ones(len(model.outputs)))
    x0, p = (
        np.array([rng.uniform(v.lower, v.upper, CANDIDATES) for v in group])
        for group in (model.states, model.parameters)
    )
    return grid, x0, p


def c_rollout(function: Function, options: tuple[str, ...], path: Path) -> Call:
    """Compile spring.c with this friction; return its call, after a check against NumPy."""
    source, made = Path(__file__).with_name('spring.c'), path.with_suffix('.o')
    friction = f'-DFUNCTION(v)=({function.c})'
    subprocess.run(['gcc', *options, friction, '-fPIC', '-c', source, '-o', made], check=True)
    # Linked without -ffast-math, which would turn denormals to zero in this whole process.
    subprocess.run(['gcc', '-shared', made, '-o', path, '-lm'], check=True)
    squares = ctypes.CDLL(str(path)).squares
    squares.restype = None
    pointer = ctypes.c_void_p
    squares.argtypes = [ctypes.c_long, ctypes.c_long, ctypes.c_double, *[pointer] * 5]
    model = spring(function.python)
    grid, x0, p = window(model)
    y, u, out = (np.ascontiguousarray(a) for a in (grid.y, grid.u, np.empty(CANDIDATES)))

    def call(samples: int = SAMPLES) -> Array:
        squares(samples, CANDIDATES, STEP, *(a.ctypes.data for a in (y, u, x0, p, out)))
        return out

    expected = NumpyKernels(model).squares(grid, np.array([CHECKED]), x0, p)[0, 0]
    np.testing.assert_allclose(call(CHECKED), expected, rtol=1e-9 if FAST not in options else 1e-6)
    return call
