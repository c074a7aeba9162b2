"""Bags written without ROS, for tests."""

import numpy as np
import pytest


class BagMaker:
    """Writes messages of Jazzy into a new bag; times are recorded times in ns."""

    def __init__(self, path, storage='MCAP', compression='NONE'):
        rosbag2 = pytest.importorskip('rosbags.rosbag2')
        typesys = pytest.importorskip('rosbags.typesys')
        self.store = typesys.get_typestore(typesys.Stores.ROS2_JAZZY)
        plugin = rosbag2.StoragePlugin[storage]
        self.path = path
        self._writer = rosbag2.Writer(path, version=9, storage_plugin=plugin)
        mode, kind = rosbag2.CompressionMode[compression], rosbag2.CompressionFormat.ZSTD
        self._writer.set_compression(mode, kind)
        self._connections = {}

    def __enter__(self):
        self._writer.open()
        return self

    def __exit__(self, *_):
        self._writer.close()

    def header(self, stamp):
        time = self.store.types['builtin_interfaces/msg/Time']
        stamp = time(sec=stamp // 10**9, nanosec=stamp % 10**9)
        return self.store.types['std_msgs/msg/Header'](stamp=stamp, frame_id='')

    def vector(self, topic, recorded, stamp, **values):
        """Write a named vector."""
        self.write(
            topic, recorded, 'sensor_msgs/msg/JointState', header=self.header(stamp),
            name=list(values), position=np.array(list(values.values()), dtype=float),
            velocity=np.empty(0), effort=np.empty(0),
        )  # fmt: skip

    def write(self, topic, recorded, kind, **fields):
        """Write a message of any type."""
        raw = self.store.serialize_cdr(self.store.types[kind](**fields), kind)
        self.raw(topic, recorded, kind, raw)

    def raw(self, topic, recorded, kind, raw):
        """Write bytes as they are."""
        if topic not in self._connections:
            self._connections[topic] = self._writer.add_connection(
                topic, kind, typestore=self.store
            )
        self._writer.write(self._connections[topic], recorded, raw)


def read_vectors(path):
    """Return (topic, recorded ns, stamp ns, values by name) of every named vector in a bag."""
    highlevel = pytest.importorskip('rosbags.highlevel')
    with highlevel.AnyReader([path]) as reader:
        found = []
        for connection, recorded, raw in reader.messages():
            message = reader.deserialize(raw, connection.msgtype)
            stamp = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
            values = dict(zip(message.name, message.position.tolist(), strict=True))
            found.append((connection.topic, recorded, stamp, values))
    return found
