"""A three-tank run published to an estimator, far faster than it was sampled."""

import time
from collections.abc import Mapping
from typing import NamedTuple

from benchmarks.live import PERIOD, Live, received
from benchmarks.play import instants
from benchmarks.runner import progress

WARM_UP = 0.2  # of the run
LOOKS = 100  # at the memory


class Soak(NamedTuple):
    """Messages sent, the node's figures, its memory (MB) by share of the run, and its end."""

    sent: int  # messages of each stream
    wall: float  # s
    figures: Mapping[str, str]
    memory: list[tuple[float, float]]
    code: int
    traceback: bool

    @property
    def after_warm_up(self) -> list[float]:
        """Memory (MB) from the end of the warm-up on."""
        return [size for share, size in self.memory if share >= WARM_UP]

    @property
    def growth(self) -> float:
        """Share by which the most memory after the warm-up exceeds that at its end."""
        return max(self.after_warm_up) / self.after_warm_up[0] - 1.0

    @property
    def lost(self) -> int:
        """Messages that never arrived, or that the node has dropped."""
        dropped = sum(
            int(value) for name, value in self.figures.items() if name.startswith('samples.')
        )
        return 2 * self.sent - received(self.figures) + dropped


def soaked(live: Live, count: int, rate: float) -> Soak:
    """Publish `count` inputs and outputs, so many a second of wall time, and end the node."""
    live.spin_until(lambda: live.figures.get('compiled') == 'true', 300.0)
    memory: list[tuple[float, float]] = []
    begin = time.monotonic()
    plant = instants('three_tank', period=PERIOD)
    for k, instant in progress(zip(range(count), plant, strict=False), 'soak', count):
        while (ahead := begin + k / rate - time.monotonic()) > 0.0:
            if ahead > 2e-4:
                time.sleep(min(ahead, 0.005))
        live.feed(instant)
        if k % 100 == 0:
            live.spin()
        if (k + 1) * LOOKS // count > k * LOOKS // count:
            memory.append(((k + 1) / count, live.memory()))
    wall = time.monotonic() - begin
    live.spin_until(lambda: live.figures.get('input.received') == str(count), 20.0)
    reports = live.reports
    live.spin_until(lambda: live.reports > reports + 1, 10.0)
    figures = dict(live.figures)
    code, written, _ = live.close()
    return Soak(count, wall, figures, memory, code, 'Traceback' in written)
