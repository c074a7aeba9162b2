"""Small loops run compiled where Numba is installed, and as they are elsewhere."""

import sys
from typing import Any, NamedTuple

import numpy as np
import pytest

from obs_ros.core.jit import accelerated, bound
from obs_ros.core.typing import Array


def sum_of_inverses(values: Any) -> Any:
    total = 0.0
    for value in values:
        total += 1.0 / value
    return total


def at_once(values: Any) -> Any:
    return (1.0 / values).sum()


def test_the_compiled_loop_gives_the_sum_and_divides_by_zero_as_arrays_do(
    tmp_path: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip('numba')
    monkeypatch.setenv('OBS_ROS_CACHE', str(tmp_path))
    fast = accelerated(sum_of_inverses)
    assert fast(np.array([1.0, 2.0, 4.0])) == 1.75
    assert fast(np.array([1.0, 0.0])) == np.inf
    (folder,) = tmp_path.iterdir()
    assert folder.name.startswith('obs_ros_accelerated_sum_of_inverses_')
    assert len(list(folder.glob('*.nbc'))) == 1


def test_without_numba_the_function_stays_or_gives_way_to_the_one_for_arrays(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(sys.modules, 'numba', None)
    assert accelerated(sum_of_inverses) is sum_of_inverses
    assert accelerated(sum_of_inverses, at_once) is at_once


class Line(NamedTuple):
    x: Array
    y: Array
    slope: float


def line(w: Line, offset: float) -> bool:
    for i in range(w.x.size):
        w.y[i] = w.slope * w.x[i] + offset
    return w.slope > 0.0


@pytest.mark.parametrize('kernel', [accelerated(line), line], ids=['accelerated', 'plain'])
def test_a_kernel_bound_to_a_workspace_does_the_same_for_arrays_of_any_length(kernel) -> None:
    found = bound(kernel, Line(np.zeros(2), np.zeros(2), 1.0), 0.0)
    for size in (3, 5):
        w = Line(np.arange(float(size)), np.empty(size), 2.0)
        assert found(w, 1.0)
        np.testing.assert_array_equal(w.y, 2.0 * w.x + 1.0)
        assert kernel(w, 3.0) and w.y[0] == 3.0
