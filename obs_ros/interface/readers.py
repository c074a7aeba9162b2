"""Vectors out of messages, whoever decoded them: ROS, or a reader of recordings. Knows no ROS."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

import numpy as np

from obs_ros.core.registry import meant
from obs_ros.core.texts import quoted
from obs_ros.core.typing import Array
from obs_ros.interface.bindings import HEADER, Binding
from obs_ros.interface.field_path import MessageError

NAMED_VECTOR = 'sensor_msgs/msg/JointState'


class Reader(Protocol):
    """Makes a stamp and a vector out of a message of the type called `type`.

    `whole` says that each message brings all of the `places`; `others` counts those that brought
    further names, which nobody wants.
    """

    type: str
    whole: bool
    others: int

    @property
    def places(self) -> Sequence[int]:
        """The entries of the vector that messages may bring."""

    def read(self, message: Any, arrival: int) -> tuple[int, Array]:
        """Return stamp (ns) and values; raises MessageError when they are not there.

        `arrival` (ns) is the stamp where the message brings none.
        """


def nanoseconds(stamp: Any) -> int:
    """Return a message's stamp in ns."""
    return int(stamp.sec * 1_000_000_000 + stamp.nanosec)


class VectorReader:
    """Reads the entries `names` out of named vectors, in any order and among any others.

    They go to the `places`, which rise, of a vector (width,), whose other entries are NaN; by
    default they are the whole vector. `others` counts the messages that had further names.
    """

    type = NAMED_VECTOR
    whole = True

    def __init__(
        self, names: Sequence[str], places: Sequence[int] | None = None, width: int | None = None
    ) -> None:
        self.places = range(len(names)) if places is None else places
        self._names = list(names)
        self._width = len(names) if width is None else width
        self._last: list[str] | None = None  # names of the last message whose order was sought,
        self._order: list[int] = []  # and where they have those wanted
        self.others = 0

    def read(self, message: Any, arrival: int) -> tuple[int, Array]:
        """Return stamp (ns) and values (width,).

        Raises MessageError, its reason one of `wrong_length`, `missing_name`.
        """
        stamp = nanoseconds(message.header.stamp)
        names = message.name
        if len(names) != len(message.position):
            raise MessageError(
                'wrong_length', f'{len(names)} names but {len(message.position)} positions'
            )
        values = np.array(message.position)
        if names != self._names:
            if names != self._last:
                self._order, self._last = self._found(names), list(names)
            self.others += len(names) > len(self._names)
            values = values[self._order]
        if len(values) == self._width:
            return stamp, values
        vector = np.full(self._width, np.nan)
        vector[self.places] = values
        return stamp, vector

    def _found(self, names: Sequence[str]) -> list[int]:
        """Return the places of the wanted names among those of a message."""
        places: dict[str, int] = {}
        for place, name in enumerate(names):
            if places.setdefault(name, place) != place and name in self._names:
                raise MessageError('wrong_length', f'{quoted(name)} stands twice')
        for name in self._names:
            if name not in places:
                hint = meant(name, [other for other in places if other not in self._names])
                text = (
                    f'{quoted(name)} is missing: {hint}' if hint else f'{quoted(name)} is missing'
                )
                raise MessageError('missing_name', text)
        return [places[name] for name in self._names]


class FieldReader:
    """Reads the bound entries of a vector (width,) out of one kind of message, the others NaN.

    A message may lack some of them, as those of robots whose joints report by turns; one that has
    none of them raises the MessageError of the first.
    """

    def __init__(self, bound: Mapping[int, Binding], width: int) -> None:
        first = next(iter(bound.values()))
        self.type = first.type
        self.others = 0
        self.places = list(bound)
        self.whole = len(bound) == 1
        self._by_header = first.stamp == HEADER
        self._bound = dict(bound)
        self._width = width

    def read(self, message: Any, arrival: int) -> tuple[int, Array]:
        """Return stamp (ns) and values (width,)."""
        stamp = nanoseconds(message.header.stamp) if self._by_header else arrival
        values = np.full(self._width, np.nan)
        errors: list[MessageError] = []
        for place, binding in self._bound.items():
            try:
                values[place] = binding.scale * binding.path.read(message) + binding.offset
            except MessageError as error:
                errors.append(error)
        if len(errors) == len(self._bound):
            raise errors[0]
        return stamp, values


def topic_readers(
    entries: Sequence[str],
    bound: Mapping[str, Binding],
    default: str,
    resolve: Callable[[str], str],
) -> list[tuple[str, Reader]]:
    """Return the topics that bring the entries of a vector, with a reader for each.

    Entries with a binding come from there, the others by name from the topic `default`, which
    stands last. `resolve` makes full names of topics.
    """
    width = len(entries)
    by_topic: dict[str, dict[int, Binding]] = {}
    for i, name in enumerate(entries):
        if name in bound:
            by_topic.setdefault(resolve(bound[name].topic), {})[i] = bound[name]
    readers: list[tuple[str, Reader]] = [
        (topic, FieldReader(those, width)) for topic, those in by_topic.items()
    ]
    named = {i: name for i, name in enumerate(entries) if name not in bound}
    if named:
        readers.append((default, VectorReader(list(named.values()), list(named), width)))
    return readers
