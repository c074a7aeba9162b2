"""Tests of obs_ros.interface.checkpoint."""

import json
import threading
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest
from patience import patience
from plants import LAG

from obs_ros import Model
from obs_ros.core.plain_data import Shapes, from_plain
from obs_ros.interface import checkpoint as module
from obs_ros.interface.checkpoint import Checkpoint, checkpoint_path
from obs_ros.interface.checkpoint_file import FORMAT, decode, encode, read
from obs_ros.interface.checkpoint_writer import CheckpointWriter
from obs_ros.interface.progress import Progress
from obs_ros.interface.status import Level
from obs_ros.observers.base import OBSERVERS

NODE = '/line1/tank_a/estimator'


@dataclass(frozen=True)
class Counted:
    """What the observer here remembers."""

    windows: int


class Counting:
    """An observer that knows how many windows it has seen."""

    def __init__(self, model: Model = LAG, noise: str = '0.1') -> None:
        self.model, self.identity = model, {'noise.y': noise}
        self.windows = 0
        self.writes = 0

    @property
    def memory(self) -> Counted | None:
        return Counted(self.windows) if self.windows else None

    def recall(self, plain: Any) -> None:
        found: Counted = from_plain(Counted, plain, Shapes())
        if found.windows < 1:
            raise ValueError('so few windows are none')
        self.windows = found.windows


def opened(path: Path, **settings: Any) -> Checkpoint:
    return Checkpoint(path, CheckpointWriter(spacing=0.0), **settings)


def kept(path: Path, windows: int = 3, observer: Counting | None = None) -> None:
    """Leave a file of an observer behind."""
    observer, file = observer or Counting(), opened(path)
    observer.windows = windows
    file.keep(observer)
    assert file.account.failed == 0
    assert file._writer.finish(str(path), patience(5.0))
    assert file.close()


def test_without_a_path_nothing_happens() -> None:
    file, observer = Checkpoint(), Counting()
    observer.windows = 3
    assert file.take_up(observer) == []
    file.keep(observer)
    file.forget('reset')
    assert not file.failed()
    assert (file.figures, file.trouble) == ({}, '')
    assert file.close()


def test_what_one_observer_learned_another_one_takes_up(tmp_path: Path) -> None:
    path = tmp_path / 'tank'
    file, observer = opened(path), Counting()
    assert file.take_up(observer) == [
        (Level.OK, f'checkpoint {path}: begun without: there was no file yet')
    ]
    file.keep(observer)  # which knows nothing yet
    for observer.windows in (1, 2):
        file.keep(observer)
    assert file.close()
    assert file.figures['checkpoint.written'] in (1, 2)
    other = Counting()
    again = opened(path)
    assert again.take_up(other) == [(Level.OK, f'checkpoint {path}: taken up')]
    assert other.windows == 2
    assert again.close()


REFUSED = [
    (lambda path: path.write_bytes(b''), 'no valid JSON'),
    (lambda path: path.write_bytes(read(path)[:-10]), 'damaged'),
    (lambda path: path.write_bytes(encode({'memory': {}})), 'not identity and memory'),
    (lambda path: path.write_bytes(encode({'identity': 3, 'memory': 3})), 'identity must be'),
    (lambda path: kept(path, observer=Counting(noise='0.2')), "noise.y was '0.2', and is '0.1'"),
    (lambda path: kept(path, observer=Counting(replace(LAG, name='other'))), 'name was'),
    (lambda path: kept(path, observer=Counting(
        replace(LAG, output=lambda t, x, u, p: (2.0 * x[0],)))), 'the equations are others'),
    (lambda path: changed(path, {'windows': 0}), 'so few windows are none'),
    (lambda path: changed(path, {'windows': 'nan'}), 'windows must be an integer'),
    (lambda path: changed(path, {}), 'must be an object with windows'),
    (lambda path: path.write_bytes(read(path).replace(b'"version": 1', b'"version": 9')),
     'version 9 of the format'),
]  # fmt: skip


def changed(path: Path, memory: Any) -> None:
    """Let the file have another memory, with a digest that is right."""
    path.write_bytes(encode({**decode(read(path)), 'memory': memory}))


@pytest.mark.parametrize(('spoil', 'said'), REFUSED)
def test_what_does_not_fit_is_told_and_kept_aside(spoil: Any, said: str, tmp_path: Path) -> None:
    path = tmp_path / 'tank'
    kept(path)
    spoil(path)
    before = path.read_bytes()
    file, observer = opened(path), Counting()
    ((level, line),) = file.take_up(observer)
    assert level is Level.WARN
    assert f'checkpoint {path}: begun anew: ' in line and said in line
    assert line.endswith(f'; kept as {path}.refused')
    assert observer.windows == 0
    assert Path(f'{path}.refused').read_bytes() == before and not path.exists()
    # The node goes on, and keeps what it learns.
    observer.windows = 1
    file.keep(observer)
    assert file.close()
    assert decode(read(path))['memory'] == {'windows': 1}


def test_an_observer_that_fails_on_a_memory_is_not_the_nodes_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / 'tank'
    kept(path)

    def failing(self: Counting, plain: Any) -> None:
        raise RecursionError('deep')

    monkeypatch.setattr(Counting, 'recall', failing)
    file = opened(path)
    ((level, line),) = file.take_up(Counting())
    assert level is Level.WARN and 'deep' in line
    assert file.close()


def test_a_disk_that_refuses_is_told_and_tried_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, observer, progress = tmp_path / 'tank', Counting(), Progress()
    file = opened(path)
    file.take_up(observer)

    def full(path: Path, data: bytes) -> None:
        raise OSError(28, 'No space left on device')

    with monkeypatch.context() as patched:
        patched.setattr(module, 'write', full)
        for observer.windows in (1, 2):
            file.keep(observer)
            assert file._writer.finish(str(path), patience(5.0))
    file.tell(progress)
    assert progress.checkpoint['checkpoint.failed'] == 2
    assert progress.checkpoint['checkpoint.written'] == 0
    assert 'No space left' in str(progress.checkpoint['checkpoint.error'])
    assert progress.unsaved.startswith(f'look at the disk and rights of {path}: ')
    observer.windows = 3
    file.keep(observer)
    assert file.close()
    file.tell(progress)
    assert progress.unsaved == '' and 'checkpoint.error' not in progress.checkpoint
    assert decode(read(path))['memory'] == {'windows': 3}


def test_keeping_does_not_wait_for_the_disk(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    go, begun = threading.Event(), threading.Event()

    def slow(path: Path, data: bytes) -> None:
        begun.set()
        go.wait(patience(5.0))

    monkeypatch.setattr(module, 'write', slow)
    file, observer = opened(tmp_path / 'tank'), Counting()
    for observer.windows in (1, 2, 3):
        file.keep(observer)
    assert begun.wait(patience(5.0)) and file.account.written == 0
    # Nor does the end of the node, for long; the file stays locked until it is written.
    assert not file.close()
    with pytest.raises(ValueError, match='another node has'):
        opened(tmp_path / 'tank')
    go.set()
    assert file._writer.finish(str(tmp_path / 'tank'), patience(5.0))


def test_a_reset_takes_the_file_away(tmp_path: Path) -> None:
    path = tmp_path / 'tank'
    kept(path)
    file, observer = opened(path), Counting()
    file.take_up(observer)
    file.forget('asked to')
    assert file.close()
    assert not path.exists()
    assert file.told == 'begun anew: asked to'


def test_what_makes_the_first_window_fail_does_not_come_back(tmp_path: Path) -> None:
    path = tmp_path / 'tank'
    kept(path)
    file, observer = opened(path), Counting()
    file.take_up(observer)
    assert file.failed()
    assert not file.failed()  # it was taken up no more
    assert file.close()
    assert not path.exists()
    kept(path)
    file = opened(path)
    file.take_up(observer)
    file.keep(observer)  # a window was solved
    assert not file.failed()
    assert file.close()


def test_a_file_is_for_one_node(tmp_path: Path) -> None:
    path = tmp_path / 'tank'
    first = opened(path)
    with pytest.raises(ValueError, match='give each node a file of its own, or name a folder'):
        opened(path)
    assert first.close()
    assert opened(path).close()


def test_a_folder_that_cannot_be_written_to_does_not_keep_the_node_from_starting(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def denied(path: Path) -> int | None:
        raise PermissionError(13, 'Permission denied')

    monkeypatch.setattr(module, 'lock', denied)
    assert opened(tmp_path / 'tank').close()


def test_the_path_of_a_node(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('HOME', str(tmp_path))
    assert checkpoint_path('', NODE) is None
    assert checkpoint_path(f'{tmp_path}/tank', NODE) == tmp_path / 'tank'
    assert checkpoint_path('~/tank', NODE) == tmp_path / 'tank'
    in_folder = tmp_path / 'line1.tank_a.estimator.checkpoint'
    assert checkpoint_path(str(tmp_path), NODE) == in_folder
    assert checkpoint_path(f'{tmp_path}/', NODE) == in_folder
    (tmp_path / 'link').symlink_to(tmp_path / 'real')
    assert checkpoint_path(f'{tmp_path}/link', NODE) == tmp_path / 'real'


@pytest.mark.parametrize(
    ('given', 'said'),
    [
        ('/nowhere/at/all', "make the folder first: there is no '/nowhere/at'"),
        ('{}/new/', "make the folder first: there is no '{}/new'"),
        ('/dev/null', "name a file or a folder: '/dev/null' is neither"),
        ('{}/' + 'x' * 5000, 'name a file or a folder: '),
        ('a\0b', 'name a file or a folder: '),
    ],
)
def test_paths_that_are_none(given: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match='checkpoint: ') as raised:
        checkpoint_path(given.replace('{}', str(tmp_path)), NODE)
    assert said.replace('{}', str(tmp_path)) in str(raised.value)


def test_only_an_observer_that_remembers_has_one(tmp_path: Path) -> None:
    for name in OBSERVERS:
        values = {'checkpoint': str(tmp_path / name), 'observer': name}
        if name == 'sliding_window':
            assert Checkpoint.of(values, NODE).close()
            continue
        with pytest.raises(ValueError, match='leave checkpoint empty, or take observer sliding'):
            Checkpoint.of(values, NODE)
        assert Checkpoint.of({**values, 'checkpoint': ''}, NODE).close()


def test_a_person_can_look_at_it(tmp_path: Path) -> None:
    kept(tmp_path / 'tank')
    header, body = (json.loads(line) for line in (tmp_path / 'tank').read_text().splitlines())
    assert header['format'] == FORMAT
    assert ['states', 'x'] in body['identity']['words']
    assert ['noise.y', '0.1'] in body['identity']['words']
