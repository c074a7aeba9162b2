"""A rosbag2 recording, in SQLite or MCAP, read without ROS."""

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from obs_ros.core.model import Model, names
from obs_ros.core.record import Sample
from obs_ros.core.registry import suggest
from obs_ros.core.texts import LONGEST, one_line, quoted
from obs_ros.interface.bindings import HEADER, Binding
from obs_ros.interface.field_path import MessageError
from obs_ros.interface.readers import Reader, topic_readers
from obs_ros.replay.extras import require
from obs_ros.samples.merge import Merge, Role, Topic

STREAMS = ('input', 'output')


@dataclass(frozen=True)
class Binder:
    """The places of the signals in a bag: topics of `output` and `input`, and bindings.

    Relative names of topics are those of a node called `node`, as they were when it listened;
    samples of one stream from several topics wait for each other `wait` s of recorded time.
    """

    node: str
    topics: Mapping[str, str]
    bound: Mapping[str, Binding]
    wait: float
    largest: int = 1_000_000  # bytes of a message; more holds no vector that a plant has

    def resolve(self, topic: str) -> str:
        """Return the full name of a topic."""
        if topic.startswith('/'):
            return topic
        base = self.node if topic.startswith('~') else self.node.rpartition('/')[0]
        return f'{base}/{topic.removeprefix("~/")}'


class Bag:
    """Samples out of the messages on the topics wanted, in the order in which they were recorded.

    Messages are read as the node reads them: named vectors on plant/output and plant/input, or
    fields of whatever `signals` names. The time is that in the header, or that of the recording
    where `signals` says `arrival`. Messages that do not fit are counted by reason in `refused`,
    and so are those with further names, which are read all the same.

    Raises ValueError for topics that are missing or of another type, and for a path that is no bag.
    """

    def __init__(self, path: Path, binder: Binder, model: Model) -> None:
        self.refused: Counter[str] = Counter()
        self.done = 0.0
        self.remarks: Sequence[str] = []
        self._path, self._largest = path, binder.largest
        self._highlevel = require('rosbags.highlevel', 'reading a bag')
        self._typesys = require('rosbags.typesys', 'reading a bag')
        self._recorded = 0  # ns, of the message that is read
        self._ready: list[Sample] = []
        self._merge = Merge(binder.wait, lambda sample, _: self._ready.append(sample))
        for role in binder.topics:
            if role not in STREAMS:
                raise ValueError(f'--topic {role}=: {suggest(role, STREAMS)}')
        # By topic: its readers, each with the queue of its vectors; a topic may have both streams.
        self._readers: dict[str, list[tuple[Reader, Topic]]] = {}
        self._listen('input', names(model.inputs), binder)
        self._listen('output', names(model.outputs), binder)
        self._needs_header = {
            binder.resolve(each.topic) for each in binder.bound.values() if each.stamp == HEADER
        }
        with self._open() as reader:
            self._connections(reader)

    def __iter__(self) -> Iterator[Sample]:
        """Yield the samples; raises ValueError, with file, topic and number, at a broken one."""
        with self._open() as reader:
            connections = self._connections(reader)
            total = max(1, sum(connection.msgcount for connection in connections))
            messages = self._checked(reader.messages(connections=connections))
            for number, (connection, recorded, raw) in enumerate(messages, 1):
                self.done = min(1.0, number / total)
                place = f'{self._path}, message {number}, on {one_line(connection.topic, LONGEST)}'
                if len(raw) > self._largest:
                    raise ValueError(f'{place}: {len(raw)} bytes, more than {self._largest}')
                try:
                    message = reader.deserialize(raw, connection.msgtype)
                except Exception as error:  # the library's own kinds are not all that it raises
                    raise ValueError(f'{place}: cannot be decoded: {quoted(error)}') from error
                self._recorded = recorded
                yield from self._samples(connection.topic, message)
        self._merge.release(math.inf)
        yield from self._taken()

    def _listen(self, role: Role, entries: tuple[str, ...], binder: Binder) -> None:
        """Note which topics bring the entries of a stream."""
        default = binder.resolve(binder.topics.get(role, f'plant/{role}'))
        for topic, reader in topic_readers(entries, binder.bound, default, binder.resolve):
            queue = self._merge.topic(role, reader.places, whole=reader.whole)
            self._readers.setdefault(topic, []).append((reader, queue))

    def _samples(self, topic: str, message: Any) -> Iterator[Sample]:
        now = self._recorded / 1e9
        self._merge.release(now)
        for reader, queue in self._readers[topic]:
            others = reader.others
            try:
                stamp, values = reader.read(message, self._recorded)
            except MessageError as error:
                self.refused[f'{queue.role}.{error.reason}'] += 1
                continue
            if reader.others > others:
                self.refused[f'{queue.role}.other_names'] += 1
            self._merge.add(queue, stamp, values, now)
        self._merge.release(now)
        yield from self._taken()

    def _taken(self) -> list[Sample]:
        taken, self._ready = self._ready, []
        return taken

    @contextmanager
    def _open(self) -> Iterator[Any]:
        """Open the bag; it brings its types, and where it does not, those of Jazzy are taken."""
        store = self._typesys.get_typestore(self._typesys.Stores.ROS2_JAZZY)
        try:
            reader = self._highlevel.AnyReader([self._path], default_typestore=store)
            reader.open()
        except Exception as error:  # a broken file raises whatever its bytes lead to
            raise ValueError(f'{self._path}: cannot be read as a bag: {quoted(error)}') from error
        try:
            yield reader
        finally:
            reader.close()

    def _connections(self, reader: Any) -> list[Any]:
        """Return the connections of the topics wanted; raises ValueError where one is missing."""
        types = {connection.topic: connection.msgtype for connection in reader.connections}
        for topic, readers in self._readers.items():
            role, wanted = readers[0][1].role, {reader.type for reader, _ in readers}
            if topic not in types:
                raise ValueError(
                    f'{self._path}: there is no topic {topic}: {suggest(topic, types)}; '
                    f'another one is named with --topic {role}=TOPIC or signals.<name>.topic'
                )
            kind = one_line(types[topic], LONGEST)
            if {types[topic]} != wanted:
                raise ValueError(
                    f'{self._path}: {topic} has {kind}, not {" and ".join(sorted(wanted))}'
                )
            fields = [name for name, _ in reader.typestore.fielddefs[types[topic]][1]]
            if topic in self._needs_header and 'header' not in fields:
                raise ValueError(f'{topic}: {kind} has no header with a stamp; '
                                 "signals.<name>.stamp must be 'arrival'")  # fmt: skip
        return [each for each in reader.connections if each.topic in self._readers]

    def _checked(self, messages: Iterator[Any]) -> Iterator[Any]:
        """Pass messages on; raises ValueError where the file ends or breaks in between."""
        number = 0
        while True:
            try:
                message = next(messages)
            except StopIteration:
                return
            except Exception as error:  # as above
                where = f'{self._path}, after message {number}'
                raise ValueError(f'{where}: {quoted(error)}') from error
            number += 1
            yield message
