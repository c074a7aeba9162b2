"""An estimator in a process of its own, fed from here and watched by its /diagnostics."""

import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from benchmarks.runner import ROOT
from plant_sim.simulation import Instant

Names = Sequence[str]


# Outputs and inputs of the three tanks, the estimator's default plant, and s between two samples.
OUTPUT, INPUT, PERIOD = ('h1', 'h2'), ('Q1', 'Q2'), 0.1


def use_domain(number: int) -> None:
    """Let this process and those that it starts speak on a ROS domain of this machine only."""
    os.environ |= {'ROS_DOMAIN_ID': str(number), 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}


def estimator(*settings: str, stderr: Any) -> subprocess.Popen[str]:
    """Start an estimator node with settings of the form `name:=value`."""
    arguments = [word for setting in settings for word in ('-p', setting)]
    command = [sys.executable, '-m', 'obs_ros.ros.estimator', '--ros-args', *arguments]
    return subprocess.Popen(command, cwd=ROOT, stderr=stderr, text=True)


def process_seconds(pid: int) -> float:
    """Return the process time in s that a process has used, all its threads together."""
    fields = Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')


def received(figures: Mapping[str, str]) -> int:
    """Return how many messages a node says have come, in both streams."""
    return sum(int(figures.get(f'{stream}.received', 0)) for stream in ('input', 'output'))


class Live:
    """The process, a node to talk to it, and the newest figures of its /diagnostics.

    Close it in the end; `close` returns exit code, what it has written to stderr, and the seconds
    from the signal to its end.
    """

    patience = 1.0  # times what an idle machine gets to answer

    def __init__(self, domain: int, *settings: str) -> None:
        use_domain(domain)
        # Not a pipe: nobody reads it, and a node that talks much would wait for that.
        self._written = tempfile.TemporaryFile('w+')  # noqa: SIM115 - closed by close()
        self.process = estimator(*settings, stderr=self._written)
        self.figures: dict[str, str] = {}
        self.reports = 0
        try:
            self._connect()
        except BaseException:
            self.process.kill()
            raise

    def _connect(self) -> None:
        """Make the node, and wait until the estimator is ready and hears it."""
        import rclpy
        from diagnostic_msgs.msg import DiagnosticArray
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.node import Node
        from sensor_msgs.msg import JointState

        from obs_ros.ros.messages import STREAM

        self._context = rclpy.Context()
        rclpy.init(context=self._context)
        self.node = Node('live', context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)

        def remember(array: DiagnosticArray) -> None:
            status = array.status[0]
            self.figures = {entry.key: entry.value for entry in status.values}
            self.figures['message'] = status.message
            self.reports += 1

        self.node.create_subscription(DiagnosticArray, '/diagnostics', remember, 10)
        self.publishers = {
            stream: self.node.create_publisher(JointState, f'plant/{stream}', STREAM)
            for stream in ('input', 'output')
        }
        self.spin_until(
            lambda: (
                self.figures.get('ready') == 'true'
                and all(p.get_subscription_count() for p in self.publishers.values())
            ),
            60.0,
        )

    def listen(self, topic: str, take: Callable[[Any], None]) -> None:
        """Hand every vector on a topic to `take`."""
        from sensor_msgs.msg import JointState

        from obs_ros.ros.messages import STREAM

        self.node.create_subscription(JointState, topic, take, STREAM)

    def send(self, stream: str, stamp: int, names: Names, values: Sequence[float]) -> None:
        """Publish a vector stamped `stamp` (ns)."""
        from obs_ros.ros.messages import named_vector

        self.publishers[stream].publish(named_vector(stamp, names, values))

    def feed(
        self, instant: Instant, epoch: int = 0, names: Sequence[Names] = (INPUT, OUTPUT)
    ) -> None:
        """Publish input and output of a plant; stamps count from `epoch` (ns)."""
        stamp = epoch + round(instant.t * 1e9)
        self.send('input', stamp, names[0], instant.u)
        self.send('output', stamp, names[1], instant.y)

    def spin(self) -> None:
        """Take the messages that have come, without waiting."""
        self._executor.spin_once(timeout_sec=0.0)

    def spin_until(self, predicate: Callable[[], Any], timeout: float) -> bool:
        """Spin until the predicate holds; return whether it did within `timeout` s."""
        end = time.monotonic() + timeout * self.patience
        while not predicate():
            if time.monotonic() > end or self.process.poll() is not None:
                return False
            self._executor.spin_once(timeout_sec=0.1)
        return True

    def memory(self) -> float:
        """Resident memory of the process in MB."""
        status = Path(f'/proc/{self.process.pid}/status').read_text()
        line = next(line for line in status.splitlines() if line.startswith('VmRSS'))
        return int(line.split()[1]) / 1024.0

    def close(self) -> tuple[int, str, float]:
        """End the process as Ctrl-C does."""
        begin = time.monotonic()
        self.process.send_signal(signal.SIGINT)
        self.process.wait(timeout=30.0 * self.patience)
        took = time.monotonic() - begin
        self._written.seek(0)
        written = self._written.read()
        self._written.close()
        self._executor.shutdown()
        self.node.destroy_node()
        self._context.try_shutdown()
        return self.process.returncode, written, took
