"""Hashes of all that the result of a run depends on."""

import hashlib
import importlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from obs_ros.core.fingerprint import fingerprint
from obs_ros.core.model import Model
from obs_ros.observers.base import load_observer
from obs_ros.replay.recording import Source, check_file
from obs_ros.replay.settings import Setup
from obs_ros.studies.versions import versions

BLOCK = 1 << 20  # bytes that are read at once


def key(digest: str, source: Source, setup: Setup, deadline: bool) -> str:
    """Return the name of a result: a hash of recording, model, observer, settings and versions.

    `digest` is that of the recording, see `content`; its place counts for nothing.
    """
    told: Mapping[str, Any] = {
        'recording': digest,
        'read': [source.columns, source.period, source.topics, source.node],
        'model': described(setup.model),
        'observer': _code(str(setup.values['observer'])),
        'parameters': setup.values,
        'signals': {name: repr(binding) for name, binding in setup.bound.items()},
        'deadline': deadline,
        'versions': versions(),
    }
    return hashlib.sha256(json.dumps(told, sort_keys=True, default=dict).encode()).hexdigest()


def content(path: Path) -> str:
    """Return a hash of a file's content, or of all files of a folder by their names.

    Raises OSError where it cannot be read, ValueError for a pipe or a device.
    """
    check_file(path)
    digest = hashlib.sha256()
    inside = sorted(each for each in path.rglob('*') if each.is_file()) if path.is_dir() else [path]
    for each in inside:
        if path.is_dir():
            digest.update(f'{each.relative_to(path)} {each.stat().st_size} '.encode())
        with each.open('rb') as file:
            while block := file.read(BLOCK):
                digest.update(block)
    return digest.hexdigest()


def described(model: Model) -> str:
    """Return a hash of a model: its variables, and its functions with all that they use."""
    fields = {name: value for name, value in vars(model).items() if not callable(value)}
    return fingerprint(repr(sorted(fields.items())), model.dynamics, model.output)


def _code(observer: str) -> str:
    """Return a hash of the file in which an observer's class stands."""
    module = importlib.import_module(load_observer(observer).__module__)
    file = getattr(module, '__file__', None)
    return content(Path(file)) if file else module.__name__
