"""Tests of obs_ros.interface.checkpoint_file."""

import hashlib
import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from obs_ros.interface import checkpoint_file
from obs_ros.interface.checkpoint_file import (
    MOST_BYTES,
    decode,
    encode,
    lock,
    read,
    remove,
    set_aside,
    write,
)

OLD, NEW = ({'memory': {'window': k, 'values': [0.1, 1e-300, -0.0]}} for k in (1, 2))


class Killed(BaseException):
    """The process ends here."""


def test_the_content_comes_back(tmp_path: Path) -> None:
    path = tmp_path / 'tank'
    write(path, encode(OLD))
    assert decode(read(path)) == OLD
    write(path, encode(NEW))
    assert decode(read(path)) == NEW
    assert [each.name for each in tmp_path.iterdir()] == ['tank']
    first = path.read_text().splitlines()[0]
    assert json.loads(first)['format'] == 'obs_ros checkpoint'


STEPS = ('open', 'fdopen', 'write', 'half', 'fsync', 'replace', 'fsync of the folder')


def stopped(step: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the process end before one of the steps of a write, or in the middle of the bytes."""
    real: dict[str, Callable[..., Any]] = {
        name: getattr(os, name) for name in ('open', 'fdopen', 'fsync', 'replace')
    }
    calls = dict.fromkeys(real, 0)

    def wrapped(name: str) -> Callable[..., Any]:
        def call(*args: Any, **options: Any) -> Any:
            calls[name] += 1
            if step == name or (
                step == 'fsync of the folder' and name == 'fsync' and calls[name] == 2
            ):
                raise Killed
            made = real[name](*args, **options)
            if name == 'fdopen' and step in ('write', 'half'):
                return Dying(made)
            return made

        return call

    class Dying:
        def __init__(self, file: Any) -> None:
            self.file = file

        def __enter__(self) -> 'Dying':
            return self

        def __exit__(self, *_: object) -> None:
            self.file.close()

        def write(self, data: bytes) -> None:
            self.file.write(data[: len(data) // 2 if step == 'half' else 0])
            self.file.flush()
            raise Killed

    for name in real:
        monkeypatch.setattr(checkpoint_file.os, name, wrapped(name))


@pytest.mark.parametrize('step', STEPS)
@pytest.mark.parametrize('before', [None, OLD])
def test_whenever_a_write_is_stopped_the_file_is_whole(
    step: str, before: dict[str, Any] | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / 'tank'
    if before is not None:
        write(path, encode(before))
    with monkeypatch.context() as patched:
        stopped(step, patched)
        with pytest.raises(Killed):
            write(path, encode(NEW))
    expected = NEW if step == 'fsync of the folder' else before
    assert path.exists() == (expected is not None)
    if expected is not None:
        assert decode(read(path)) == expected
    # What is left of the one that was stopped is in nobody's way.
    write(path, encode(NEW))
    assert decode(read(path)) == NEW
    assert [each.name for each in tmp_path.iterdir()] == ['tank']


def test_the_bytes_are_on_the_disk_before_the_name_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    steps: list[str] = []

    def noted(name: str, real: Callable[..., Any]) -> Callable[..., Any]:
        def call(*args: Any) -> Any:
            if name == 'fsync':
                kind = 'folder' if os.path.isdir(f'/proc/self/fd/{args[0]}') else 'file'
                size = os.fstat(args[0]).st_size if kind == 'file' else 0
                assert kind == 'folder' or size == len(encode(NEW))
                steps.append(f'fsync {kind}')
            else:
                steps.append(name)
            return real(*args)

        return call

    for name in ('fsync', 'replace'):
        monkeypatch.setattr(checkpoint_file.os, name, noted(name, getattr(os, name)))
    write(tmp_path / 'tank', encode(NEW))
    assert steps == ['fsync file', 'replace', 'fsync folder']


def header(**changes: Any) -> bytes:
    first, _, body = encode(OLD).partition(b'\n')
    return json.dumps({**json.loads(first), **changes}).encode() + b'\n' + body


@pytest.mark.parametrize(
    ('data', 'said'),
    [
        (b'', 'no checkpoint, or damaged|no valid JSON'),
        (b'\x00' * 500, 'no valid JSON'),
        (b'\xff\xfe', 'no valid JSON'),
        (b'[' * 100_000, 'no checkpoint, or damaged'),
        (b'[' * 900, 'no valid JSON'),
        (b'{"format": "other"}\n{}', 'no checkpoint, or damaged'),
        (b'a: 1\nb: 2\n', 'no valid JSON'),
        (encode(OLD)[:-1], r'damaged: \d+ bytes follow the first line'),
        (encode(OLD)[:160], r'damaged: \d+ bytes follow'),
        (encode(OLD) + b'\n', r'damaged: \d+ bytes follow'),
        (encode(OLD).replace(b'-0.0', b'-0.1'), 'damaged: its SHA-256'),
        (header(version=2), 'version 2 of the format, not 1: another version of obs_ros'),
        (header(version=None), 'version None of the format'),
        (header(bytes='x'), 'damaged'),
        (header(sha256=0), 'SHA-256'),
    ],
)  # fmt: skip
def test_what_is_no_checkpoint_is_refused(data: bytes, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        decode(data)


@pytest.mark.parametrize('body', [b'[1]', b'NaN', b'{"a": Infinity}', b'[' * 10_000, b'9' * 5000])
def test_a_content_that_is_none_is_refused_though_its_digest_is_right(body: bytes) -> None:
    data = header(bytes=len(body), sha256=hashlib.sha256(body).hexdigest()).partition(b'\n')[0]
    with pytest.raises(ValueError, match=r'no valid JSON|no object'):
        decode(data + b'\n' + body)


def test_any_byte_that_changes_is_noticed() -> None:
    whole = encode(OLD)
    for place in range(0, len(whole), 7):
        damaged = bytearray(whole)
        damaged[place] ^= 0x10
        try:
            assert decode(bytes(damaged)) == OLD  # as a blank in the header
        except ValueError:
            continue


def test_what_is_too_large_is_neither_written_nor_read(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match='take a shorter window'):
        encode({'memory': 'x' * MOST_BYTES})
    path = tmp_path / 'huge'
    with path.open('wb') as file:
        file.truncate(100 * MOST_BYTES)  # takes no space
    with pytest.raises(ValueError, match='more than 16777216 bytes'):
        read(path)


def test_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / 'pipe')
    with pytest.raises(ValueError, match='no regular file'):
        read(tmp_path / 'pipe')
    with pytest.raises(OSError, match='no regular file'):
        set_aside(tmp_path / 'pipe')
    with pytest.raises(ValueError, match='no regular file'):
        read(Path('/dev/zero'))


def test_no_link_is_followed_when_a_file_is_written(tmp_path: Path) -> None:
    precious = tmp_path / 'precious'
    precious.write_text('mine')
    (tmp_path / 'tank.part').symlink_to(precious)
    with pytest.raises(OSError, match='symbolic'):
        write(tmp_path / 'tank', encode(NEW))
    assert precious.read_text() == 'mine'


def test_it_is_taken_away_and_set_aside(tmp_path: Path) -> None:
    path = tmp_path / 'tank'
    remove(path)
    write(path, encode(OLD))
    assert set_aside(path) == tmp_path / 'tank.refused'
    assert decode(read(tmp_path / 'tank.refused')) == OLD and not path.exists()
    write(path, encode(OLD))
    remove(path)
    assert not path.exists()


def test_one_node_has_a_file(tmp_path: Path) -> None:
    first = lock(tmp_path / 'tank')
    assert first is not None
    with pytest.raises(BlockingIOError):
        lock(tmp_path / 'tank')
    other = lock(tmp_path / 'other')
    os.close(first)
    again = lock(tmp_path / 'tank')
    assert again is not None and other is not None
    os.close(again)
    os.close(other)
