"""The process that compiles for a node: all that the node does, and no more than it can store."""

import json
import math
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from node_values import values_of
from patience import patience

pytest.importorskip('numba')

from obs_ros.interface.compilation import environment
from obs_ros.interface.compilation_child import compile_all, parameters
from obs_ros.interface.settings import build_observer
from obs_ros.models import load_model


def last_words(values: Any) -> str:
    """Return the last line of a child that fails; its stdin stays open meanwhile."""
    with subprocess.Popen(
        [sys.executable, '-P', '-m', 'obs_ros.interface.compilation_child'],
        env=environment(), text=True, stdin=subprocess.PIPE, stderr=subprocess.PIPE,
    ) as child:  # fmt: skip
        assert child.stdin is not None and child.stderr is not None
        child.stdin.write(json.dumps(values) + '\n')
        child.stdin.flush()
        assert child.wait(patience(60.0)) == 1
        return child.stderr.read().splitlines()[-1]


def test_parameters_come_through_as_they_are() -> None:
    values = values_of('three_tank', 'sliding_window')
    found = parameters(json.dumps(values))
    assert {type(v) for v in values.values()} >= {tuple, float, str}
    assert any(isinstance(v, float) and math.isnan(v) for v in values.values())
    assert repr(found) == repr(values)
    model = load_model('three_tank')
    assert build_observer(model, found).model == build_observer(model, values).model


def test_prediction_and_rare_kernels_are_compiled_too(monkeypatch: Any) -> None:
    done = []

    class Observed:
        def __init__(self, *_: Any) -> None:
            self.left = 2

        def prepare(self) -> float:
            done.append('prepare')
            return 0.0

        def prepare_more(self) -> bool:
            done.append('more')
            self.left -= 1
            return self.left > 0

    class Foretold:
        def __init__(self, *_: Any) -> None:
            pass

        def follow(self, values: Any, unknowns: Any) -> None:
            assert unknowns is None

        def prepare(self) -> None:
            done.append('prediction')

    path = 'obs_ros.interface.compilation_child'
    monkeypatch.setattr(f'{path}.build_observer', Observed)
    monkeypatch.setattr(f'{path}.Forecast', Foretold)
    values = values_of('three_tank', 'sliding_window')
    compile_all({**values, 'prediction.enabled': True})
    compile_all({**values, 'prediction.enabled': False})
    assert done == ['prepare', 'prediction', 'more', 'more', 'prepare', 'more', 'more']


def test_a_model_that_cannot_be_imported_is_named() -> None:
    assert 'no_such_module' in last_words({'model': 'no_such_module:MODEL'})


@pytest.mark.slow
def test_it_stops_at_the_first_kernel_that_cannot_be_stored(
    tmp_path: Path, monkeypatch: Any
) -> None:
    folder = tmp_path / 'cache'
    folder.write_text('no folder')
    monkeypatch.setenv('OBS_ROS_CACHE', str(folder))
    said = last_words(values_of('linear_second_order', 'sliding_window'))
    assert 'compiling in every process' in said


NODE = """
import json, sys
from numba.core import compiler
from obs_ros.interface.compilation import Compilation
from obs_ros.interface.compilation_child import parameters
from obs_ros.interface.settings import build_observer
from obs_ros.models import load_model

def refused(*_, **__):
    raise AssertionError('compiled here')

compiler.compile_extra = refused
values = parameters(sys.argv[1])
observer = build_observer(load_model(values['model']), values)
with Compilation().of(values):
    print(observer.prepare() > 0.0, observer.prepare_more())
"""


@pytest.mark.slow
def test_all_that_every_window_needs_comes_from_the_child(tmp_path: Path, monkeypatch: Any) -> None:
    monkeypatch.setenv('OBS_ROS_CACHE', str(tmp_path / 'cache'))
    values = values_of('plants:BLOW_UP', 'sliding_window')
    ended = subprocess.run(
        [sys.executable, '-c', NODE, json.dumps(values)], env=environment(),
        capture_output=True, text=True, timeout=patience(100.0), check=False,
    )  # fmt: skip
    assert ended.stdout == 'True True\n', ended.stderr
    assert 'compiling in this process' not in ended.stderr
