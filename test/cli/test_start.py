"""The executables: their help, without ROS, and what a user gets wrong, in one line."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from patience import patience

from obs_ros.interface import parameters as estimator
from plant_sim import settings as simulator

pytestmark = pytest.mark.slow  # processes

SPECS = {
    'estimator': (*estimator.CHOICE, *estimator.LIVE, *estimator.COMMON),
    'simulator': (*simulator.CHOICE, *simulator.COMMON),
}
COMMANDS = ('estimator', 'simulator', 'replay', 'check_model', 'init')


@pytest.fixture
def command(tmp_path):
    """Run an executable where ROS cannot be imported, as a process; return it when it has ended."""
    (tmp_path / 'rclpy.py').write_text('raise RuntimeError("ROS was started")\n')

    def run(name, *arguments):
        code = f'import sys; from obs_ros.cli.start import {name}; sys.exit({name}())'
        environment = os.environ | {
            'PYTHONPATH': os.pathsep.join((str(tmp_path), str(Path(__file__).parents[2]))),
            'OBS_ROS_BACKEND': 'numpy',
        }
        return subprocess.run(
            [sys.executable, '-c', code, *arguments], env=environment, cwd=tmp_path,
            capture_output=True, text=True, timeout=patience(60.0),
        )  # fmt: skip

    return run


@pytest.mark.parametrize('name', COMMANDS)
@pytest.mark.parametrize('option', ['--help', '-h'])
def test_help_is_printed_without_ros(command, name, option):
    done = command(name, option)
    assert (done.returncode, done.stderr) == (0, '')
    assert done.stdout.startswith('usage: ') and name in done.stdout.splitlines()[0]
    words = ' '.join(done.stdout.split())
    for spec in SPECS.get(name, ()):
        assert f' {spec.name} (' in words and spec.describe() in words
    assert max(map(len, done.stdout.splitlines())) <= 105


def test_what_follows_ros_args_is_for_ros(command):
    done = command('simulator', '--ros-args', '--help')
    assert done.returncode == 1 and 'ROS was started' in done.stderr


TABLE = 't,Q1,Q2,h1,h2\n' + ''.join(f'{t},30,30,10,10\n' for t in range(50))
ENDS = {
    'KeyboardInterrupt': 'raise KeyboardInterrupt', 'SystemExit': 'raise SystemExit(0)',
    'exit': 'exit()', 'sys.exit': 'import sys; sys.exit(0)',
}  # fmt: skip


@pytest.mark.parametrize('how', ENDS)
@pytest.mark.parametrize('name', ['replay', 'check_model'])
def test_a_module_that_ends_the_process_is_an_error(command, tmp_path, name, how):
    (tmp_path / 'my_end.py').write_text(ENDS[how] + '\n')
    (tmp_path / 'a.csv').write_text(TABLE)
    arguments = ('a.csv', '-p', 'model:=my_end:M') if name == 'replay' else ('my_end:M',)
    done = command(name, *arguments)
    (line,) = done.stderr.splitlines()
    assert done.returncode == 1 and done.stdout == ''
    assert line.strip('\r').startswith(f"{name}: model 'my_end:M': its module ends the process")


def test_a_pipe_is_no_recording(command, tmp_path):
    for name in ('a.csv', 'a.mcap', 'a.db3'):
        os.mkfifo(tmp_path / name)
        done = command('replay', name)
        (line,) = done.stderr.splitlines()
        assert done.returncode == 1
        assert line.endswith(f'{name} is a pipe or a device: copy what it gives into a file first')
    done = command('replay', '/dev/zero')
    assert done.returncode == 1 and len(done.stderr.splitlines()) == 1


def test_a_seed_of_thousands_of_digits_is_an_error(command, tmp_path):
    (tmp_path / 'a.csv').write_text(TABLE)
    for digits in ('0x' + 5000 * 'f', 5000 * '9'):
        done = command('replay', 'a.csv', '-p', f'seed:={digits}')
        (line,) = done.stderr.splitlines()
        assert done.returncode == 1 and len(line) < 400
        assert 'seed' in line


def test_a_file_for_another_observer_is_one_line(command, tmp_path):
    (tmp_path / 'a.csv').write_text(TABLE)
    (tmp_path / 'p.yaml').write_text(
        '/**:\n  ros__parameters:\n    window: {duration: 10.0, period: 5.0}\n'
        '    search: {population: 30}\n    deadline: 2.0\n    ukf.alpha: 1.0\n    sed: 3\n'
    )
    done = command('replay', 'a.csv', '--params', 'p.yaml', '-p', 'observer:=ekf')
    assert done.returncode == 0, done.stderr
    lines = [line for line in done.stderr.splitlines() if 'ignored' in line]
    (line,) = lines
    assert line.startswith('replay: ignored, as there are no such parameters: ')
    for name in ('deadline', 'search.population', 'ukf.alpha', 'window.duration'):
        assert f"'{name}'" in line
    assert "'sed' (did you mean 'seed'?)" in line and 'known are' not in line


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_a_signal_is_not_taken_for_the_model_s(tmp_path, number):
    (tmp_path / 'my_slow.py').write_text(
        'import sys\nprint("begun", flush=True)\nwhile True: pass\n'
    )
    (tmp_path / 'a.csv').write_text(TABLE)
    code = 'import sys; from obs_ros.cli.start import replay; sys.exit(replay())'
    root = str(Path(__file__).parents[2])
    process = subprocess.Popen(
        [sys.executable, '-c', code, 'a.csv', '-p', 'model:=my_slow:M'], cwd=tmp_path, text=True,
        env=os.environ | {'PYTHONPATH': os.pathsep.join((str(tmp_path), root))},
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip
    assert process.stdout.readline() == 'begun\n'
    process.send_signal(number)
    _, complaint = process.communicate(timeout=patience(60.0))
    assert process.returncode == 130 and 'stopped' in complaint, complaint
