"""Whether the estimator node loses messages while it solves: two streams from another process.

A run of the plant is sampled ahead and published at the rate asked for, `output` and `input` apart;
the node's own /diagnostics tell what arrived. Three tanks at 1 kHz for the sliding window, which
solves in a thread; a linear plant at 500 Hz for the genetic adaptive state estimator (N 200, W 50,
g_t 10), which breeds 5000 generations a second in the callback. Shares are of one core.
"""

import os
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks.common import machine, mark, options, publish, table


@dataclass(frozen=True)
class Case:
    """What the estimator is, and the scenario and samples per s and stream that it gets."""

    observer: str
    scenario: str
    rate: int
    window: float = 2.0  # s of sample time, for the sliding window


CASES = (
    Case('sliding_window', 'three_tank', 1000),
    Case('gase', 'observer_form_third_order', 500),
)


def main(arguments: list[str] | None = None) -> Mapping[str, Mapping[str, str]]:
    """Measure, print, and write the report; return the last figures by observer."""
    parser = options(__doc__)
    parser.add_argument('--seconds', type=int, default=30, help='length of each run')
    parser.add_argument('--domain', type=int, default=87, help='ROS domain id')
    chosen = parser.parse_args(arguments)
    os.environ |= {
        'ROS_DOMAIN_ID': str(chosen.domain),
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
    }
    parts, found = [], {}
    for case in CASES:
        figures, shares = run(case, chosen.seconds)
        found[case.observer] = figures
        parts += [
            f'## {case.observer}: {case.rate} outputs and {case.rate} inputs a second, '
            f'{chosen.seconds} s of {case.scenario}',
            *report(figures, shares, sent=case.rate * chosen.seconds, case=case),
        ]
    publish(chosen.results, 'node_throughput', 'Messages into the node', parts, machine())
    return found


def run(case: Case, seconds: int) -> tuple[Mapping[str, str], Mapping[str, float]]:
    """Start a node, measure it, and end it."""
    from plant_sim.scenarios import load_scenario

    chosen = {'model': load_scenario(case.scenario).model, 'observer': case.observer}
    if case.observer == 'sliding_window':
        chosen['window.duration'] = str(case.window)
    command = ['-m', 'obs_ros.ros.estimator', '--ros-args', '--log-level', 'warn']
    for name, value in chosen.items():
        command += ['-p', f'{name}:={value}']
    node = subprocess.Popen([sys.executable, *command], cwd=Path(__file__).parents[2])
    try:
        return measure(node.pid, case, seconds)
    finally:
        node.terminate()
        node.wait(10.0)


def measure(pid: int, case: Case, seconds: int) -> tuple[Mapping[str, str], Mapping[str, float]]:
    """Publish to the node and return its last figures, and CPU shares by process."""
    import rclpy
    from diagnostic_msgs.msg import DiagnosticArray
    from rclpy.node import Node
    from sensor_msgs.msg import JointState

    from obs_ros.core.model import names
    from obs_ros.models import load_model
    from obs_ros.ros.messages import STREAM, named_vector
    from plant_sim.scenarios import load_scenario

    rate, stamped = case.rate, samples(case, seconds)
    model = load_model(load_scenario(case.scenario).model)
    output_names, input_names = names(model.outputs), names(model.inputs)
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
        input_.publish(named_vector(stamp, input_names, u))
        output.publish(named_vector(stamp, output_names, y))
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


def samples(case: Case, seconds: int) -> list[tuple[int, tuple[float, ...], tuple[float, ...]]]:
    """Return stamps (ns), inputs and outputs of the scenario."""
    from plant_sim.scenarios import load_scenario
    from plant_sim.simulation import Simulation

    simulation = Simulation(load_scenario(case.scenario), period=1.0 / case.rate)
    instants = (simulation.sample() for _ in range(case.rate * seconds))
    epoch = time.time_ns()
    return [(epoch + round(i.t * 1e9), i.u, i.y) for i in instants]


def cpu_time(pid: int) -> float:
    """Return the CPU seconds that a process has used, all its threads together."""
    fields = Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')


def report(
    figures: Mapping[str, str], shares: Mapping[str, float], sent: int, case: Case
) -> list[str]:
    """Return the parts of the report."""
    rows, received = [], 0
    for stream in ('input', 'output'):
        received = int(figures.get(f'{stream}.received', 0))
        rows.append((stream, sent, received, sent - received, mark(received == sent)))
    if case.observer != 'sliding_window':
        published = int(figures.get('published', 0))
        rows.append(('estimates', sent, published, sent - published, mark(published == sent)))
    kept = {k: v for k, v in figures.items() if k.startswith('samples.') and v != '0'}
    solved = ('published', 'withheld', 'failed', 'skipped', 'solve_time_s', 'latency_s')
    return [
        table(('stream', 'sent', 'received', 'lost', 'holds'), rows),
        table(
            ('windows' if case.observer == 'sliding_window' else 'estimates', 'value'),
            [(name, figures.get(name, '-')) for name in solved] + sorted(kept.items()),
        ),
        table(
            ('process', 'CPU share'),
            [(name, f'{shares[name]:.2f}') for name in ('estimator', 'publisher')],
        ),
        f'Published within {shares["wall"]:.2f} s. The estimator took '
        f'{1e3 * shares["estimator"] * shares["wall"] / max(1, received):.2f} ms of CPU for each '
        'output received, with its input and what it published.',
    ]
