"""Jumps that were announced, beside the true ones."""

from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass

from obs_ros.core.estimate import probability_words

LIMIT = 1.0  # s by which a time may be off: a sample period


@dataclass(frozen=True)
class Announced:
    """Parameters that jumped together: sizes and their standard deviations, by name.

    `probability` is that this set of parameters jumped.
    """

    sizes: Mapping[str, float]
    deviations: Mapping[str, float]
    probability: float

    def __str__(self) -> str:
        """Say by how much, with two standard deviations, and how probably."""
        sizes = ', '.join(
            f'{name} by {size:+.4f} ± {2.0 * self.deviations[name]:.4f}'
            for name, size in self.sizes.items()
        )
        probable = probability_words(self.probability)
        return f'{sizes}, {probable}' if probable else sizes

    def joined(self, other: 'Announced') -> 'Announced':
        """Return both as one, which is as probable as the less probable of them."""
        return Announced(
            {**self.sizes, **other.sizes},
            {**self.deviations, **other.deviations},
            min(self.probability, other.probability),
        )


Found = Sequence[tuple[float, Announced]]  # time in s


def noted(announced: dict[int, Announced], stamp: int, new: Announced) -> None:
    """Note what is announced for a stamp (ns): sizes of 0 take back what was announced for it."""
    known = announced.pop(stamp, None)
    if any(new.sizes.values()):
        announced[stamp] = new if known is None else known.joined(new)
    elif known is not None and (left := {*known.sizes} - {*new.sizes}):
        sizes, deviations = (
            {name: values[name] for name in values if name in left}
            for values in (known.sizes, known.deviations)
        )
        announced[stamp] = Announced(sizes, deviations, known.probability)


def merged(announced: Mapping[int, Announced]) -> Found:
    """Return jumps announced by stamp (ns), in order, the pieces of one put together.

    A window may show one parameter of a jump and a later one another, each with its own idea of the
    time: pieces that need no more than LIMIT to meet are one, at the time of the first.
    """
    found: list[tuple[float, Announced]] = []
    for stamp, piece in sorted(announced.items()):
        time = stamp / 1e9
        if found and time - found[-1][0] <= 2.0 * LIMIT:
            found[-1] = found[-1][0], found[-1][1].joined(piece)
        else:
            found.append((time, piece))
    return found


def found_as_true(found: Found, true: Mapping[float, Set[str]]) -> bool:
    """Return whether just the `true` jumps were found: their times (s) and their parameters."""
    return len(found) == len(true) and all(
        abs(time - moment) <= LIMIT and set(jump.sizes) == set(names)
        for (time, jump), (moment, names) in zip(found, sorted(true.items()), strict=True)
    )
