"""Progress of many runs: a bar on a terminal, lines now and then elsewhere."""

import sys
import time
from collections.abc import Iterable, Iterator
from typing import TextIO, TypeVar

from obs_ros.core.texts import LONGEST_NAME, one_line

Item = TypeVar('Item')

BAR, LINE = 20, 78  # characters of the bar, and of the whole line
REFRESH = 0.2  # s from one drawing of the bar to the next
LINE_EVERY = 10.0  # s from one line to the next, where there is no terminal


class Progress:
    """Tells how many of `total` runs are done, how many in a second, and the time that is left.

    A terminal gets a bar that replaces itself. Another `stream` gets lines where they are wanted
    (`lines`), and nothing else.
    """

    def __init__(
        self, label: str, total: int, stream: TextIO | None = None, *, lines: bool = False
    ) -> None:
        self._label, self._total = one_line(label, LONGEST_NAME), total
        self._stream = sys.stderr if stream is None else stream
        self._bar = self._stream.isatty()
        self._every = REFRESH if self._bar else LINE_EVERY if lines else float('inf')
        self._begin = self._told = time.monotonic()
        self._lines, self._drawn = lines, False
        self.done = 0

    def step(self) -> None:
        """Count one run more, and tell if it is time to."""
        self.done += 1
        now = time.monotonic()
        last = self.done == self._total and (self._bar or self._lines)
        if last or now >= self._told + self._every:
            self._told = now
            text = self.text(now - self._begin)
            self._drawn = self._bar and not last
            begin, end = ('\r', '\n' if last else '') if self._bar else ('', '\n')
            print(f'{begin}{text:<{LINE}}'.rstrip(' ' if not self._bar else ''), end=end,
                  file=self._stream, flush=True)  # fmt: skip

    def say(self, line: str) -> None:
        """Print a line of its own, in the place of the bar, which comes again below it."""
        begin = '\r' if self._drawn else ''
        print(f'{begin}{line:<{LINE}}'.rstrip(), file=self._stream, flush=True)
        self._drawn = False

    def leave(self) -> None:
        """End the line of a bar that does not reach its end."""
        if self._drawn:
            print(file=self._stream, flush=True)
            self._drawn = False

    def text(self, spent: float) -> str:
        """Return the line after so many s."""
        done, total = self.done, self._total
        rate = done / spent if spent > 0.0 else float('inf')
        filled = round(BAR * done / max(total, 1))
        bar = f' [{"#" * filled}{"." * (BAR - filled)}]' if self._bar else ''
        left = 'done' if done == total else f'{duration((total - done) / rate)} to go'
        speed = f'{rate:.3g}/s' if rate >= 1.0 else f'{60.0 * rate:.3g}/min'
        return f'{self._label}: {done}/{total}{bar}, {speed}, {left}'


def duration(seconds: float) -> str:
    """Return a time as people say it: 45 s, 12 min, 3 h 20 min."""
    if seconds < 100.0:
        return f'{seconds:.0f} s'
    minutes = round(seconds / 60.0)
    return f'{minutes} min' if minutes < 100 else f'{minutes // 60} h {minutes % 60} min'


def progress(items: Iterable[Item], label: str, total: int) -> Iterator[Item]:
    """Hand the items on, and tell a terminal how many are done and the time that is left."""
    shown = Progress(label, total)
    try:
        for item in items:
            yield item
            shown.step()
    finally:
        shown.leave()
