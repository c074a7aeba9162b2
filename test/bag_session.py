"""`ros2 bag record` and `ros2 bag play`, which are not among the wheels, for a session."""

import argparse
from pathlib import Path

from bags import BagMaker, read_vectors
from rosgraph_msgs.msg import Clock
from session import Session

from obs_ros.ros.messages import STREAM, named_vector, time_message

ENOUGH = 300  # messages on every topic


def record(session: Session, words: list[str]) -> None:
    """Write what is published on topics of named vectors; then end the simulator."""
    parser = argparse.ArgumentParser()
    parser.add_argument('-o', type=Path, required=True)
    # The simulator's stamps are those of its /clock: recorded times must be so, too.
    parser.add_argument('--use-sim-time', action='store_true', required=True)
    parser.add_argument('--topics', nargs='+', required=True)
    options = parser.parse_args(words[3:])
    heard = {topic: session.ros.listen(topic) for topic in options.topics}
    session.ros.spin_until(
        lambda: all(len(messages) >= ENOUGH for messages in heard.values()), timeout=60.0
    )
    session.end('/simulator')
    with BagMaker(session.folder / options.o) as bag:
        taken = [(_stamp(m), topic, m) for topic, group in heard.items() for m in group]
        for stamp, topic, message in sorted(taken, key=lambda each: each[:2]):
            values = dict(zip(message.name, message.position))
            bag.vector(topic, stamp, stamp, **values)


def play(session: Session, words: list[str]) -> None:
    """Publish a bag's named vectors and its clock, as fast as the estimator listens."""
    node, vectors = session.ros.node, read_vectors(session.folder / words[3])
    assert vectors
    clock = node.create_publisher(Clock, '/clock', STREAM)
    message = named_vector(0, [], [])
    topics = {topic for topic, *_ in vectors}
    publishers = {topic: node.create_publisher(type(message), topic, STREAM) for topic in topics}
    for publisher in publishers.values():
        session.ros.spin_until(publisher.get_subscription_count, timeout=30.0)
    for topic, recorded, stamp, values in vectors:
        clock.publish(Clock(clock=time_message(recorded)))
        publishers[topic].publish(named_vector(stamp, list(values), list(values.values())))
        session.ros.executor.spin_once(timeout_sec=0.005)  # a pace, on which nothing depends


def _stamp(message: object) -> int:
    stamp = message.header.stamp  # type: ignore[attr-defined]
    return int(stamp.sec) * 10**9 + int(stamp.nanosec)
