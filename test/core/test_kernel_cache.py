"""Tests of obs_ros.core.kernel_cache: what is stored is used, never stale, and never in the way."""

import contextlib
import hashlib
import logging
import os
import pickle
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from patience import patience
from plants import BLOW_UP

pytest.importorskip('numba')

import obs_ros
from obs_ros.core import kernel_cache
from obs_ros.core.jit import accelerated
from obs_ros.core.kernel_cache import (
    DIGEST,
    CacheSettings,
    cache_folder,
    cache_trouble,
    locked,
    prune,
    remembered,
    write,
)
from obs_ros.integration.backends import tiny_window
from obs_ros.integration.compiled import CompiledKernels
from obs_ros.integration.grid import Grid
from obs_ros.integration.kernel_modules import load_module
from obs_ros.integration.vectorised import NumpyKernels

PATIENCE = patience(50.0)  # s for a process that compiles


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: Any) -> Path:
    """A cache folder that is empty, of a process that has met no trouble yet."""
    folder = tmp_path / 'cache'
    monkeypatch.setenv('OBS_ROS_CACHE', str(folder))
    monkeypatch.setattr(kernel_cache, '_troubles', [])
    monkeypatch.setattr(kernel_cache, '_unloadable', set())
    return folder


def stored_files(cache: Path) -> list[Path]:
    return sorted(cache.glob('*/*.nbc'))


def doubled() -> Any:
    """Return the same function anew, as in another process."""

    def double(x: float) -> float:
        return 2.0 * x

    return accelerated(double)


def hits(function: Any) -> int:
    return sum(function.stats.cache_hits.values())


def start(script: str, cache: Path, *paths: Path, **more: Any) -> 'subprocess.Popen[str]':
    environment = {
        **os.environ,
        'OBS_ROS_CACHE': str(cache),
        'PYTHONPATH': os.pathsep.join([*map(str, paths), *sys.path]),
    }
    return subprocess.Popen(
        [sys.executable, '-P', '-B', '-c', script], env=environment, text=True,
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, **more,
    )  # fmt: skip


def output_of(process: 'subprocess.Popen[str]') -> list[str]:
    out, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, err
    return out.split()


def test_what_one_dispatcher_compiled_the_next_loads(cache: Path) -> None:
    first, second = doubled(), doubled()
    assert (first(3.0), second(3.0)) == (6.0, 6.0)
    assert (hits(first), hits(second)) == (0, 1)
    (path,) = stored_files(cache)
    assert path.parent.name.startswith('obs_ros_accelerated_double_')


LOADS = """
import sys
import numpy as np
from obs_ros.core.jit import accelerated


def length(x):
    return np.sqrt(x[0] * x[0] + x[1] * x[1])


def bytes_of(x):
    return hash((x, 1.0))


print(accelerated(length)(np.array([3.0, 4.0])), 'numba.np.arraymath' in sys.modules)
print(accelerated(bytes_of)(2.5), 'numba.cpython.hashing' in sys.modules)
"""


def test_code_is_loaded_without_all_that_numba_can_compile_unless_it_calls_that(
    cache: Path,
) -> None:
    """A hash of Python's needs the process's secret, which only Numba's module makes known."""
    first, second = (output_of(start(LOADS, cache)) for _ in range(2))
    assert first == ['5.0', 'True', str(hash((2.5, 1.0))), 'True']
    assert second[:2] == ['5.0', 'False']
    assert second[2:] == first[2:]


def test_every_signature_has_a_file(cache: Path) -> None:
    function = doubled()
    assert (function(3.0), function(3)) == (6.0, 6)
    assert len(stored_files(cache)) == 2


def content(value: bytes) -> bytes:
    return hashlib.sha256(value).digest() + value


class Calls:
    """Pickles as a call, which unpickling makes."""

    def __init__(self, function: Callable[..., Any], *arguments: Any) -> None:
        self.call = function, arguments

    def __reduce__(self) -> Any:
        return self.call


# What an interrupted copy, another version or a module that is gone leaves.
DAMAGED: dict[str, Callable[[bytes], bytes]] = {
    'empty': lambda whole: b'',
    'cut': lambda whole: whole[:-100],
    'one bit': lambda whole: whole[:-1] + bytes([whole[-1] ^ 1]),
    'no pickle': lambda whole: content(b'abc'),
    'half a pickle': lambda whole: content(whole[DIGEST : DIGEST + 200]),
    'of another shape': lambda whole: content(pickle.dumps((1, 2))),
    'no tuple': lambda whole: content(pickle.dumps(None)),
    'ModuleNotFoundError': lambda whole: content(pickle.dumps(Calls(__import__, 'gone_since'))),
    'AttributeError': lambda whole: content(pickle.dumps(Calls(getattr, 1, 'gone_since'))),
}


@pytest.mark.parametrize('damage', DAMAGED.values(), ids=DAMAGED)
def test_a_file_that_does_not_load_is_compiled_anew_and_overwritten(
    cache: Path, caplog: Any, damage: Callable[[bytes], bytes]
) -> None:
    doubled()(3.0)
    (path,) = stored_files(cache)
    write(path, damage(path.read_bytes()))
    after, last = doubled(), doubled()
    with caplog.at_level(logging.WARNING, 'obs_ros'):
        assert (after(3.0), last(3.0)) == (6.0, 6.0)
    assert (hits(after), hits(last)) == (0, 1)
    assert [str(path) in message for message in caplog.messages] == [True]
    assert 'compiling anew' in caplog.text


def test_a_text_is_made_once_and_anew_where_its_file_is_damaged(cache: Path, caplog: Any) -> None:
    made: list[int] = []

    def text() -> str:
        made.append(len(made))
        return f'text {len(made)}'

    found = [remembered('obs_ros_kernels_x', 'kernels.txt', text) for _ in range(2)]
    path = cache / 'obs_ros_kernels_x' / 'kernels.txt'
    for damage in (b'', b'abc', content(b'\xff\xfe'), path.read_bytes()[:-1]):
        write(path, damage)
        found.append(remembered('obs_ros_kernels_x', 'kernels.txt', text))
    path.unlink()
    path.mkdir()
    found.append(remembered('obs_ros_kernels_x', 'kernels.txt', text))
    assert found == [f'text {n}' for n in (1, 1, 2, 3, 4, 5, 6)]
    assert 'does not load' in caplog.text


def test_files_that_may_not_be_read_are_said_once(
    cache: Path, caplog: Any, monkeypatch: Any
) -> None:
    doubled()(3.0)
    doubled()(3)

    def forbidden(path: Path) -> bytes:
        raise PermissionError(13, 'Permission denied', str(path))

    monkeypatch.setattr(Path, 'read_bytes', forbidden)
    with caplog.at_level(logging.WARNING, 'obs_ros'):
        after = doubled()
        assert (after(3.0), after(3)) == (6.0, 6)
    assert [record.levelname for record in caplog.records] == ['WARNING']
    assert 'Permission denied' in caplog.text


def test_kernels_of_a_model_that_do_not_load_are_compiled_anew(cache: Path) -> None:
    states = [trajectory(kernels := fresh(BLOW_UP))]
    (path,) = stored_files(cache)
    write(path, path.read_bytes()[:1000])
    states += [trajectory(fresh(BLOW_UP)), trajectory(kernels := fresh(BLOW_UP))]
    assert hits(kernels.module.trajectories) == 1
    assert states[0] == states[1] == states[2] == pytest.approx(1.0 / 1.9, rel=1e-6)


def fresh(model: obs_ros.Model) -> CompiledKernels:
    """Return a model's kernels as another process would have them."""
    sys.modules.pop(load_module(model).__name__)
    return CompiledKernels(model)


def trajectory(kernels: CompiledKernels) -> float:
    """Return the state of BLOW_UP after 0.1 s, from 0.5."""
    record = obs_ros.Record(np.array([0.0, 0.1]), np.empty((2, 0)), np.full((2, 1), 0.5))
    grid = Grid.of(BLOW_UP, record, np.ones(1))
    states, _ = kernels.trajectories(grid, np.full((1, 1), 0.5), np.empty((0, 1)))
    return float(states[-1, 0, 0])


def test_where_nothing_can_be_written_it_runs_and_says_so(cache: Path, caplog: Any) -> None:
    cache.write_text('no folder')
    function = doubled()
    with caplog.at_level(logging.WARNING, 'obs_ros'):
        assert function(3.0) == 6.0
    assert 'compiling in every process' in caplog.text
    assert str(cache) in cache_trouble()


def test_a_function_that_cannot_be_stored_runs(cache: Path) -> None:
    table = np.arange(1_000_000.0)

    def entry(i: int) -> float:
        return float(table[i])

    assert accelerated(entry)(7) == 7.0
    assert 'large table' in cache_trouble()
    assert stored_files(cache) == []


PLANT = """
import numpy as np
from obs_ros import Model, Record, Variable
from obs_ros.integration.compiled import CompiledKernels
from obs_ros.integration.grid import Grid

def rate(x):
    return -2.0 * x

def dynamics(t, x, u, p):
    return (rate(x[0]),)

def output(t, x, u, p):
    return (x[0],)

MODEL = Model(
    name='own', states=[Variable('x')], outputs=[Variable('y')], dynamics=dynamics, output=output
)

def roll_out():
    kernels = CompiledKernels(MODEL)
    grid = Grid.of(MODEL, Record([0.0, 0.1], None, [1.0, 1.0]), np.ones(1))
    states, _ = kernels.trajectories(grid, np.ones((1, 1)), np.empty((0, 1)))
    return states[-1, 0, 0], sum(kernels.module.trajectories.stats.cache_hits.values())
"""


def rolled_out(cache: Path, folder: Path, script: str) -> tuple[float, int]:
    state, count = output_of(start(script, cache, folder))
    return float(state), int(count)


@pytest.mark.slow
def test_a_models_module_may_be_renamed_and_even_be_no_module(tmp_path: Path) -> None:
    """Files that name the old module once ended `solve_window` with ModuleNotFoundError."""
    names = [tmp_path / 'plant_a.py', tmp_path / 'plant_b.py']
    names[0].write_text(PLANT)
    found = [rolled_out(tmp_path, tmp_path, 'import plant_a; print(*plant_a.roll_out())')]
    names[0].rename(names[1])
    found += [rolled_out(tmp_path, tmp_path, 'import plant_b; print(*plant_b.roll_out())')]
    run = f'import runpy; print(*runpy.run_path({str(names[1])!r}, run_name="gone")["roll_out"]())'
    found += [rolled_out(tmp_path, tmp_path, run) for _ in range(2)]
    assert {state for state, _ in found} == {found[0][0]}
    assert found[0][0] == pytest.approx(np.exp(-0.2), abs=1e-5)
    assert [count for _, count in found] == [0, 0, 0, 1]


@pytest.mark.slow
def test_processes_that_start_together_compile_once(tmp_path: Path) -> None:
    script = PLANT + "print('ready', flush=True)\ninput()\nprint(*roll_out())"
    with contextlib.ExitStack() as stack:
        both = [stack.enter_context(start(script, tmp_path)) for _ in range(2)]
        for process in both:
            assert process.stdout is not None and process.stdin is not None
            assert process.stdout.readline() == 'ready\n'
        for process in both:
            assert process.stdin is not None
            process.stdin.write('go\n')
            process.stdin.flush()
        results = [output_of(process) for process in both]
    assert results[0][0] == results[1][0]
    assert sorted(count for _, count in results) == ['0', '1']


def test_nobody_waits_for_ever(tmp_path: Path) -> None:
    soon = CacheSettings(longest_wait=0.1)
    entered = []
    # As if another process had stopped while compiling.
    with locked(tmp_path), locked(tmp_path, soon):
        entered.append(True)
    assert entered == [True]


# It stops itself, while the second kernel is compiled: a test that is starved would be too late.
INTERRUPTED = """
import os, pathlib, signal, threading, time
import numpy as np
from plants import BLOW_UP
from obs_ros.integration.backends import tiny_window
from obs_ros.integration.compiled import CompiledKernels

def stop():
    while not list(pathlib.Path(os.environ['OBS_ROS_CACHE']).glob('*/*.nbc')):
        time.sleep(0.01)
    {stop}

threading.Thread(target=stop, daemon=True).start()
kernels, (grid, x0, p) = CompiledKernels(BLOW_UP), tiny_window(BLOW_UP)
kernels.trajectories(grid, x0, p)
kernels.squares(grid, np.array([grid.t.size]), x0, p)
kernels.grams(grid, grid.t.size, x0, p, 1)
"""
STOPS = {
    'SIGINT': 'os.kill(os.getpid(), signal.SIGINT)',
    'SIGTERM': 'os.kill(os.getpid(), signal.SIGTERM)',
    'os._exit': 'os._exit(3)',
}


@pytest.mark.slow
@pytest.mark.parametrize('way', STOPS)
def test_stopping_while_compiling_keeps_what_is_done(cache: Path, way: str) -> None:
    with start(INTERRUPTED.format(stop=STOPS[way]), cache) as process:
        process.communicate(timeout=PATIENCE)
    assert process.returncode in (3, -signal.SIGINT, -signal.SIGTERM)
    done = stored_files(cache)
    assert 1 <= len(done) < 3  # squares, grams, trajectories
    kernels = fresh(BLOW_UP)
    grid, x0, p = tiny_window(BLOW_UP)
    states, _ = kernels.trajectories(grid, x0, p)
    assert hits(kernels.module.trajectories) == 1
    np.testing.assert_array_equal(states, NumpyKernels(BLOW_UP).trajectories(grid, x0, p)[0])


SPREAD = """
import numpy as np
from obs_ros.observers.kalman_filters.ekf import Workspace, spread
from obs_ros.observers.innovation_gate import Gate
from obs_ros.observers.kalman_filters.joint import Joint
one, none, x = np.ones(1), np.zeros(0), np.zeros((1, 16))
joint = Joint(
    z=one, covariance=np.eye(1), walk=one, noise=one, low=-9.0 * one, high=9.0 * one, most=one,
    period=np.zeros(1), rows=np.zeros(0, int), xs=x, ps=np.zeros((0, 16)), ys=np.zeros((1, 16)),
    x=one.copy(), p=none, stddev=one.copy(), innovation=one.copy(),
    innovation_stddev=one.copy(), surprise=one.copy(), gate=Gate.of(1, 5.0, 9),
)
spread(Workspace(joint, one.copy(), one.copy()))
print(x[0, 0], x[0, 1], sum(spread.stats.cache_hits.values()))
"""


@pytest.mark.slow
def test_an_edited_function_of_another_module_is_never_stale(tmp_path: Path) -> None:
    """To Numba, which looks at ekf.py alone, `spread` there is as new with the old `place`."""
    shutil.copytree(Path(obs_ros.__file__).parent, tmp_path / 'obs_ros')
    kalman = tmp_path / 'obs_ros' / 'observers' / 'kalman_filters' / 'joint.py'
    text, line = kalman.read_text(), '        xs[i, lane] = z[i]\n'
    assert text.count(line) == 1

    def spread() -> list[str]:
        return output_of(start(SPREAD, tmp_path / 'cache', tmp_path))

    assert spread() == ['1.0', '2.0', '0']
    kalman.write_text(text.replace(line, '        xs[i, lane] = 5.0 * z[i]\n'))
    assert spread() == ['5.0', '2.0', '0']
    kalman.write_text(f'{text}\n# a comment')  # whose change means nothing
    assert spread() == ['1.0', '2.0', '1']


def test_where_the_cache_is(monkeypatch: Any) -> None:
    monkeypatch.setenv('OBS_ROS_CACHE', '/a/b')
    assert cache_folder() == Path('/a/b')
    monkeypatch.delenv('OBS_ROS_CACHE')
    monkeypatch.setenv('XDG_CACHE_HOME', '/c')
    assert cache_folder() == Path('/c/obs_ros')
    monkeypatch.delenv('XDG_CACHE_HOME')
    monkeypatch.setenv('HOME', '/home/someone')
    assert cache_folder() == Path('/home/someone/.cache/obs_ros')


def test_a_user_without_a_home_stores_nothing(monkeypatch: Any) -> None:
    monkeypatch.delenv('OBS_ROS_CACHE')
    monkeypatch.delenv('XDG_CACHE_HOME', raising=False)
    monkeypatch.setattr(Path, 'home', lambda: (_ for _ in ()).throw(RuntimeError('no home')))
    with pytest.raises(OSError):
        write(cache_folder() / 'folder' / 'file', b'')


def test_the_folders_used_last_are_kept(tmp_path: Path) -> None:
    now = time.time()
    for kind in ('kernels', 'accelerated'):
        for age in range(6):
            folder = tmp_path / f'obs_ros_{kind}_{age}'
            folder.mkdir()
            os.utime(folder, (now - age, now - age))
    (tmp_path / 'not_ours').mkdir()
    prune(tmp_path, CacheSettings(kept=3))
    kept = {f'obs_ros_{kind}_{age}' for kind in ('kernels', 'accelerated') for age in range(3)}
    assert {path.name for path in tmp_path.iterdir()} == {'not_ours', *kept}


def test_loading_counts_as_use(cache: Path) -> None:
    doubled()(3.0)
    (path,) = stored_files(cache)
    os.utime(path.parent, (1.0, 1.0))
    doubled()(3.0)
    assert path.parent.stat().st_mtime > 1.0


def test_nothing_half_written_is_left(tmp_path: Path, monkeypatch: Any) -> None:
    monkeypatch.setattr(os, 'replace', lambda *_: (_ for _ in ()).throw(OSError(28, 'full')))
    with pytest.raises(OSError, match='full'):
        write(tmp_path / 'file', b'content')
    assert list(tmp_path.iterdir()) == []
