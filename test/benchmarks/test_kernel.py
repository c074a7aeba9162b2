"""The kernel beside C and NumPy."""

import numpy as np

from benchmarks.c_twin import gcc_version
from benchmarks.kernel.__main__ import main as measure_kernel
from benchmarks.kernel.run import filter_pass


def test_the_kernel_benchmark_compares_equal_work(tmp_path):
    rows = measure_kernel(['--samples', '100', '--rounds', '2', '--results', str(tmp_path)])
    assert [row.lanes for row in rows] == [1, 16, 32, 64]
    assert all(row.ours < row.numpy for row in rows)
    assert all(np.isfinite(row.ratio) == (gcc_version() is not None) for row in rows)
    text = (tmp_path / 'kernel.md').read_text()
    assert 'ours / C' in text and 'candidate-steps per sample' in text


def test_a_pass_is_measured_in_steps_and_allocations_are_counted():
    found = filter_pass(100, 2)
    assert 1.0 < found.steps < 1000.0 and found.allocations == 0
    assert found.ns > 0.0
