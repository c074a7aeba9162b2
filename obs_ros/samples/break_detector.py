"""Telling a stray stamp from a long gap or a new timeline: a restart, a looping recording."""

from obs_ros.core.typing import Array


class Suspects:
    """Samples of one stream that came one after the other, off the timeline, with rising stamps.

    All of them are not newer than the newest sample of their stream, or all are far ahead of it.
    As many as `believed` are no strays. Those whose stamps do not rise among themselves are: their
    publisher always stamps zero.
    """

    def __init__(self, believed: int) -> None:
        self._enough = believed
        self._samples: list[tuple[int, Array]] = []
        self._ahead = 0

    def __len__(self) -> int:
        return len(self._samples)

    @property
    def believed(self) -> bool:
        """Whether these are no strays."""
        return len(self._samples) >= self._enough

    def add(self, stamp: int, values: Array, *, ahead: bool) -> int:
        """Hold a sample; return how many held ones, far ahead of all, thereby prove strays."""
        fits = self._samples and stamp > self._samples[-1][0] and ahead == bool(self._ahead)
        strays = 0 if fits else self.clear()
        self._samples.append((stamp, values))
        self._ahead += ahead
        return strays

    def clear(self) -> int:
        """Forget the samples; return how many of them were far ahead."""
        strays, self._ahead = self._ahead, 0
        self._samples.clear()
        return strays

    def release(self) -> list[tuple[int, Array]]:
        """Return stamps and values of all held samples, and hold none."""
        samples, self._samples = self._samples, []
        self._ahead = 0
        return samples


def describe_break(stream: str, newest: int, stamp: int) -> str:
    """Say that the stamps of `stream` went from `newest` to `stamp` (ns)."""
    way = 'back' if stamp <= newest else 'ahead'
    before, now = (round(ns * 1e-9, 3) for ns in (newest, stamp))
    return f'{stream} stamps jumped {way} from {before} s to {now} s: all samples forgotten'
