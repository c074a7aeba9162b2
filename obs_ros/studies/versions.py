"""Versions on which the bits of a result depend, compared between processes."""

import functools
import hashlib
import os
import platform
from collections.abc import Mapping
from importlib import metadata
from pathlib import Path

SOURCES = Path(__file__).parents[1]
PACKAGES = ('numpy', 'scipy', 'numba')
LENGTH = 12  # hexadecimal digits of the sources' hash: an accident in 10^14


@functools.cache
def versions() -> Mapping[str, str]:
    """Return the versions of this process by name: obs_ros, by its sources, Python, packages.

    Python counts without its last number, which mends only errors. The back end is one of them:
    compiled code and NumPy differ in the last bits.
    """
    return {
        'obs_ros': sources(SOURCES),
        'python': '.'.join(platform.python_version_tuple()[:2]),
        **{package: _version(package) for package in PACKAGES},
        'OBS_ROS_BACKEND': os.environ.get('OBS_ROS_BACKEND', ''),
    }


def sources(folder: Path) -> str:
    """Return a short hash of all Python files below a folder, by their places in it."""
    digest = hashlib.sha256()
    for path in sorted(folder.rglob('*.py')):
        content = path.read_bytes()
        digest.update(f'{path.relative_to(folder)} {len(content)} '.encode() + content)
    return digest.hexdigest()[:LENGTH]


def differences(here: Mapping[str, str], there: Mapping[str, str]) -> str:
    """Say which versions differ, `there` being a worker's; empty where none does."""
    return ', '.join(
        f'{name} {there.get(name) or "none"} there, {here.get(name) or "none"} here'
        for name in sorted({*here, *there})
        if here.get(name) != there.get(name)
    )


def _version(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return ''
