"""The kernel beside C and NumPy."""

import numpy as np

from benchmarks.kernel.__main__ import main as measure_kernel
from benchmarks.kernel.run import gcc_version


def test_the_kernel_benchmark_compares_equal_work(tmp_path):
    rows = measure_kernel(['--samples', '100', '--rounds', '2', '--results', str(tmp_path)])
    assert [row.lanes for row in rows] == [1, 16, 32, 64]
    assert all(row.ours < row.numpy for row in rows)
    assert all(np.isfinite(row.ratio) == (gcc_version() is not None) for row in rows)
    assert 'ours / C' in (tmp_path / 'kernel.md').read_text()
