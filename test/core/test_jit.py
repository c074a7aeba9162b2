"""Tests of obs_ros.core.jit."""

from typing import NamedTuple

import numpy as np
import pytest

from obs_ros.core.jit import accelerated, bound
from obs_ros.core.typing import Array


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


def test_on_whole_arrays_another_function_may_do_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__('sys').modules, 'numba', None)  # as where it is not installed
    assert accelerated(line) is line
    assert accelerated(line, elsewhere=print) is print
