"""Small loops run compiled where Numba is installed, and as they are elsewhere."""

import sys
from typing import Any

import numpy as np
import pytest

from obs_ros.core.jit import accelerated


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
