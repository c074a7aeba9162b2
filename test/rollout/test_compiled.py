"""Tests of obs_ros.rollout.compiled: generated modules and their cache."""

import logging
import os
import re
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from plants import BLOW_UP, OSCILLATOR

pytest.importorskip('numba')

from obs_ros.rollout.compiled import (
    KEPT_MODULES,
    LANES,
    cache_folder,
    load_module,
    padded,
    prune,
    source,
)

ROLL_OUT = """
import sys
import numpy as np
from obs_ros import Model, Record, Variable
from obs_ros.rollout.compiled import CompiledKernels
from obs_ros.rollout.grid import Grid

GAIN = float(sys.argv[1])

def dynamics(t, x, u, p):
    return (-GAIN * x[0],)

def output(t, x, u, p):
    return (x[0],)

model = Model(
    name='own', states=[Variable('x')], outputs=[Variable('y')], dynamics=dynamics, output=output
)
kernels = CompiledKernels(model)
grid = Grid.of(model, Record([0.0, 0.1], None, [1.0, 1.0]), np.ones(1))
states, _ = kernels.trajectories(grid, np.ones((1, 1)), np.empty((0, 1)))
print(states[-1, 0, 0], sum(kernels.module.trajectories.stats.cache_hits.values()))
"""


def roll_out(cache: Path, gain: float, script: str = ROLL_OUT) -> tuple[float, int]:
    """State after 0.1 s in a new process, and how often its kernel came from the cache."""
    ran = subprocess.run(
        [sys.executable, '-B', '-c', script, str(gain)],
        env={
            **os.environ,
            'OBS_ROS_CACHE': str(cache),
            'PYTHONPATH': os.pathsep.join([str(cache), *sys.path]),
        },
        capture_output=True,
        text=True,
        check=True,
    )
    state, hits = ran.stdout.split()
    return float(state), int(hits)


def test_a_second_process_loads_what_the_first_compiled(tmp_path: Path) -> None:
    first, hits = roll_out(tmp_path, 2.0)
    assert hits == 0
    assert first == pytest.approx(np.exp(-0.2), abs=1e-5)
    assert len(list(tmp_path.glob('obs_ros_kernels_*/*.py'))) == 1
    again, hits = roll_out(tmp_path, 2.0)
    assert (again, hits) == (first, 1)


def test_an_edited_module_of_constants_gives_no_stale_kernel(tmp_path: Path) -> None:
    script = ROLL_OUT.replace('GAIN = float(sys.argv[1])', 'import my_constants')
    script = script.replace('-GAIN', '-my_constants.GAIN')
    for gain in (1.0, 5.0):
        (tmp_path / 'my_constants.py').write_text(f'GAIN = {gain}\n')
        state, hits = roll_out(tmp_path, gain, script)
        assert state == pytest.approx(np.exp(-0.1 * gain), rel=1e-3)
        assert hits == 0


def test_equal_models_share_a_module_and_others_do_not() -> None:
    assert load_module(OSCILLATOR) is load_module(replace(OSCILLATOR, name='x', max_step=0.3))
    assert load_module(OSCILLATOR) is not load_module(replace(OSCILLATOR, integrator='euler'))


def own(gain: float) -> Any:
    return replace(BLOW_UP, dynamics=lambda t, x, u, p: (gain * x[0],))


def test_without_a_writable_folder_everything_works_but_with_a_warning(
    tmp_path: Path, monkeypatch: Any, caplog: Any
) -> None:
    blocked = tmp_path / 'file'
    blocked.write_text('')
    monkeypatch.setenv('OBS_ROS_CACHE', str(blocked))
    with caplog.at_level(logging.WARNING, 'obs_ros'):
        module = load_module(own(-1.0))
    assert 'compiling in every process' in caplog.text
    assert str(blocked) in caplog.text
    states, outputs = np.empty((2, 1, LANES)), np.empty((2, 1, LANES))
    t, none = np.array([0.0, 0.1]), np.empty((2, 0))
    x0 = np.full((1, LANES), 3.0)
    module.trajectories(t, np.array([1]), none, none, x0, np.empty((0, LANES)), states, outputs)
    np.testing.assert_allclose(states[1], 3.0 * np.exp(-0.1), rtol=1e-6)


def test_the_module_is_written_once(tmp_path: Path, monkeypatch: Any) -> None:
    monkeypatch.setenv('OBS_ROS_CACHE', str(tmp_path))
    load_module(own(-2.0))
    (path,) = tmp_path.glob('*/*.py')
    os.utime(path, (1.0, 1.0))
    sys.modules.pop(path.stem)
    load_module(own(-2.0))
    assert path.stat().st_mtime == 1.0
    assert list(path.parent.glob('tmp*')) == []


def test_compiling_is_announced_only_when_nothing_is_cached(
    tmp_path: Path, monkeypatch: Any, caplog: Any
) -> None:
    monkeypatch.setenv('OBS_ROS_CACHE', str(tmp_path))
    with caplog.at_level(logging.INFO, 'obs_ros'):
        load_module(own(-3.0))
    announcement = "compiling the kernels of model 'blow_up': several seconds, once"
    logger = 'obs_ros.rollout.compiled'
    assert caplog.record_tuples == [(logger, logging.INFO, announcement)]
    caplog.clear()
    (path,) = tmp_path.glob('*/*.py')
    (path.parent / '__pycache__').mkdir(exist_ok=True)
    (path.parent / '__pycache__' / 'kernels.nbi').touch()  # as Numba does when it has compiled
    sys.modules.pop(path.stem)
    with caplog.at_level(logging.INFO, 'obs_ros'):
        load_module(own(-3.0))
    assert caplog.record_tuples == []


def test_where_the_cache_is(monkeypatch: Any) -> None:
    monkeypatch.setenv('OBS_ROS_CACHE', '/a/b')
    assert cache_folder() == Path('/a/b')
    monkeypatch.delenv('OBS_ROS_CACHE')
    monkeypatch.setenv('XDG_CACHE_HOME', '/c')
    assert cache_folder() == Path('/c/obs_ros')
    monkeypatch.delenv('XDG_CACHE_HOME')
    monkeypatch.setenv('HOME', '/home/someone')
    assert cache_folder() == Path('/home/someone/.cache/obs_ros')


def test_the_modules_used_last_are_kept(tmp_path: Path) -> None:
    now = time.time()
    for age in range(KEPT_MODULES + 3):
        folder = tmp_path / f'obs_ros_kernels_{age}'
        folder.mkdir()
        os.utime(folder, (now - age, now - age))
    (tmp_path / 'not_ours').mkdir()
    prune(tmp_path)
    left = {path.name for path in tmp_path.iterdir()}
    assert left == {'not_ours', *(f'obs_ros_kernels_{age}' for age in range(KEPT_MODULES))}


def test_the_generated_module_is_python_with_the_models_sizes() -> None:
    text = source(OSCILLATOR)
    compile(text, 'kernels', 'exec')
    assert re.search(r'N_STATES, N_OUTPUTS, N_PARAMETERS, N_LANES = 2, 2, 2, 16', text)


@pytest.mark.parametrize(('count', 'lanes'), [(1, 16), (16, 16), (17, 32), (31, 32)])
def test_lanes_are_filled_with_the_last_candidate(count: int, lanes: int) -> None:
    x, p = padded(np.arange(2.0 * count).reshape(2, count), np.empty((0, count)))
    assert (x.shape, p.shape) == ((2, lanes), (0, lanes))
    assert x.flags.c_contiguous
    assert (x[:, count:] == x[:, count - 1 : count]).all()
