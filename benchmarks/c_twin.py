"""The three-tank rollout in hand-written C, the twin of the compiled kernel."""

import ctypes
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmarks.runner import gcc_version
from obs_ros.core.typing import Array
from obs_ros.integration.grid import Grid

CHUNK = 16
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
