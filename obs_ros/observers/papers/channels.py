"""Functions of tuples, entry by entry, that also compile: a loop over a tuple would not."""

from collections.abc import Callable, Sequence
from typing import Any

# A rate of one flow's channel, from its T, F, f, g, error and feed, and the observer's settings.
Channel = Callable[[Any, Any, Any, Any, Any, Any, Any], Any]


def each(channels: Sequence[Channel]) -> Callable[..., tuple[Any, ...]]:
    """Return a function of six tuples and the settings: channel i of their entries i, for all i."""
    channel, k = channels[-1], len(channels) - 1
    if not k:
        return lambda a, b, c, d, e, f, s: (channel(a[k], b[k], c[k], d[k], e[k], f[k], s),)
    before = each(channels[:-1])

    def rates(a: Any, b: Any, c: Any, d: Any, e: Any, f: Any, s: Any) -> tuple[Any, ...]:
        last = channel(a[k], b[k], c[k], d[k], e[k], f[k], s)
        return before(a, b, c, d, e, f, s) + (last,)  # noqa: RUF005

    return rates


def products(index: Sequence[int]) -> Callable[[Any, Any], tuple[Any, ...]]:
    """Return a function of two tuples: entry k of the first times entry index[k] of the second."""
    k, i = len(index) - 1, index[-1]
    if not k:
        return lambda a, b: (a[k] * b[i],)
    before = products(index[:-1])
    return lambda a, b: before(a, b) + (a[k] * b[i],)  # noqa: RUF005
