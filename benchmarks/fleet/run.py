"""Fleets as processes, all plants of them fed from here, and their estimates timed."""

import itertools
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from benchmarks.live import INPUT, OUTPUT, process_seconds, use_domain
from benchmarks.play import played
from benchmarks.runner import ROOT, progress
from obs_ros.interface.readers import nanoseconds
from plant_sim.scenarios import load_scenario
from plant_sim.simulation import Instant

SEEDS = 8  # of the noise: further plants repeat these
PERIOD = 1.0  # s of plant time from one sample to the next, however fast they are sent


class Load(NamedTuple):
    """So many plants in so many processes; each sends `rate` outputs and inputs a second.

    Windows are of `window` samples, one at every `every`. With `at_once` all plants begin in one
    moment, so that their windows close together; else they begin spread over one such period. With
    `jumping`, two valves of each plant jump, all within a period: a load of its own.
    """

    plants: int = 100
    processes: int = 2
    rate: float = 10.0  # Hz of wall time
    window: int = 300
    every: int = 50
    seconds: float = 90.0  # of wall time
    at_once: bool = False

    @property
    def names(self) -> list[str]:
        """The namespaces of the plants."""
        return [f'/line/tank_{k}' for k in range(self.plants)]

    @property
    def samples(self) -> int:
        """Samples that each plant sends."""
        return int(self.seconds * self.rate)

    @property
    def jumping(self) -> bool:
        """Whether the plants are played beyond the scenario's first fault."""
        fault = load_scenario('three_tank').parameters.times[1]
        return self.samples * PERIOD > fault

    @property
    def windows(self) -> int:
        """Windows that close, of all plants together."""
        each = (self.samples - 1 - self.window) // self.every + 1
        return self.plants * max(0, each)

    def begin(self, plant: int) -> float:
        """Return when a plant begins, in s of wall time."""
        return 0.0 if self.at_once else plant / self.plants * self.every / self.rate


class Process(NamedTuple):
    """Resident memory and proportional share of it (MB, the most), and share of one core."""

    rss: float
    pss: float
    share: float


class Measured(NamedTuple):
    """Messages sent and received, estimates, their latencies (s), and the processes by name."""

    load: Load
    sent: int
    received: int
    published: int
    withheld: int
    skipped: int
    latencies: list[float]
    processes: Mapping[str, Process]
    late: float  # s by which a message was sent late, at most
    codes: list[int]


class Fleets:
    """The processes, each with its part of the plants."""

    def __init__(self, load: Load) -> None:
        self._words = tempfile.TemporaryFile('w+')  # noqa: SIM115 - closed by close()
        self.running: dict[str, subprocess.Popen[str]] = {}
        for k in range(load.processes):
            own = load.names[k :: load.processes]
            settings = (f'plants:={own}', f'window.duration:={load.window * PERIOD}',
                        f'window.period:={load.every * PERIOD}')  # fmt: skip
            command = [sys.executable, '-m', 'obs_ros.ros.fleet', '--ros-args',
                       '-r', f'fleet:__node:=fleet{k}', '--log-level', 'warn',
                       *(word for each in settings for word in ('-p', each))]  # fmt: skip
            self.running[f'fleet {k}'] = subprocess.Popen(
                command, cwd=ROOT, stderr=self._words, text=True
            )

    def memory(self) -> dict[str, tuple[float, float]]:
        """Return resident memory and proportional share (MB) of each."""
        return {name: memory(each.pid) for name, each in self.running.items()}

    def close(self) -> list[int]:
        """End the processes; return their exit codes."""
        for each in self.running.values():
            each.send_signal(signal.SIGINT)
        codes = [each.wait(60.0) for each in self.running.values()]
        self._words.close()
        return codes


def memory(process: int | str) -> tuple[float, float]:
    """Return resident memory and proportional share (MB) of a process."""
    lines = Path(f'/proc/{process}/smaps_rollup').read_text().splitlines()
    found = {line.split(':')[0]: line.split()[1] for line in lines[1:]}
    return int(found['Rss']) / 1024.0, int(found['Pss']) / 1024.0


class Senders:
    """Publishers of all plants, and what is heard of their estimators."""

    def __init__(self, load: Load) -> None:
        import rclpy
        from diagnostic_msgs.msg import DiagnosticArray
        from rclpy.node import Node
        from sensor_msgs.msg import JointState

        from obs_ros.ros.messages import STREAM
        from obs_ros.ros.paced_executor import PacedExecutor

        self._load = load
        self._context = rclpy.Context()
        rclpy.init(context=self._context)
        self._node = Node('senders', context=self._context)
        self._executor = PacedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self.figures: dict[str, dict[str, str]] = {}
        self.latencies: list[float] = []
        self._sent_at: list[dict[int, int]] = [{} for _ in load.names]  # ns, by stamp in ns
        self._publishers = [
            [
                self._node.create_publisher(JointState, f'{name}/plant/{stream}', STREAM)
                for stream in ('input', 'output')
            ]
            for name in load.names
        ]
        self._node.create_subscription(DiagnosticArray, '/diagnostics', self._remember, 1000)
        for k, name in enumerate(load.names):
            self._node.create_subscription(
                JointState, f'{name}/estimator/state', self._timed(k), STREAM
            )

    def _remember(self, array: Any) -> None:
        for status in array.status:
            self.figures[status.name] = {entry.key: entry.value for entry in status.values}

    def _timed(self, plant: int) -> Any:
        sent = self._sent_at[plant]

        def heard(message: Any, info: Mapping[str, Any]) -> None:
            stamp = nanoseconds(message.header.stamp)
            self.latencies.append((info['received_timestamp'] - sent[stamp]) / 1e9)

        return heard

    def spin(self, seconds: float) -> None:
        """Hear what comes within so many s."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0.0:
            self._executor.spin_once(left)

    def wait(self, timeout: float) -> None:
        """Wait until every estimator is ready and connected."""
        end = time.monotonic() + timeout
        while not all(self.of(name).get('ready') == 'true' for name in self._load.names) or not all(
            p.get_subscription_count() for pair in self._publishers for p in pair
        ):
            if time.monotonic() > end:
                raise TimeoutError(f'not every plant is ready within {timeout:g} s')
            self.spin(0.2)

    def settle(self, longest: float = 60.0) -> None:
        """Hear on until the diagnostics tell nothing new: all is read, and the last windows solved.

        What was slow is told by the latencies; what was lost never comes.
        """
        end, before, now = time.monotonic() + longest, [-1], [0]
        while now != before and time.monotonic() < end:
            self.spin(3.0)
            figures = 'input.received', 'output.received', 'published', 'withheld', 'skipped'
            before, now = now, [self.total(figure) for figure in figures]

    def of(self, plant: str) -> dict[str, str]:
        """Return the figures of a plant's estimator."""
        return self.figures.get(f'{plant}/estimator', {})

    def send(self, plant: int, epoch: int, instant: Instant) -> None:
        """Publish input and output of a plant; stamps count from `epoch` (ns)."""
        from obs_ros.ros.messages import named_vector

        stamp = epoch + round(instant.t * 1e9)
        one, other = self._publishers[plant]
        one.publish(named_vector(stamp, INPUT, instant.u))
        self._sent_at[plant][stamp] = time.time_ns()
        other.publish(named_vector(stamp, OUTPUT, instant.y))

    def total(self, figure: str) -> int:
        """Return the sum of a figure of all estimators."""
        return sum(int(self.of(name).get(figure, 0)) for name in self._load.names)

    def close(self) -> None:
        """End the node."""
        self._executor.shutdown()
        self._node.destroy_node()  # type: ignore[no-untyped-call]
        self._context.try_shutdown()


def schedule(load: Load) -> Iterator[tuple[float, int, int]]:
    """Yield when (s) which plant sends which sample, in order of time."""
    slots = [load.begin(k) + k / load.plants / load.rate for k in range(load.plants)]
    plants = sorted(range(load.plants), key=lambda k: slots[k] % (1.0 / load.rate))
    first = {k: int(slots[k] * load.rate) for k in plants}
    for turn in itertools.count():
        due = [k for k in plants if 0 <= turn - first[k] < load.samples]
        if not due and turn > max(first.values()):
            return
        for k in due:
            yield slots[k] + (turn - first[k]) / load.rate, k, turn - first[k]


def measured(load: Load, domain: int) -> Measured:
    """Start the fleets, send all that their plants send, and end them."""
    use_domain(domain)
    runs = [
        played('three_tank', load.samples, period=PERIOD, seed=seed)
        for seed in range(min(SEEDS, load.plants))
    ]
    fleets, senders = Fleets(load), Senders(load)
    try:
        senders.wait(180.0)
        busy = {name: process_seconds(each.pid) for name, each in fleets.running.items()}
        own, epoch, begin = time.process_time(), time.time_ns(), time.monotonic()
        late, sent, most = 0.0, 0, fleets.memory()
        whole = load.plants * load.samples
        for at, plant, sample in progress(schedule(load), 'fleet', whole):
            if (ahead := begin + at - time.monotonic()) > 0.0:
                senders.spin(ahead) if ahead > 0.002 else time.sleep(ahead)
            late = max(late, time.monotonic() - begin - at)
            senders.send(plant, epoch, runs[plant % len(runs)][sample])
            sent += 2
            if sent % (20 * load.plants) == 0:
                most = {n: max(most[n], now) for n, now in fleets.memory().items()}
        wall = time.monotonic() - begin
        shares = {
            name: (process_seconds(each.pid) - busy[name]) / wall
            for name, each in fleets.running.items()
        }
        shares['senders'] = (time.process_time() - own) / wall
        senders.settle()
        most = {n: max(most[n], now) for n, now in fleets.memory().items()}
        most['senders'] = memory('self')
        return Measured(
            load, sent,
            senders.total('input.received') + senders.total('output.received'),
            senders.total('published'), senders.total('withheld'), senders.total('skipped'),
            senders.latencies,
            {name: Process(*most[name], shares[name]) for name in most},
            late, fleets.close(),
        )  # fmt: skip
    finally:
        for each in fleets.running.values():
            each.kill()
        senders.close()
