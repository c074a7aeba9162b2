"""The nodes as processes of their own: how they end, and how they fail to start."""

import os
import signal
import subprocess
import sys

import pytest
from patience import patience

from demo.domain import Domain

pytestmark = pytest.mark.slow

# What rcl says when the signal comes between a log line and its copy on /rosout.
_UNSENT = (
    "Failed to publish log message to rosout: publisher's context is invalid, "
    'at /project/src/rcl/publisher.c:423'
)
MODULES = {
    'simulator': 'plant_sim.node',
    'estimator': 'obs_ros.ros.estimator',
    'fleet': 'obs_ros.ros.fleet',
}


@pytest.fixture
def start():
    """A function that starts a node as a process, in a domain of the test's own."""
    processes = []
    with Domain() as domain:

        def start(name, *arguments):
            environment = {
                **os.environ,
                'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
                'ROS_DOMAIN_ID': str(domain),
            }
            ros_arguments = ['--ros-args', *arguments] if arguments else []
            processes.append(
                subprocess.Popen(
                    [sys.executable, '-m', MODULES[name], *ros_arguments],
                    env=environment,
                    stderr=subprocess.PIPE,
                    text=True,
                )
            )
            return processes[-1]

        yield start
        for process in processes:
            process.kill()
            process.communicate()


@pytest.mark.parametrize(
    ('name', 'sign'),
    [('simulator', 'playing'), ('estimator', 'compiling'), ('estimator', 'ready')],
)
@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_signals_end_a_node_in_peace_and_at_once(start, monkeypatch, tmp_path, name, sign, number):
    if sign == 'compiling':
        monkeypatch.setenv('OBS_ROS_CACHE', str(tmp_path))  # it has much to do, and leaves it
    node = start(name)
    assert any(sign in line for line in node.stderr)
    node.send_signal(number)
    _, stderr = node.communicate(timeout=patience(5.0))
    assert node.returncode == 0, stderr
    # That it waits for samples may be logged meanwhile.
    lines = [line for line in stderr.splitlines() if f'] [{name}]: ' not in line]
    assert set(lines) <= {_UNSENT}, stderr
    assert len(list(tmp_path.glob('**/*.nbi'))) < 3, 'it has waited for the compiler'


def test_a_signal_ends_a_fleet_in_peace_and_at_once(start):
    fleet = start('fleet', '-p', "plants:=['/a', '/b', '/c']")
    assert any('ready' in line for line in fleet.stderr)
    fleet.send_signal(signal.SIGINT)
    _, stderr = fleet.communicate(timeout=patience(5.0))
    assert fleet.returncode == 0, stderr
    lines = [line for line in stderr.splitlines() if '.estimator]: ' not in line]
    assert set(lines) <= {_UNSENT}, stderr


@pytest.mark.parametrize('name', MODULES)
def test_a_signal_while_the_node_is_being_made_is_no_error(start, name):
    node = start(name, '--log-level', 'debug')
    assert any('domain ID' in line for line in node.stderr)
    node.send_signal(signal.SIGINT)
    _, stderr = node.communicate(timeout=patience(5.0))
    assert node.returncode == 0, stderr
    assert 'Traceback' not in stderr


@pytest.mark.parametrize(
    ('name', 'arguments', 'words'),
    [
        ('estimator', ['-p', 'model:=three_tnak'], "did you mean 'three_tank'?"),
        (
            'estimator',
            ['-p', 'window.duration:=-5'],
            'window.duration must be 0.001 to 1e9 s, not -5.0',
        ),
        ('estimator', ['-p', 'bounds.p1:=[0.5, 0.1]'], 'p1'),
        ('fleet', ['-p', "plants:=['/a', '/a']"], "'/a' stands twice: take one of them away"),
        ('fleet', ['-p', "plants:=['/a']", '-p', 'workers:=-1'], 'workers must be 0 to 64, not -1'),
        ('simulator', ['-p', 'scenario:=three_tnak'], "did you mean 'three_tank'?"),
        ('simulator', ['-p', 'speed:=fast'], "speed must be a number, not 'fast'"),
    ],
)
def test_wrong_values_at_start_are_one_line_and_exit_code_1(start, name, arguments, words):
    node = start(name, *arguments)
    _, stderr = node.communicate(timeout=patience(5.0))
    assert node.returncode == 1
    assert len(stderr.splitlines()) == 1, stderr
    assert stderr.startswith(f'{name}: ') and words in stderr


@pytest.mark.parametrize('argument', ['--params-file=/no/such/file.yaml', '-p'])
def test_wrong_ros_arguments_are_no_traceback_either(start, argument):
    node = start('simulator', *argument.split('='))
    _, stderr = node.communicate(timeout=patience(5.0))
    assert node.returncode == 1
    # rcl itself says one line before.
    assert stderr.splitlines()[-1].startswith('simulator: ') and 'Traceback' not in stderr


@pytest.mark.parametrize('name', MODULES)
@pytest.mark.parametrize(
    'variables',
    [
        {'HOME': '/dev/null/x', 'ROS_LOG_DIR': '', 'ROS_HOME': ''},
        {'ROS_LOG_DIR': '/dev/null/x'},
        {'ROS_LOG_DIR': '/proc'},  # a folder where no file can be made
    ],
    ids=['home', 'no folder', 'no file'],
)
def test_a_log_that_cannot_be_written_names_the_remedy(start, monkeypatch, name, variables):
    for variable, value in variables.items():
        monkeypatch.setenv(variable, value)
    node = start(name)
    _, stderr = node.communicate(timeout=patience(60.0))
    assert node.returncode == 1
    (line,) = [line for line in stderr.splitlines() if line.startswith(f'{name}: ')]
    assert line.startswith(f'{name}: set ROS_LOG_DIR to a folder that can be written to: ')
    assert 'Traceback' not in stderr
