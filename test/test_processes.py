"""The installed executables as real processes, found as `ros2 run` finds them."""

import os
import signal
import subprocess
from pathlib import Path

import pytest
import yaml
from ament_index_python.packages import PackageNotFoundError, get_package_prefix
from ros import figures, vector
from std_msgs.msg import String
from std_srvs.srv import SetBool

from obs_ros.node.messages import LATCHED

TRUTH = {'p1': 1.0, 'p2': 1.0, 'p3': 1.0}


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
        _, stderr = process.communicate(timeout=10.0)
        assert process.returncode == 0
        assert all('[INFO]' in line for line in stderr.splitlines()), stderr
