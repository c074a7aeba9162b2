"""Time of the compiled three-tank rollout beside hand-written C and NumPy, in one run.

Work of a candidate-step: one RK4 step and the squared residuals of two outputs. All three are
called from Python, their arguments laid out anew (ours) or ready (C): with windows of 1000 samples
a call takes 0.1 ms or more, so that what the call itself costs does not show.
"""

import ctypes
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.common import cpu_seconds, gcc_version, machine, mark, options, publish, repeats_for
from benchmarks.common import table as markdown
from benchmarks.tanks import random_window
from obs_ros.core.typing import Array
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid
from obs_ros.models.three_tank import THREE_TANK

LANES = (1, 16, 32, 64)
CHUNK = 16
C_OPTIONS = ('-O3', '-march=native', '-ffast-math')
MEASUREMENT = 0.005  # s of process time
NUMPY_ROUNDS = 3
RATIO_LIMITS = {1: 1.3, 16: 1.2, 32: 1.2, 64: 1.3}
ONE_LANE_LIMIT = 1.05  # noise of the measurement; one lane is padded to 16

Rollout = Callable[[Array, Array], Array]  # x0 (3, B), p (3, B) -> squares (2, B)


class Row(NamedTuple):
    """Medians at one number of lanes: ns per candidate-step, ratio to C, s per call of ours."""

    lanes: int
    ours: float
    c: float
    numpy: float
    ratio: float
    call: float


def main(arguments: list[str] | None = None) -> list[Row]:
    """Measure, print, and write the report."""
    parser = options(__doc__)
    parser.add_argument('--samples', type=int, default=1000, help='of the window')
    parser.add_argument('--rounds', type=int, default=41, help='interleaved measurements')
    chosen = parser.parse_args(arguments)
    grid = Grid.of(THREE_TANK, random_window(1, chosen.samples, 20.0).record, np.ones(2))
    prefixes = np.array([chosen.samples])
    compiled, vectorised = kernels_for(THREE_TANK), kernels_for(THREE_TANK, 'numpy')
    with tempfile.TemporaryDirectory() as folder:
        c = c_rollout(grid, Path(folder))
        rows = [
            measured(
                lanes,
                chosen.samples,
                chosen.rounds,
                lambda x0, p: compiled.squares(grid, prefixes, x0, p)[0],
                c,
                lambda x0, p: vectorised.squares(grid, prefixes, x0, p)[0],
            )
            for lanes in LANES
        ]
    version = gcc_version()
    line = machine(f'gcc {version} {" ".join(C_OPTIONS)}' if version else 'no gcc')
    publish(chosen.results, 'kernel', 'Rollout kernel', report(rows, chosen.rounds), line)
    return rows


def c_rollout(grid: Grid, folder: Path) -> Rollout | None:
    """Compile kernel.c and return it as a function; None, with a message, where there is no gcc."""
    if gcc_version() is None:
        print('no gcc: the comparison with C is skipped')
        return None
    path, compiled = folder / 'kernel.so', folder / 'kernel.o'
    source = Path(__file__).with_name('kernel.c')
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
    ratio = float('nan')
    if c is not None:
        ratio = float(np.median(np.divide(times['ours'], times['c'])))
    medians = (float(np.median(t)) if t else float('nan') for t in times.values())
    ours_s, c_s, numpy_s = medians
    return Row(lanes, ours_s * unit, c_s * unit, numpy_s * unit, ratio, ours_s)


def report(rows: list[Row], rounds: int) -> list[str]:
    """Return the parts of the report."""
    lines = [
        (
            row.lanes,
            f'{row.ours:.1f}',
            f'{row.c:.1f}',
            f'{row.numpy:.0f}',
            f'{row.ratio:.2f}',
            f'{RATIO_LIMITS[row.lanes]}',
            'skipped' if np.isnan(row.ratio) else mark(row.ratio <= RATIO_LIMITS[row.lanes]),
        )
        for row in rows
    ]
    head = ('lanes', 'ours (ns)', 'C (ns)', 'NumPy (ns)', 'ours / C', 'limit', 'within')
    one, sixteen = rows[0].call, rows[1].call
    return [
        'Process time per candidate and RK4 step with the squared residuals of two outputs; '
        f'medians of {rounds} interleaved measurements, the ratio being the median of their '
        'ratios. Ours and C compute chunks of 16 lanes, so one lane costs as much as 16. '
        'What the calls from Python cost is included; windows of this length make it small.',
        markdown(head, lines),
        f'One lane (padded) takes {one / sixteen:.2f} times as long as 16 lanes: not slower: '
        f'{mark(one <= ONE_LANE_LIMIT * sixteen)}.',
    ]
