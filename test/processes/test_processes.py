"""The installed executables as real processes, found as `ros2 run` finds them."""

import os
import signal
import subprocess
from pathlib import Path

import pytest
import yaml
from ament_index_python.packages import PackageNotFoundError, get_package_prefix
from diagnostic_msgs.msg import DiagnosticArray
from patience import patience
from ros import figures, vector
from std_msgs.msg import String
from std_srvs.srv import SetBool

from obs_ros.ros.messages import LATCHED

pytestmark = pytest.mark.slow

TRUTH = {'p1': 1.0, 'p2': 1.0, 'p3': 1.0}
WINDOW = 200  # s of plant time, where nodes are killed
AHEAD = 1500  # s of plant time: 15 s of a quiet machine
ARGUMENTS = {
    'simulator': ('speed:=100', 'plant.p1:=1.0', 'plant.p2:=1.0', 'plant.p3:=1.0'),
    # Started late, it meets a plant at rest, which tells p2 only.
    'estimator': (
        f'window.duration:={WINDOW}', 'noise.h1:=0.01', 'noise.h2:=0.01',
        'fixed.p1:=1.0', 'fixed.p3:=1.0', 'deadline:=20.0', 'stale_after:=30.0',
    ),
}  # fmt: skip


def executable(name: str) -> str:
    try:
        path = Path(get_package_prefix('obs_ros')) / 'lib' / 'obs_ros' / name
    except PackageNotFoundError:
        pytest.skip('obs_ros is not installed where AMENT_PREFIX_PATH points')
    assert os.access(path, os.X_OK), f'`ros2 run obs_ros {name}` would not find {path}'
    return str(path)


@pytest.fixture
def start(ros):
    """A function that starts an executable in the ROS domain of the test."""
    processes = []

    def start(name, *arguments):
        environment = {**os.environ, 'ROS_DOMAIN_ID': str(ros.context.get_domain_id())}
        process = subprocess.Popen(
            [executable(name), '--ros-args', *arguments],
            env=environment,
            stderr=subprocess.PIPE,
            text=True,
        )
        processes.append(process)
        return process

    yield start
    for process in processes:
        process.kill()
        process.communicate()


def test_the_installed_nodes_estimate_the_tanks_and_end_in_peace(ros, start):
    nodes = [
        start('simulator', '-p', 'speed:=200', '-p', 'enabled:=false'),
        start('estimator', '-p', 'window.duration:=500'),
    ]
    for name in ('/simulator', '/estimator'):
        texts = ros.listen(f'{name}/info', String, LATCHED)
        assert yaml.safe_load(ros.spin_until(lambda t=texts: t)[0].data)['model'] == 'three_tank'
    estimates, states = ros.listen('/estimator/parameters'), ros.listen('/estimator/state')
    levels, solver = ros.listen('/plant/state'), ros.listen('/estimator/solver')

    def ready():
        found = figures(ros.health())
        return found.get('ready') == 'true' and found

    assert ros.spin_until(ready, timeout=60.0)['outcome'] == 'waiting'
    assert ros.call('/simulator/enable', SetBool, data=True).success
    ros.spin_until(lambda: estimates and states and solver, timeout=30.0)
    assert vector(estimates[0]) == pytest.approx(TRUTH, abs=0.01)
    stamp = states[0].header.stamp
    level = ros.spin_until(lambda: [m for m in levels if m.header.stamp == stamp])[0]
    assert vector(states[0]) == pytest.approx(vector(level), abs=0.5)
    assert vector(solver[0])['skipped'] == 0.0

    for process in nodes:
        process.send_signal(signal.SIGINT)
    for process in nodes:
        ended_in_peace(process)


def ended_in_peace(process, *more):
    words = ('[INFO]', 'waiting for plant/', *more)
    _, stderr = process.communicate(timeout=patience(10.0))
    assert process.returncode == 0
    assert all(any(word in line for word in words) for line in stderr.splitlines()), stderr


@pytest.mark.parametrize(
    ('killed', 'started'),
    [
        (('simulator',), ('simulator',)),
        (('estimator',), ('estimator',)),
        (('simulator', 'estimator'), ('estimator', 'simulator')),
        (('estimator', 'simulator'), ('simulator', 'estimator')),
    ],
    ids=['simulator', 'estimator', 'both, estimator first', 'both, simulator first'],
)
def test_a_node_that_is_killed_and_started_again_is_met_within_a_window(
    ros, start, killed, started
):
    def begin(name):
        return start(name, *(word for value in ARGUMENTS[name] for word in ('-p', value)))

    nodes = {name: begin(name) for name in ARGUMENTS}
    estimates, outputs = ros.listen('/estimator/parameters'), ros.listen('/plant/output')
    deviations, solver = (
        ros.listen(f'/estimator/{topic}') for topic in ('parameters_stddev', 'solver')
    )
    ros.spin_until(lambda: estimates, timeout=60.0)
    if 'estimator' not in killed:
        # The new simulator must not have come as far when the middleware has found it.
        # An estimate may come before the middleware has brought the first output here.
        ros.spin_until(lambda: outputs and seconds(outputs[-1]) > AHEAD, timeout=60.0)

    for name in killed:
        nodes[name].kill()
        nodes[name].wait()
    ros.executor.spin_once(timeout_sec=0.0)
    arrays = ros.listen('/diagnostics', DiagnosticArray)
    for name in started:
        nodes[name] = begin(name)
    # Until both have found each other, which is the middleware's affair.
    ros.spin_until(lambda: is_hearing(arrays, again='estimator' not in killed), timeout=60.0)
    del estimates[:], outputs[:]
    first = seconds(ros.spin_until(lambda: outputs, timeout=30.0)[0])
    # What an estimator that lived on had begun may still come.
    met = ros.spin_until(
        lambda: [e for e in estimates if first <= seconds(e) <= first + 3 * WINDOW], timeout=60.0
    )[0]
    # One window, one for discovery, which takes its wall time while the plant runs on fast, and
    # those that a busy machine has skipped.
    told = ros.spin_until(lambda: [m for m in solver if m.header.stamp == met.header.stamp])[0]
    assert seconds(met) <= first + (2 + vector(told)['skipped']) * WINDOW + 2
    spread = ros.spin_until(lambda: [d for d in deviations if d.header.stamp == met.header.stamp])[
        0
    ]
    assert abs(vector(met)['p2'] - TRUTH['p2']) <= 6.0 * vector(spread)['p2'] < 0.01
    for process in nodes.values():
        process.send_signal(signal.SIGINT)
    for process in nodes.values():
        ended_in_peace(process, 'start anew: ')


def seconds(message):
    return message.header.stamp.sec


def is_hearing(arrays, *, again):
    """Whether the estimator has both streams, `again` after stamps that began anew."""
    statuses = [array.status[0] for array in arrays if array.status[0].name == '/estimator']
    told = figures(statuses[-1]) if statuses else {}
    names = ('output.received', 'input.received', *(('samples.reset',) if again else ()))
    return told.get('ready') == 'true' and all(told[name] != '0' for name in names)
