"""Processes that measure with the package of another source tree, called one at a time."""

import functools
import os
import pickle
import subprocess
import sys
import tempfile
import traceback
from collections.abc import Callable
from multiprocessing.util import Finalize
from pathlib import Path
from typing import Any

from benchmarks.runner import ROOT

PACKAGE = 'obs_ros'


class Tree:
    """A process whose `obs_ros` is that of the tree at `path`; the benchmarks are these.

    Raises FileNotFoundError where there is none, and RuntimeError for a call that fails there.
    """

    def __init__(self, path: Path) -> None:
        package = path.resolve() / PACKAGE
        if not package.is_dir():
            raise FileNotFoundError(f'give a source tree: {path} has no {PACKAGE}')
        # A folder with nothing but the package, as the tree has benchmarks of its own.
        self._folder = tempfile.TemporaryDirectory()
        Path(self._folder.name, PACKAGE).symlink_to(package)
        paths = f'{self._folder.name}{os.pathsep}{ROOT}'
        self._process = subprocess.Popen(
            [sys.executable, '-P', '-m', __name__],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            cwd=ROOT,
            env={**os.environ, 'PYTHONPATH': paths, 'OPENBLAS_NUM_THREADS': '1'},
        )

    def __enter__(self) -> 'Tree':
        return self

    def __exit__(self, *_: object) -> None:
        with self._process:  # closes its pipes, which ends it
            pass
        self._folder.cleanup()

    def call(self, function: Callable[..., Any], *arguments: Any) -> Any:
        """Return the result of a module's function, computed there."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        pickle.dump((function, arguments), self._process.stdin)
        self._process.stdin.flush()
        error, result = pickle.load(self._process.stdout)
        if error:
            raise RuntimeError(error)
        return result


def called_in(path: Path, work: Callable[..., Any], *arguments: Any) -> Any:
    """Return the result of a call by the package of the tree at `path`; one process for all."""
    return _opened(path).call(work, *arguments)


@functools.cache
def _opened(path: Path) -> Tree:
    tree = Tree(path)
    Finalize(None, tree.__exit__, exitpriority=0)  # also where this is a worker
    return tree


def serve() -> None:
    """Answer the calls that come in, until there are no more."""
    calls, answers = sys.stdin.buffer, sys.stdout.buffer
    sys.stdout = sys.stderr  # what else is printed is no answer
    while True:
        try:
            function, arguments = pickle.load(calls)
        except EOFError:
            return
        try:
            answer = ('', function(*arguments))
        except Exception:
            answer = (traceback.format_exc(), None)
        pickle.dump(answer, answers)
        answers.flush()


if __name__ == '__main__':
    serve()
