"""A process that solves windows with the package of one tree, and tells times and values.

`python tree.py <root>` imports `obs_ros` from that root and these benchmarks from their own. Each
line it reads names an experiment, `rich` or `poor`, `alone` or `in sequence`, and a seed; each line
it writes has the process time in s and the values published, to the last bit.
"""

import json
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

OWN = Path(__file__).resolve().parents[2]
REPEATS = 3  # of a solve, of which the least time counts
WINDOWS = 3  # in sequence; all but the first are warm, and count


class Solved(NamedTuple):
    """The process time (s) of a window, or of warm ones, and the values as text, bit by bit."""

    seconds: float
    values: tuple[str, ...]


class Tree:
    """Solves with the package under `root`, in a process of its own."""

    def __init__(self, root: Path, process: 'subprocess.Popen[str]') -> None:
        self.root = root
        self._process = process

    def solved(self, name: str, rich: bool, sequence: bool, seed: int) -> Solved:
        """Solve a window, or some in sequence; raises RuntimeError where the process has ended."""
        question, answer = self._process.stdin, self._process.stdout
        if question is None or answer is None:
            raise RuntimeError(f'{self.root}: the process has no pipes')
        print(json.dumps([name, rich, sequence, seed]), file=question, flush=True)
        line = answer.readline()
        if not line:
            raise RuntimeError(f'{self.root}: the process ended')
        seconds, values = json.loads(line)
        return Solved(seconds, tuple(values))


@contextmanager
def tree(root: Path) -> Iterator[Tree]:
    """Start the process of a tree, and end it."""
    command = [sys.executable, str(Path(__file__).resolve()), str(root)]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        yield Tree(root, process)
        if process.stdin is not None:
            process.stdin.close()


def main(root: str) -> None:
    """Answer line by line, until there is no further one."""
    sys.path[:1] = [root]
    import obs_ros

    if not Path(obs_ros.__file__).is_relative_to(Path(root).resolve()):
        raise SystemExit(f'{root} has no package obs_ros')
    sys.path[0] = str(OWN)
    from benchmarks.coverage.run import timed_values

    for line in sys.stdin:
        name, rich, sequence, seed = json.loads(line)
        windows = WINDOWS if sequence else 1
        found = [timed_values(name, rich, seed, windows) for _ in range(REPEATS)]
        print(json.dumps([min(one[0] for one in found), found[0][1]]), flush=True)


if __name__ == '__main__':
    main(sys.argv[1])
