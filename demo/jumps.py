"""Jumps that were announced, beside the true ones."""

from collections.abc import Mapping, Sequence, Set

LIMIT = 1.0  # s by which a time may be off: a sample period

Found = Sequence[tuple[float, Mapping[str, float]]]  # time in s, sizes by parameter


def merged(announced: Mapping[int, Mapping[str, float]]) -> Found:
    """Return jumps announced by stamp (ns), in order, the pieces of one put together.

    A window may show one parameter of a jump and a later one another, each with its own idea of the
    time: pieces that need no more than LIMIT to meet are one, at the time of the first.
    """
    found: list[tuple[float, dict[str, float]]] = []
    for stamp, sizes in sorted(announced.items()):
        time = stamp / 1e9
        if found and time - found[-1][0] <= 2.0 * LIMIT:
            found[-1][1].update(sizes)
        else:
            found.append((time, dict(sizes)))
    return found


def found_as_true(found: Found, true: Mapping[float, Set[str]]) -> bool:
    """Return whether just the `true` jumps were found: their times (s) and their parameters."""
    return len(found) == len(true) and all(
        abs(time - moment) <= LIMIT and set(sizes) == set(names)
        for (time, sizes), (moment, names) in zip(found, sorted(true.items()), strict=True)
    )
