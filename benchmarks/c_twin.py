"""The three-tank rollout in hand-written C, the twin of the compiled kernel."""

import ctypes
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmarks.runner import cpu_seconds, gcc_version, repeats_for
from benchmarks.tanks import random_window
from obs_ros.core.typing import Array
from obs_ros.integration.grid import Grid
from obs_ros.models.three_tank import THREE_TANK

CHUNK = 16
LANES, YARDSTICK, SNR = 16, 1000, 20.0  # candidates, samples and dB of a timed rollout
C_OPTIONS = ('-O3', '-march=native', '-ffast-math')

Rollout = Callable[[Array, Array], Array]  # x0 (3, B), p (3, B) -> squares (2, B)


def c_rollout(grid: Grid, folder: Path) -> Rollout | None:
    """Compile c_twin.c and return it as a function; None, with a message, where there is no gcc."""
    if gcc_version() is None:
        print('no gcc: the comparison with C is skipped')
        return None
    path, compiled = folder / 'kernel.so', folder / 'kernel.o'
    source = Path(__file__).with_suffix('.c')
    subprocess.run(['gcc', *C_OPTIONS, '-fPIC', '-c', source, '-o', compiled], check=True)
    # Linked without -ffast-math, which would turn denormals to zero in this whole process.
    subprocess.run(['gcc', '-shared', compiled, '-o', path, '-lm'], check=True)
    function = ctypes.CDLL(str(path)).squares
    function.restype = None
    pointer = ctypes.c_void_p
    function.argtypes = [ctypes.c_long, ctypes.c_long, ctypes.c_double, *[pointer] * 5]
    y, u = np.ascontiguousarray(grid.y), np.ascontiguousarray(grid.u)
    h = float(grid.t[1] - grid.t[0])

    def rollout(x0: Array, p: Array) -> Array:
        out = np.empty((2, x0.shape[1]))
        addresses = (array.ctypes.data for array in (y, u, x0, p, out))
        function(len(y), x0.shape[1], h, *addresses)
        return out

    return rollout


def c_step() -> Callable[[], float]:
    """Return a function that measures what a candidate-step takes in C, in s; NaN without gcc."""
    window = random_window(1, YARDSTICK, SNR)
    grid = Grid.of(THREE_TANK, window.record, np.ones(2))
    with tempfile.TemporaryDirectory() as folder:
        rollout = c_rollout(grid, Path(folder))
    if rollout is None:
        return lambda: np.nan
    rng = np.random.default_rng(1)
    x0, p = rng.uniform(5.0, 95.0, (3, LANES)), rng.uniform(0.2, 1.0, (3, LANES))
    count = repeats_for(lambda: rollout(x0, p), 1e-3)
    return lambda: cpu_seconds(lambda: rollout(x0, p), count) / (LANES * (YARDSTICK - 1))
