"""Kernels by a child process: made, loaded, and compiled here wherever that cannot be."""

import importlib
import json
import logging
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import pytest
from patience import patience

pytest.importorskip('numba')

from obs_ros.core import kernel_cache
from obs_ros.core.kernel_cache import cache_trouble
from obs_ros.interface import compilation
from obs_ros.interface.compilation import AbandonedError, Child, Children, Compilation

KERNEL = """
from obs_ros.core.jit import accelerated

def made_anew():
    def tripled(x):
        return 3.0 * x
    return accelerated(tripled)
"""

SLOW = pytest.mark.slow

# Stands in for the child: it compiles one function, as the real one does a model.
PLAY = """
import os, pathlib, time
from played_kernel import made_anew
from obs_ros.interface import compilation_child

def play(values):
    pathlib.Path(values['log']).open('a').write('begun\\n')
    if values.get('dies'):
        os.kill(os.getpid(), 9)
    while values.get('waits') and not pathlib.Path(values['waits']).exists():
        time.sleep(0.01)
    for _ in range(values.get('kernels', 1)):
        made_anew()(3.0)

compilation_child.compile_all = play
compilation_child.main()
"""


def made_anew() -> Any:
    """Return the function that the child compiles, as another process has it."""
    return importlib.import_module('played_kernel').made_anew()


def loaded(function: Any) -> int:
    return sum(function.stats.cache_hits.values())


@pytest.fixture
def asked(tmp_path: Path, monkeypatch: Any) -> Any:
    """Parameters of a child that logs its starts, with a cache that is empty."""
    (tmp_path / 'played_child.py').write_text(PLAY)
    (tmp_path / 'played_kernel.py').write_text(KERNEL)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, 'played_kernel', raising=False)
    monkeypatch.setenv('OBS_ROS_CACHE', str(tmp_path / 'cache'))
    monkeypatch.setattr(kernel_cache, '_troubles', [])
    monkeypatch.setattr(compilation, 'CHILD', 'played_child')
    children = Children()
    monkeypatch.setattr(compilation, 'CHILDREN', children)
    yield {'log': str(tmp_path / 'log')}
    if children._newest is not None:
        children._newest.process.kill()
        assert children._newest.ended.wait(patience(10.0))


def starts(asked: Any) -> int:
    log = Path(asked['log'])
    return len(log.read_text().splitlines()) if log.exists() else 0


def computed(asked: Any, function: Any) -> float:
    with Compilation().of(asked):
        return float(function(2.0))


def gone(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return True
    return Path(f'/proc/{process}/stat').read_text().rsplit(')')[1].split()[0] == 'Z'


def wait_until(predicate: Any) -> None:
    end = time.monotonic() + patience(10.0)
    while not predicate():
        assert time.monotonic() < end, 'nothing came of it'
        time.sleep(0.01)


def test_a_child_compiles_and_this_process_loads(asked: Any) -> None:
    function = made_anew()
    assert computed(asked, function) == 6.0
    assert (loaded(function), starts(asked)) == (1, 1)


def test_nothing_is_started_where_the_kernel_is_in_the_cache(asked: Any) -> None:
    made_anew()(1.0)
    function = made_anew()
    assert computed(asked, function) == 6.0
    assert (loaded(function), starts(asked)) == (1, 0)


def test_outside_of_the_context_nothing_is_started(asked: Any) -> None:
    function = made_anew()
    assert function(2.0) == 6.0
    assert (loaded(function), starts(asked)) == (0, 0)


@pytest.mark.parametrize('how', ['dies', 'fails'])
def test_where_the_child_fails_the_process_compiles_itself_and_says_so(
    asked: Any, how: str, caplog: Any
) -> None:
    asked = {**asked, 'dies': True} if how == 'dies' else {**asked, 'kernels': 'many'}
    function = made_anew()
    with caplog.at_level(logging.WARNING):
        assert computed(asked, function) == 6.0
    assert (loaded(function), starts(asked)) == (0, 1)
    (said,) = [each.message for each in caplog.records]
    assert said.startswith('compiling in this process: another one failed: ')
    assert said.endswith('exit code -9') if how == 'dies' else 'TypeError' in said


def test_a_child_that_does_not_make_what_is_missing_is_not_started_twice(asked: Any) -> None:
    asked = {**asked, 'kernels': 0}
    for _ in range(2):
        function = made_anew()
        assert computed(asked, function) == 6.0
        for path in Path(os.environ['OBS_ROS_CACHE']).glob('*/*.nbc'):
            path.unlink()
    assert starts(asked) == 1


def test_where_nothing_can_be_stored_no_child_is_started(asked: Any, monkeypatch: Any) -> None:
    monkeypatch.setenv('OBS_ROS_CACHE', str(Path(os.devnull) / 'cache'))
    function = made_anew()
    assert computed(asked, function) == 6.0
    assert (loaded(function), starts(asked)) == (0, 0)
    assert 'compiling in every process' in cache_trouble()


def test_where_no_process_can_be_started_this_one_compiles(
    asked: Any, monkeypatch: Any, caplog: Any
) -> None:
    monkeypatch.setattr(sys, 'executable', str(Path(os.devnull) / 'python'))
    assert computed(asked, made_anew()) == 6.0
    assert 'no other can be started' in caplog.text


def test_one_that_takes_for_ever_is_killed(asked: Any, monkeypatch: Any, caplog: Any) -> None:
    monkeypatch.setattr(compilation, 'SETTINGS', compilation.CompilationSettings(longest=0.2))
    assert computed({**asked, 'waits': '/nowhere'}, made_anew()) == 6.0
    assert 'exit code -9' in caplog.text


def test_threads_wait_for_one_child_and_others_are_served_after_it(
    asked: Any, tmp_path: Path
) -> None:
    go, results = tmp_path / 'go', []
    first = {**asked, 'waits': str(go), 'kernels': 0}
    threads = [
        threading.Thread(target=lambda a=a: results.append(computed(a, made_anew())))
        for a in (first, first, asked)
    ]
    threads[0].start()
    wait_until(lambda: starts(asked))
    for each in threads[1:]:
        each.start()
    go.touch()
    for each in threads:
        each.join(patience(20.0))
    assert results == [6.0] * 3
    assert starts(asked) in (1, 2)  # the last one may find what a thread has compiled by then


def waiting(owner: Compilation, asked: Any) -> threading.Thread:
    """Return the thread of a job that waits for a child until its owner closes."""

    def job() -> None:
        with pytest.raises(AbandonedError), owner.of(asked):
            made_anew()(2.0)

    thread = threading.Thread(target=job)
    thread.start()
    wait_until(lambda: starts(asked))
    return thread


def test_closing_ends_the_wait_but_not_the_child_of_others(asked: Any, tmp_path: Path) -> None:
    go, results = tmp_path / 'go', []
    asked = {**asked, 'waits': str(go)}
    owner, function = Compilation(), made_anew()
    thread = waiting(owner, asked)
    other = threading.Thread(target=lambda: results.append(computed(asked, function)))
    other.start()
    child = compilation.CHILDREN._newest
    assert child is not None and owner.under_way
    wait_until(lambda: len(child.askers) == 2)
    owner.close()
    thread.join(patience(5.0))
    assert not thread.is_alive() and other.is_alive()
    go.touch()
    other.join(patience(20.0))
    assert results == [6.0]
    assert (loaded(function), starts(asked)) == (1, 1)
    wait_until(lambda: not owner.under_way)


def test_a_child_ends_when_nobody_waits_any_more_and_who_asks_again_gets_another(
    asked: Any, tmp_path: Path, caplog: Any
) -> None:
    go = tmp_path / 'go'
    asked = {**asked, 'waits': str(go)}
    owner = Compilation()
    thread = waiting(owner, asked)
    child = compilation.CHILDREN._newest
    assert child is not None
    owner.close()
    thread.join(patience(5.0))
    wait_until(lambda: gone(child.process.pid))
    assert child.ended.wait(patience(5.0)) and not caplog.records
    go.touch()
    function = made_anew()
    assert computed(asked, function) == 6.0
    assert (loaded(function), starts(asked)) == (1, 2)


ENDING = """
import json, sys, threading, time
from obs_ros.interface import compilation
compilation.CHILD = 'played_child'
child = compilation.Child(json.dumps({asked!r}))
print(child.process.pid, flush=True)
time.sleep(600.0)
"""


@pytest.mark.parametrize('number', [signal.SIGKILL, pytest.param(signal.SIGINT, marks=SLOW)])
def test_the_child_ends_with_its_parent_however_that_ends(asked: Any, number: int) -> None:
    script = ENDING.format(asked={**asked, 'waits': '/nowhere'})
    with subprocess.Popen(
        [sys.executable, '-c', script], env=compilation.environment(),
        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
    ) as parent:  # fmt: skip
        assert parent.stdout is not None
        child = int(parent.stdout.readline())
        wait_until(lambda: starts(asked))
        assert not gone(child)
        parent.send_signal(number)
        assert parent.wait(patience(10.0)) != 0
    wait_until(lambda: gone(child))


def test_a_child_that_has_ended_leaves_no_zombie(asked: Any) -> None:
    child = Child(json.dumps(asked))
    assert child.ended.wait(patience(20.0))
    with pytest.raises(ProcessLookupError):
        os.kill(child.process.pid, 0)
