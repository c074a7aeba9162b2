"""A checkpoint file: plain data that is whole at any moment, whoever ends the process.

Its first line is a header in JSON, with the version of the format, length and SHA-256 of the second
line, the content in JSON. JSON because a reader of it can only build numbers, texts and lists, and
because a person can look at it; the numbers come back with the same bits, see `core/plain_data`.

A new file is written beside the old one, flushed to the disk, and takes its name in one step
(rename(2)): what a reader finds is the old or the new one, never a part. The folder is flushed
too, so that the new name survives a power failure.
"""

import errno
import fcntl
import hashlib
import json
import os
import stat
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from obs_ros.core.texts import one_line, quoted

FORMAT, VERSION = 'obs_ros checkpoint', 1
MOST_BYTES = 16 * 2**20  # a window of 20000 nodes and 10 states has 2 MB
LONGEST_HEADER = 1000  # bytes
NO_LINK = os.O_CLOEXEC | os.O_NOFOLLOW  # in a folder of others a link could lead anywhere


def encode(content: Mapping[str, Any]) -> bytes:
    """Return the bytes of a file; raises ValueError where they are too many to be read again."""
    body = json.dumps(content, allow_nan=False, separators=(',', ':')).encode() + b'\n'
    header = {
        'format': FORMAT, 'version': VERSION, 'bytes': len(body),
        'sha256': hashlib.sha256(body).hexdigest(),
    }  # fmt: skip
    data = json.dumps(header).encode() + b'\n' + body
    if len(data) > MOST_BYTES:
        raise ValueError(f'take a shorter window: {len(data)} bytes are more than {MOST_BYTES}')
    return data


def decode(data: bytes) -> dict[str, Any]:
    """Return the content of a file; raises ValueError, with the reason, for what is none."""
    first, _, body = data.partition(b'\n')
    header = _parsed(first) if len(first) <= LONGEST_HEADER else None
    if not isinstance(header, dict) or header.get('format') != FORMAT:
        raise ValueError('it is no checkpoint, or damaged in its first line')
    if header.get('version') != VERSION:
        raise ValueError(
            f'it has version {quoted(header.get("version"))} of the format, not {VERSION}: another '
            'version of obs_ros wrote it'
        )
    if header.get('bytes') != len(body):
        raise ValueError(
            f'it is damaged: {len(body)} bytes follow the first line, not {header.get("bytes")!r}'
        )
    if header.get('sha256') != hashlib.sha256(body).hexdigest():
        raise ValueError('it is damaged: its SHA-256 is another')
    content = _parsed(body)
    if not isinstance(content, dict):
        raise ValueError('its content is no object')
    return content


def _parsed(text: bytes) -> Any:
    """Return what the JSON says; raises ValueError for anything else."""
    try:
        return json.loads(text, parse_constant=_refuse)
    except (ValueError, RecursionError) as error:
        raise ValueError(f'it is no valid JSON: {one_line(error, LONGEST_HEADER)}') from error


def _refuse(word: str) -> None:
    raise ValueError(f'{word} is no number of JSON')


def read(path: Path) -> bytes:
    """Return the bytes of a file.

    Raises ValueError for what is no file or too large, OSError where it cannot be read.
    """
    # A pipe would be waited for.
    with os.fdopen(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), 'rb') as file:
        status = os.fstat(file.fileno())
        if not stat.S_ISREG(status.st_mode):
            raise ValueError('it is no regular file')
        data = file.read(MOST_BYTES + 1)
    if len(data) > MOST_BYTES:
        raise ValueError(f'it has more than {MOST_BYTES} bytes')
    return data


def write(path: Path, data: bytes) -> None:
    """Put these bytes in place of the file, in one step; raises OSError."""
    part = beside(path, 'part')
    flags = os.O_WRONLY | os.O_CREAT | os.O_TRUNC | NO_LINK
    with os.fdopen(os.open(part, flags, 0o666), 'wb') as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
    os.replace(part, path)
    _flush_folder(path.parent)


def remove(path: Path) -> None:
    """Take the file away, if there is one; raises OSError."""
    path.unlink(missing_ok=True)
    _flush_folder(path.parent)


def set_aside(path: Path) -> Path:
    """Give a file that cannot be used another name, and return it; raises OSError."""
    if not stat.S_ISREG(path.lstat().st_mode):
        raise OSError(errno.EINVAL, 'no regular file')
    aside = beside(path, 'refused')
    os.replace(path, aside)
    return aside


def lock(path: Path) -> int | None:
    """Return the descriptor of a lock that ends with the process; None where there are no locks.

    Raises BlockingIOError where another node has it, OSError where its file cannot be made.
    """
    handle = os.open(beside(path, 'lock'), os.O_RDWR | os.O_CREAT | NO_LINK, 0o666)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(handle)
        raise
    except OSError:  # some network file systems have none
        os.close(handle)
        return None
    return handle


def beside(path: Path, what: str) -> Path:
    """Return the path of a file that belongs to a checkpoint, in its folder."""
    return path.with_name(f'{path.name}.{what}')


def _flush_folder(folder: Path) -> None:
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        os.fsync(handle)
    except OSError as error:
        if error.errno not in (errno.EINVAL, errno.ENOTSUP):  # not for folders, on some disks
            raise
    finally:
        os.close(handle)
