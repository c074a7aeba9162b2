"""Malformed messages to an estimator, and a sound run after them."""

import math
import random
import time
from collections.abc import Mapping
from typing import Any, NamedTuple

from benchmarks.live import INPUT, OUTPUT, PERIOD, Live, received
from benchmarks.play import played
from benchmarks.runner import progress

NAMES = (*OUTPUT, *INPUT, 'h3', 'p1', '', 'h1 ', 'ĥ1', 'h' * 1000, '\n', '{}', '%s')
VALUES = (math.nan, math.inf, -math.inf, 1e308, -1e308, 5e-324, 0.0, -0.0, 1e20, 1.0, -7.5)
SECONDS = (0, -1, 1, -(2**31), 2**31 - 1, 1_700_000_000)
NANOSECONDS = (0, 999_999_999, 1_000_000_000, 2**32 - 1)
BATCH, PAUSE = 200, 0.2  # messages; s after them, as queues are bounded
DURATION = 300  # samples of the sound run, at its end
EPOCH = 2**31 * 10**9 - 10**15  # ns; later than the others, and still a stamp


class Fuzzed(NamedTuple):
    """Messages sent, the node's figures, the numbers it published that are none, how it ended."""

    sent: int
    figures: Mapping[str, str]
    non_finite: int
    last: Mapping[str, float]
    code: int
    traceback: bool

    @property
    def uncounted(self) -> int:
        """Messages that the node has not counted as received."""
        return self.sent - received(self.figures)


def fuzzed(live: Live, count: int, rng: random.Random) -> Fuzzed:
    """Send malformed messages, then a sound run, and end the node."""
    estimates: list[Any] = []
    live.listen('/estimator/parameters', estimates.append)
    sent = count + 2 * DURATION
    for k in progress(range(count), 'fuzz', count):
        live.publishers[rng.choice(('output', 'input'))].publish(malformed(rng))
        if k % BATCH == BATCH - 1:
            live.spin()
            time.sleep(PAUSE)
    live.spin_until(lambda: received(live.figures) == count, 60.0)
    for instant in played('three_tank', DURATION, period=PERIOD):
        live.feed(instant, EPOCH)
        time.sleep(0.005)  # in a burst, one stream would be read long before the other
    live.spin_until(lambda: received(live.figures) == sent, 60.0)
    live.spin_until(lambda: estimates and estimates[-1].header.stamp.sec >= EPOCH // 10**9, 30.0)
    figures = dict(live.figures)
    code, written, _ = live.close()
    last = dict(zip(estimates[-1].name, estimates[-1].position, strict=True)) if estimates else {}
    odd = sum(not math.isfinite(v) for estimate in estimates for v in estimate.position)
    return Fuzzed(sent, figures, odd, last, code, 'Traceback' in written)


def malformed(rng: random.Random) -> Any:
    """Return a JointState that is wrong in one way or another; now and then it is none."""
    from sensor_msgs.msg import JointState

    message = JointState()
    message.header.frame_id = rng.choice(('', 'world', 'x' * 300))
    message.header.stamp.sec = rng.choice((*SECONDS, rng.randrange(-(2**31), 2**31)))
    message.header.stamp.nanosec = rng.choice((*NANOSECONDS, rng.randrange(2**32)))
    kind = rng.randrange(4)
    if kind == 0:
        message.name = [rng.choice(NAMES) for _ in range(rng.randrange(6))]
        message.position = [rng.choice(VALUES) for _ in range(rng.randrange(6))]
    else:
        message.name = list(OUTPUT if kind < 3 else INPUT)
        rng.shuffle(message.name)
        message.position = [rng.choice((*VALUES, rng.uniform(0, 100))) for _ in message.name]
    if rng.random() < 0.2:
        message.velocity = [rng.choice(VALUES) for _ in range(rng.randrange(4))]
        message.effort = [rng.choice(VALUES) for _ in range(rng.randrange(4))]
    return message
