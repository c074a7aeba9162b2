"""How long the estimator takes from its start to its first subscription, and from Ctrl-C to exit.

Each in a new process with the kernels cached; also the seconds of process time, which others on the
machine do not lengthen.
"""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benchmarks.common import Progress, machine, mark, options, publish, table

START, STOP = 2.0, 1.0  # s
STEP = 0.001  # s between two looks


class Stay(NamedTuple):
    """One process: seconds to its first subscription and to its exit, and how that was."""

    start: float
    stop: float
    cpu: float  # s of process time until the subscription
    code: int
    quiet: bool


def main(arguments: list[str] | None = None) -> Sequence[Stay]:
    """Measure, print, and write the report."""
    parser = options(__doc__)
    parser.add_argument('--starts', type=int, default=10)
    parser.add_argument('--domain', type=int, default=91, help='ROS domain id')
    chosen = parser.parse_args(arguments)
    os.environ |= {
        'ROS_DOMAIN_ID': str(chosen.domain),
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
    }
    import rclpy
    from rclpy.node import Node

    rclpy.init()
    watch = Node('watch')
    progress, stays = Progress('start', chosen.starts), []
    for _ in range(chosen.starts):
        stays.append(stay(watch))
        progress.step()
    watch.destroy_node()
    rclpy.try_shutdown()
    publish(chosen.results, 'coming_and_going', 'Start and end of a node', report(stays), machine())
    return stays


def stay(watch: Any) -> Stay:
    """Start an estimator, let a node watch for its first subscription, and interrupt it."""
    while watch.count_subscribers('/plant/output'):
        time.sleep(STEP)  # the one before has not left yet
    begin = time.monotonic()
    process = subprocess.Popen(
        [sys.executable, '-m', 'obs_ros.ros.estimator'],
        cwd=Path(__file__).parents[2],
        stderr=subprocess.PIPE,
        text=True,
    )
    while not watch.count_subscribers('/plant/output') and process.poll() is None:
        time.sleep(STEP)
    start = time.monotonic() - begin
    fields = Path(f'/proc/{process.pid}/stat').read_text().rpartition(')')[2].split()
    cpu = (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')
    time.sleep(1.0)  # it compiles, or loads what is compiled
    begin = time.monotonic()
    process.send_signal(signal.SIGINT)
    _, written = process.communicate(timeout=30.0)
    stop = time.monotonic() - begin
    return Stay(start, stop, cpu, process.returncode, 'Traceback' not in written)


def report(stays: Sequence[Stay]) -> list[str]:
    """Return the parts of the report."""
    rows = []
    for name, limit in (('start', START), ('stop', STOP)):
        values = np.array([getattr(each, name) for each in stays])
        rows.append(
            (name, *(f'{f(values):.2f}' for f in (np.min, np.median, np.max)), limit,
             mark(float(np.median(values)) <= limit)),
        )  # fmt: skip
    fine = all(each.code == 0 and each.quiet for each in stays)
    cpu = float(np.median([each.cpu for each in stays]))
    return [
        f'{len(stays)} starts. Start: from the process to the first subscription; stop: from '
        'SIGINT to the exit.',
        table(('', 'fastest (s)', 'median (s)', 'slowest (s)', 'wanted (s)', 'holds'), rows),
        f'Process time until the subscription: {cpu:.2f} s (median). Exit code 0 and no traceback, '
        f'every time: {mark(fine)}.',
    ]
