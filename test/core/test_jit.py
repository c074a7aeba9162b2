"""Small loops run compiled where Numba is installed, and as they are elsewhere."""

import sys
from typing import Any, NamedTuple

import numpy as np
import pytest

from obs_ros.core import jit, residual_tests
from obs_ros.core.jit import Unhurried, accelerated, bound, unhurried
from obs_ros.core.typing import Array
from obs_ros.inference.jumps import linearisation
from obs_ros.integration import window_steps


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


def grown(values: Any, factor: float) -> Any:
    total = values[0] * factor
    for i in range(values.size):
        values[i] = values[i] * factor + 0.1
        total += values[i] / (values[i] - 2.1)  # 0 / 0 in the second place
    return total, total > 0.0


def signatures(function: Any) -> int:
    return len(function.signatures)


def test_a_loop_is_interpreted_until_that_has_taken_its_time_and_the_bits_stay(
    tmp_path: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip('numba')
    monkeypatch.setenv('OBS_ROS_CACHE', str(tmp_path))
    loop = unhurried(grown)
    found = []
    for patience in (np.inf, -1.0, np.inf):  # what is compiled stays compiled
        monkeypatch.setattr(jit, 'SETTINGS', jit.JitSettings(patience))
        values = np.array([0.3, 1.0, 1.7])
        result = loop(values, 2.0)
        found.append((values.tolist(), repr(result)))
        assert signatures(loop) == (patience < 0.0 or len(found) == 3)
    assert found[0] == found[1] == found[2]
    assert found[0][1] == '(inf, True)'


def test_loops_that_call_each_other_are_interpreted_and_compiled_together(
    tmp_path: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip('numba')
    monkeypatch.setenv('OBS_ROS_CACHE', str(tmp_path))
    inner = unhurried(grown)

    def outer(values: Any, factor: float) -> Any:
        total, _ = inner(values, factor)
        return total + 1.0

    loop = unhurried(outer)
    values = np.ones(2)
    total = loop(values, 3.0)
    assert signatures(loop) == signatures(inner) == 0
    with jit.at_once():
        again = np.ones(2)
        assert loop(again, 3.0) == total
    np.testing.assert_array_equal(again, values)
    assert (signatures(loop), signatures(inner)) == (1, 1)


def awkward(rng: np.random.Generator, *shape: int) -> Array:
    """Numbers of all sizes, some NaN and infinite."""
    values = rng.standard_normal(shape) * 10.0 ** rng.integers(-8, 9, shape)
    for bad in (np.nan, np.inf, -np.inf):
        values[rng.random(shape) < 0.01] = bad
    return values


def arguments_of(name: str, rng: np.random.Generator) -> list[Any]:
    """Those of a call of the loop of this name."""
    nodes, outputs, lanes = int(rng.integers(0, 40)), 2, int(rng.integers(2, 9))
    y, weight = awkward(rng, nodes, outputs), rng.integers(0, 3, (nodes, outputs)) / 7.0
    several, period = awkward(rng, nodes, outputs, lanes), np.array([0.0, 2.0 * np.pi])
    if name == '_packed_looped':
        return [y, 1, np.zeros(nodes)]
    if name == '_squares_in_loops':
        return [y]
    if name == 'window_steps':
        return [several, awkward(rng, nodes, outputs, lanes), y, weight, period]
    return [several, y, weight, period, rng.uniform(1e-9, 1.0, lanes - 1)]


@pytest.mark.parametrize(
    ('name', 'loop'),
    [
        ('_packed_looped', residual_tests._packed),
        ('_squares_in_loops', residual_tests.squares_of),
        ('window_steps', window_steps.differences),
        ('linearisation', linearisation.differences),
    ],
)
def test_what_runs_before_a_loop_is_compiled_gives_the_same_bits(name: str, loop: Any) -> None:
    pytest.importorskip('numba')
    assert isinstance(loop, Unhurried) and loop.meanwhile is not loop.py_func
    rng = np.random.default_rng(5)
    for _ in range(200):
        arguments = arguments_of(name, rng)
        again = [each.copy() if isinstance(each, np.ndarray) else each for each in arguments]
        with np.errstate(all='ignore'):
            found = jit.as_compiled(loop.meanwhile(*arguments))
        expected = loop.compiled(*again)
        for mine, theirs in zip((*found, *arguments), (*expected, *again), strict=True):
            np.testing.assert_array_equal(mine, theirs)


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
