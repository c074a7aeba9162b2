"""The benchmark of functions: what it reports, and that no function leaves the vector lanes."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.functions.__main__ import main
from benchmarks.functions.models import FUNCTIONS, PLAIN, spring
from benchmarks.functions.run import interval, rollout
from benchmarks.runner import cpu_seconds, gcc_version

MARGIN = 12.0  # times the plain step; measured 1 to 9, and 11 to 30 by calls of the C library


@pytest.mark.slow
def test_the_report_has_all_parts(tmp_path: Path) -> None:
    pytest.importorskip('numba')
    rows = main(['--quick', '--results', str(tmp_path)])
    assert {(row.name, row.method) for row in rows} == {
        ('where', 'rk4'), ('sin', 'rk4'), ('where', 'rosenbrock'), ('sin', 'rosenbrock'),
    }  # fmt: skip
    assert all(row.low <= row.ratio <= row.high for row in rows)
    assert np.isfinite(rows[0].c) == np.isfinite(rows[0].fast) == (gcc_version() is not None)
    text = (tmp_path / 'functions.md').read_text()
    assert all(f'\n| {name} |' in text for name in ('arctan2', 'power', 'three tanks'))


def test_the_interval_of_a_median_is_of_order_statistics() -> None:
    assert interval(np.arange(101.0)[::-1]) == (40.0, 60.0)
    assert interval(np.array([2.0, 1.0])) == (1.0, 2.0)


@pytest.mark.parametrize('name', ['sign', 'interp', 'sin', 'arctan2', 'hypot'])
def test_a_function_costs_a_few_plain_steps(name: str) -> None:
    """np.where made the step 200 times slower, in silence, and np.clip kept it from compiling."""
    pytest.importorskip('numba')
    plain, ours = (rollout(spring(f.python)) for f in (PLAIN, FUNCTIONS[name]))
    fastest = [min(cpu_seconds(call) for _ in range(30)) for call in (plain, ours)]
    assert fastest[1] < MARGIN * fastest[0]
