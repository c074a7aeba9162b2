"""Tests of obs_ros.integration.backends: which kernels one gets."""

import logging
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from patience import patience
from plants import BLOW_UP, LAG, OSCILLATOR

from obs_ros import Record
from obs_ros.core.prior_knowledge import with_knowledge
from obs_ros.integration import backends
from obs_ros.integration.backends import check_backend, kernels_for, run_once
from obs_ros.integration.grid import Grid
from obs_ros.integration.stepper import stepper_for
from obs_ros.integration.vectorised import NumpyKernels


def test_kernels_are_made_once_per_model() -> None:
    assert kernels_for(OSCILLATOR, 'numpy') is kernels_for(OSCILLATOR, 'numpy')
    assert kernels_for(OSCILLATOR, 'numpy').model == OSCILLATOR


def test_threads_that_ask_at_once_get_the_same_kernels(monkeypatch: Any) -> None:
    made, begun, go = [], threading.Event(), threading.Event()

    class Slow(NumpyKernels):
        def __init__(self, model: Any) -> None:
            super().__init__(model)
            made.append(model)
            begun.set()
            assert go.wait(patience(5.0))

    monkeypatch.setattr(backends, 'NumpyKernels', Slow)
    model = replace(OSCILLATOR, name='of_two_threads')
    with ThreadPoolExecutor(2) as pool:
        one = pool.submit(kernels_for, model, 'numpy')
        assert begun.wait(patience(5.0))
        other = pool.submit(kernels_for, model, 'numpy')
        go.set()
        assert one.result() is other.result()
    assert len(made) == 1


def test_numba_is_taken_where_it_is_installed() -> None:
    pytest.importorskip('numba')
    assert kernels_for(replace(BLOW_UP, name='with_numba')).name == 'numba'


def test_the_environment_variable_chooses(monkeypatch: Any) -> None:
    monkeypatch.setenv('OBS_ROS_BACKEND', 'numpy')
    kernels = kernels_for(replace(BLOW_UP, name='by_environment'))
    assert (kernels.name, kernels.compile_time) == ('numpy', 0.0)


def test_the_environment_variable_counts_after_the_first_use_too(monkeypatch: Any) -> None:
    pytest.importorskip('numba')
    assert kernels_for(BLOW_UP).name == 'numba'
    monkeypatch.setenv('OBS_ROS_BACKEND', 'numpy')
    assert kernels_for(BLOW_UP).name == 'numpy'


def test_the_argument_overrules_the_environment_variable(monkeypatch: Any) -> None:
    monkeypatch.setenv('OBS_ROS_BACKEND', 'numba')
    assert kernels_for(replace(BLOW_UP, name='by_argument'), 'numpy').name == 'numpy'


@pytest.mark.parametrize('way', ['argument', 'environment'])
def test_an_unknown_backend_is_refused(monkeypatch: Any, way: str) -> None:
    if way == 'environment':
        monkeypatch.setenv('OBS_ROS_BACKEND', 'cuda')
    with pytest.raises(ValueError, match="backend 'cuda' is neither 'numba' nor 'numpy'"):
        check_backend('cuda' if way == 'argument' else None)


def test_without_numba_numpy_is_taken_and_numba_refused(monkeypatch: Any) -> None:
    monkeypatch.setitem(sys.modules, 'numba', None)
    monkeypatch.delitem(sys.modules, 'obs_ros.integration.compiled', raising=False)
    assert kernels_for(replace(BLOW_UP, name='without_numba')).name == 'numpy'
    with pytest.raises(ImportError, match=r'Numba does not work here: .*; pip install'):
        kernels_for(replace(BLOW_UP, name='without_numba'), 'numba')


def test_a_broken_numba_leaves_numpy_and_says_so(
    tmp_path: Path, monkeypatch: Any, caplog: Any
) -> None:
    (tmp_path / 'numba').mkdir()
    (tmp_path / 'numba' / '__init__.py').write_text("raise ImportError('needs another NumPy')")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, 'numba', raising=False)
    monkeypatch.delitem(sys.modules, 'obs_ros.integration.compiled', raising=False)
    with caplog.at_level(logging.WARNING, 'obs_ros'):
        assert kernels_for(replace(BLOW_UP, name='broken_numba')).name == 'numpy'
    assert 'Numba does not work here: needs another NumPy; NumPy is used' in caplog.text


def _by_newton(t: Any, x: Any, u: Any, p: Any) -> Any:
    root = 1.0
    while abs(root**2 - abs(x[0])) > 1e-12:  # as often as the values want it
        root = 0.5 * (root + abs(x[0]) / root)
    return [root]


def test_a_model_that_cannot_be_compiled_runs_on_numpy_and_says_why_once(caplog: Any) -> None:
    pytest.importorskip('numba')
    model = replace(BLOW_UP, name='odd', dynamics=_by_newton)
    with caplog.at_level(logging.WARNING, 'obs_ros'):
        kernels = kernels_for(model)
        assert stepper_for(model).name == 'numpy'
    assert isinstance(kernels, NumpyKernels)
    (message,) = caplog.messages
    assert message.startswith("model 'odd' cannot be compiled: dynamics: use np.where, or a loop")
    assert '`while abs(root**2 - abs(x[0])) > 1e-12:' in message
    with pytest.raises(ValueError, match="model 'odd' cannot be compiled"):
        kernels_for(model, 'numba')
    x = np.array([[4.0, 2.0]])
    np.testing.assert_allclose(model.dynamics(0.0, x, (), ()), np.sqrt(x), rtol=1e-9)


def test_a_function_that_its_author_compiled_compiles_too() -> None:
    numba = pytest.importorskip('numba')
    dynamics = numba.njit(lambda t, x, u, p: (x[0] * x[0],))
    assert kernels_for(replace(BLOW_UP, name='own_njit', dynamics=dynamics)).name == 'numba'


_helpers = ModuleType('helpers')
_helpers.__dict__.update(square=lambda x: x * x)


def _through_a_module(t: Any, x: Any, u: Any, p: Any) -> Any:
    return (_helpers.square(x[0]),)


def test_helpers_in_a_module_compile_too() -> None:
    pytest.importorskip('numba')
    model = replace(BLOW_UP, name='modular', dynamics=_through_a_module)
    assert kernels_for(model).name == 'numba'


def test_numpy_kernels_take_constant_derivatives_and_outputs() -> None:
    from obs_ros import Record
    from obs_ros.integration.grid import Grid

    model = replace(BLOW_UP, dynamics=lambda t, x, u, p: (2.0,), output=lambda t, x, u, p: (7.0,))
    grid = Grid.of(model, Record([0.0, 1.0], None, [7.0, 8.0]), np.ones(1))
    kernels = kernels_for(model, 'numpy')
    states, outputs = kernels.trajectories(grid, np.zeros((1, 3)), np.empty((0, 3)))
    np.testing.assert_allclose(states[1], 2.0, rtol=1e-14)
    assert (outputs == 7.0).all()
    assert kernels.squares(grid, np.array([2]), np.zeros((1, 3)), np.empty((0, 3))).tolist() == [
        [[1.0, 1.0, 1.0]]
    ]
    assert kernels.grams(grid, 2, np.zeros((1, 3)), np.empty((0, 3)), 3)[0, 0, 0] == 1.0


def test_models_that_differ_in_walks_and_priors_share_kernels(backend: str) -> None:
    lag = replace(LAG, name=f'known_{backend}')
    first = kernels_for(lag, backend)
    for walk, mean in ((0.1, 2.0), (0.2, 3.0)):
        model = with_knowledge(lag, {'k': walk}, {'tau': (mean, 0.5), 'x': (0.0, 1.0)})
        found = kernels_for(model, backend)
        assert found.model == model != lag and found is kernels_for(model, backend)
        assert {**vars(found), 'model': lag} == vars(first)


def test_for_another_walk_or_prior_nothing_is_compiled(monkeypatch: Any) -> None:
    compiled = pytest.importorskip('obs_ros.integration.compiled')
    made: list[str] = []
    make = compiled.CompiledKernels.__init__

    def counted(self: Any, model: Any) -> None:
        made.append(model.name)
        make(self, model)

    monkeypatch.setattr(compiled.CompiledKernels, '__init__', counted)
    lag = replace(LAG, name='counted')
    kernels = kernels_for(lag, 'numba')
    before = [len(kernel.signatures) for kernel in vars(kernels.module).values()
              if hasattr(kernel, 'signatures')]  # fmt: skip
    for prior in ((5.0, 1.0), (6.0, 2.0)):
        other = kernels_for(with_knowledge(lag, {'x': 0.1}, {'tau': prior}), 'numba')
        run_once(other)
        after = [len(kernel.signatures) for kernel in vars(other.module).values()
                 if hasattr(kernel, 'signatures')]  # fmt: skip
        assert after == before
    assert made == ['counted'] and sum(before) > 0


@pytest.mark.parametrize('backend', ['numpy', 'numba'])
def test_functions_get_the_windows_own_time(backend: Any) -> None:
    if backend == 'numba':
        pytest.importorskip('numba')
    model = replace(
        BLOW_UP,
        name='clock',
        time='window',
        dynamics=lambda t, x, u, p: (2.0 * t,),
        output=lambda t, x, u, p: (x[0] + 100.0 * t,),
    )
    t = 1.7e9 + 0.25 * np.arange(5)
    grid = Grid.of(model, Record(t, None, np.zeros(5)), np.ones(1))
    kernels = kernels_for(model, backend)
    states, outputs = kernels.trajectories(grid, np.ones((1, 1)), np.ones((0, 1)))
    since = t - t[0]
    np.testing.assert_allclose(states[:, 0, 0], 1.0 + since**2, rtol=1e-12)
    np.testing.assert_allclose(outputs[:, 0, 0], 1.0 + since**2 + 100.0 * since, rtol=1e-12)
