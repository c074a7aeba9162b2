"""An estimator started and interrupted again and again, each time as a new process."""

import signal
import subprocess
import time
from typing import Any, NamedTuple

from benchmarks.live import estimator, process_seconds
from benchmarks.runner import progress

STEP = 0.001  # s between two looks


class Stay(NamedTuple):
    """One process: seconds to its first subscription and to its exit, and how that was."""

    start: float
    stop: float
    cpu: float  # s of process time until the subscription
    code: int
    quiet: bool


def stays_of(count: int) -> list[Stay]:
    """Let a node watch so many estimators come and go."""
    import rclpy
    from rclpy.node import Node

    rclpy.init()
    watch = Node('watch')
    stays = [stay(watch) for _ in progress(range(count), 'start', count)]
    watch.destroy_node()
    rclpy.try_shutdown()
    return stays


def stay(watch: Any) -> Stay:
    """Start an estimator, let a node watch for its first subscription, and interrupt it."""
    while watch.count_subscribers('/plant/output'):
        time.sleep(STEP)  # the one before has not left yet
    begin = time.monotonic()
    process = estimator(stderr=subprocess.PIPE)
    while not watch.count_subscribers('/plant/output') and process.poll() is None:
        time.sleep(STEP)
    start, cpu = time.monotonic() - begin, process_seconds(process.pid)
    time.sleep(1.0)  # it compiles, or loads what is compiled
    begin = time.monotonic()
    process.send_signal(signal.SIGINT)
    _, written = process.communicate(timeout=30.0)
    stop = time.monotonic() - begin
    return Stay(start, stop, cpu, process.returncode, 'Traceback' not in written)
