"""Vectors out of messages, whoever decoded them: ROS, or a reader of recordings. Knows no ROS."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

import numpy as np

from obs_ros.core.registry import suggest
from obs_ros.core.texts import quoted
from obs_ros.core.typing import Array
from obs_ros.interface.bindings import HEADER, Binding
from obs_ros.interface.field_path import MessageError

NAMED_VECTOR = 'sensor_msgs/msg/JointState'


class Reader(Protocol):
    """Makes a stamp and a vector out of a message of the type called `type`.

    `whole` says that each message brings all of the `places`.
    """

    type: str
    whole: bool

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
    """Reads vectors with the entries `names` out of messages that may have them in any order."""

    type = NAMED_VECTOR
    whole = True

    def __init__(self, names: Sequence[str]) -> None:
        self.places = range(len(names))
        self._names = list(names)

    def read(self, message: Any, arrival: int) -> tuple[int, Array]:
        """Return stamp (ns) and values (len(names),).

        Raises MessageError, its reason one of `wrong_length`, `unknown_name`, `missing_name`.
        """
        stamp = nanoseconds(message.header.stamp)
        names = message.name
        if len(names) != len(message.position):
            raise MessageError(
                'wrong_length', f'{len(names)} names but {len(message.position)} positions'
            )
        values = np.array(message.position)
        if names == self._names:
            return stamp, values
        order = self._order(names)
        return stamp, values[order]

    def _order(self, names: Sequence[str]) -> list[int]:
        for name in names:
            if name not in self._names:
                raise MessageError(
                    'unknown_name', f'unknown name {quoted(name)}: {suggest(name, self._names)}'
                )
        for name in self._names:
            if name not in names:
                raise MessageError('missing_name', f'{quoted(name)} is missing')
        if len(names) != len(self._names):
            raise MessageError('wrong_length', f'a name stands twice: {quoted(list(names))}')
        return [names.index(name) for name in self._names]


class FieldReader:
    """Reads the bound entries of a vector (width,) out of one kind of message, the others NaN.

    A message may lack some of them, as those of robots whose joints report by turns; one that has
    none of them raises the MessageError of the first.
    """

    def __init__(self, bound: Mapping[int, Binding], width: int) -> None:
        first = next(iter(bound.values()))
        self.type = first.type
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


class NamedReader:
    """Reads named entries of a vector (width,) out of named vectors, the others NaN."""

    type = NAMED_VECTOR
    whole = True

    def __init__(self, entries: Mapping[int, str], width: int) -> None:
        self._reader = VectorReader(list(entries.values()))
        self.places = list(entries)
        self._width = width

    def read(self, message: Any, arrival: int) -> tuple[int, Array]:
        """Return stamp (ns) and values (width,); raises MessageError."""
        stamp, found = self._reader.read(message, arrival)
        values = np.full(self._width, np.nan)
        values[self.places] = found
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
    named = {i: name for i, name in enumerate(entries) if name not in bound}
    if len(named) == width:
        return [(default, VectorReader(entries))] if width else []
    by_topic: dict[str, dict[int, Binding]] = {}
    for i, name in enumerate(entries):
        if name in bound:
            by_topic.setdefault(resolve(bound[name].topic), {})[i] = bound[name]
    readers: list[tuple[str, Reader]] = []
    for topic, those in by_topic.items():
        readers.append((topic, FieldReader(those, width)))
    if named:
        readers.append((default, NamedReader(named, width)))
    return readers
