"""Whether the estimator node loses messages while it solves: two streams from another process.

A three-tank run is sampled ahead and published at the rate asked for, `output` and `input` apart;
the node's own /diagnostics tell what arrived. Shares are of one core.
"""

import os
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from benchmarks.common import machine, mark, options, publish, table

OUTPUT, INPUT = ('h1', 'h2'), ('Q1', 'Q2')


def main(arguments: list[str] | None = None) -> Mapping[str, str]:
    """Measure, print, and write the report."""
    parser = options(__doc__)
    parser.add_argument('--rate', type=int, default=1000, help='samples per s and stream')
    parser.add_argument('--seconds', type=int, default=30, help='length of the run')
    parser.add_argument('--window', type=float, default=2.0, help='s of sample time')
    parser.add_argument('--domain', type=int, default=87, help='ROS domain id')
    chosen = parser.parse_args(arguments)
    os.environ |= {
        'ROS_DOMAIN_ID': str(chosen.domain),
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
    }
    command = ['-m', 'obs_ros.node.estimator', '--ros-args', '--log-level', 'warn', '-p']
    node = subprocess.Popen(
        [sys.executable, *command, f'window.duration:={chosen.window}'],
        cwd=Path(__file__).parents[1],
    )
    try:
        figures, shares = measure(node.pid, chosen.rate, chosen.seconds)
    finally:
        node.terminate()
        node.wait(10.0)
    parts = report(figures, shares, sent=chosen.rate * chosen.seconds)
    title = f'{chosen.rate} outputs and {chosen.rate} inputs a second for {chosen.seconds} s'
    publish(chosen.results, 'node_throughput', title, parts, machine())
    return figures


def measure(pid: int, rate: int, seconds: int) -> tuple[Mapping[str, str], Mapping[str, float]]:
    """Publish to the node and return its last figures, and CPU shares by process."""
    import rclpy
    from diagnostic_msgs.msg import DiagnosticArray
    from rclpy.node import Node
    from sensor_msgs.msg import JointState

    from obs_ros.node.messages import STREAM, named_vector

    stamped = samples(rate, seconds)
    rclpy.init()
    node = Node('throughput')
    latest: dict[str, str] = {}

    def remember(array: DiagnosticArray) -> None:
        latest.update({entry.key: entry.value for entry in array.status[0].values})

    def spin_until(predicate: Callable[[], Any], timeout: float) -> None:
        end = time.monotonic() + timeout
        while not predicate() and time.monotonic() < end:
            rclpy.spin_once(node, timeout_sec=0.2)

    node.create_subscription(DiagnosticArray, '/diagnostics', remember, 10)
    output = node.create_publisher(JointState, 'plant/output', STREAM)
    input_ = node.create_publisher(JointState, 'plant/input', STREAM)
    spin_until(lambda: latest.get('ready') == 'true' and output.get_subscription_count(), 60.0)

    busy, own, start = cpu_time(pid), time.process_time(), time.monotonic()
    for k, (stamp, u, y) in enumerate(stamped):
        while (ahead := start + k / rate - time.monotonic()) > 0.0:
            time.sleep(ahead)
        input_.publish(named_vector(stamp, INPUT, u))
        output.publish(named_vector(stamp, OUTPUT, y))
    wall = time.monotonic() - start
    shares = {
        'estimator': (cpu_time(pid) - busy) / wall,
        'publisher': (time.process_time() - own) / wall,
        'wall': wall,
    }
    latest.clear()
    spin_until(lambda: latest.get('input.received') == str(len(stamped)), 5.0)
    node.destroy_node()
    rclpy.shutdown()
    return latest, shares


def samples(rate: int, seconds: int) -> list[tuple[int, tuple[float, ...], tuple[float, ...]]]:
    """Return stamps (ns), inputs and outputs of the three-tank scenario."""
    from plant_sim.scenarios import load_scenario
    from plant_sim.simulation import Simulation

    simulation = Simulation(load_scenario('three_tank'), period=1.0 / rate)
    instants = (simulation.sample() for _ in range(rate * seconds))
    epoch = time.time_ns()
    return [(epoch + round(i.t * 1e9), i.u, i.y) for i in instants]


def cpu_time(pid: int) -> float:
    """Return the CPU seconds that a process has used, all its threads together."""
    fields = Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')


def report(figures: Mapping[str, str], shares: Mapping[str, float], sent: int) -> list[str]:
    """Return the parts of the report."""
    rows = []
    for stream in ('output', 'input'):
        received = int(figures.get(f'{stream}.received', 0))
        rows.append((stream, sent, received, sent - received, mark(received == sent)))
    kept = {k: v for k, v in figures.items() if k.startswith('samples.') and v != '0'}
    solved = ('published', 'withheld', 'failed', 'skipped', 'solve_time_s', 'latency_s')
    return [
        table(('stream', 'sent', 'received', 'lost', 'holds'), rows),
        table(
            ('windows', 'value'),
            [(name, figures.get(name, '-')) for name in solved] + sorted(kept.items()),
        ),
        table(
            ('process', 'CPU share'),
            [(name, f'{shares[name]:.2f}') for name in ('estimator', 'publisher')],
        ),
        f'Published within {shares["wall"]:.2f} s.',
    ]


if __name__ == '__main__':
    main()
