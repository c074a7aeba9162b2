"""Results on disk, by the hash of all that they depend on: no run is done twice."""

import hashlib
from pathlib import Path

from obs_ros.core.kernel_cache import DIGEST, write

SUFFIX = '.result'


class Store:
    """Results in a folder, a file for each; one is there whole, or not at all.

    A file that was damaged, or is no result, counts as missing.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def get(self, key: str) -> bytes | None:
        """Return the result of that key; None where there is none."""
        try:
            content = self._path(key).read_bytes()
        except FileNotFoundError:
            return None
        digest, result = content[:DIGEST], content[DIGEST:]
        return result if hashlib.sha256(result).digest() == digest else None

    def put(self, key: str, result: bytes) -> None:
        """Store a result; raises OSError where that is impossible."""
        write(self._path(key), hashlib.sha256(result).digest() + result)

    def forget(self) -> None:
        """Delete all results."""
        for path in self.folder.glob(f'*{SUFFIX}'):
            path.unlink()

    def _path(self, key: str) -> Path:
        return self.folder / f'{key}{SUFFIX}'
