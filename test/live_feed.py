"""A recording played to live nodes as if it happened now, only faster."""

import time
from collections.abc import Callable, Iterable
from typing import Any

from ros import Ros

from obs_ros import Sample
from obs_ros.model import Model, names


class LiveFeed:
    """Publishes samples on plant/input and plant/output, `speed` times as fast as they came.

    `wait(stamp)` is asked before each sample: while it holds the clock of the feed stands still.
    `stood` is how long it did, in s of wall time.
    """

    def __init__(self, ros: Ros, model: Model, speed: float) -> None:
        self._ros = ros
        self._speed = speed
        self._speak = {'output': (ros.speak('plant/output'), names(model.outputs))}
        if model.inputs:
            self._speak['input'] = (ros.speak('plant/input'), names(model.inputs))
        self.stood = 0.0

    def play(
        self, samples: Iterable[Sample], wait: Callable[[int], Any] = lambda stamp: False
    ) -> float:
        """Publish them all, while the nodes spin; return how fast it was, in times real time."""
        begin = time.monotonic()
        first = stamp = None
        for sample in samples:
            stamp = sample.stamp
            first = stamp if first is None else first
            due = begin + (stamp - first) / 1e9 / self._speed
            while time.monotonic() < due + self.stood:
                self._ros.executor.spin_once(timeout_sec=0.001)
            halted = time.monotonic()
            while wait(stamp):
                assert time.monotonic() < halted + 60.0, f'nothing came before {stamp} ns'
                self._ros.executor.spin_once(timeout_sec=0.001)
            self.stood += time.monotonic() - halted
            for stream, values in (('input', sample.u), ('output', sample.y)):
                if values is not None:
                    speak, order = self._speak[stream]
                    speak(stamp / 1e9, order, values)
        return (stamp - first) / 1e9 / (time.monotonic() - begin)
