"""Tests of obs_ros.cli.check_model."""

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from obs_ros import Record, load_model, solve_window
from obs_ros.cli.check_model import main

ROOT = Path(__file__).resolve().parents[2]
EXAMPLE = ROOT / 'examples' / 'my_plant'
PENDULUM = 'my_plant.pendulum:PENDULUM'


@pytest.fixture
def run(monkeypatch, capsys):
    """A function that returns exit code, output and complaint, as of the command."""
    monkeypatch.syspath_prepend(EXAMPLE)
    monkeypatch.setenv('OBS_ROS_BACKEND', 'numpy')

    def run(*arguments):
        code = main(arguments)
        return code, *capsys.readouterr()

    return run


def limits(text):
    """Twice the standard deviation by name, None where it is not determined."""
    found = re.findall(r'^  \w+ +(\w+) +\S+, (?:known to \+- (\S+)|not determined)', text, re.M)
    return {name: float(limit) if limit else None for name, limit in found}


def test_it_prints_units_bounds_a_rollout_and_speed(run):
    code, text, complaint = run('three_tank', '--window', '100', '--noise', 'h1=0.02')
    assert code == 0
    waits = [line.split()[0] for line in complaint.splitlines() if line.endswith(' ...')]
    assert waits == ['compiling', 'measuring', 'asking']
    lines = text.splitlines()
    assert lines[0] == 'three_tank: Yang, Li & Dahhou 2020, eq. 16'
    assert '  state      h1               cm       0 to 100' in lines
    assert '  parameter  p3               1        0 to 1, nominal 1' in lines
    assert '  input      Q1               cm3/s    hold, nominal 30' in lines
    assert 'trial rollout: 100 s, a sample every 1 s, 100 steps' in lines
    assert '  output     h1               0.02 cm' in lines
    assert 'a guess: give --noise h2=...' in text
    (speed,) = re.findall(r'speed: (\S+) ns for a step of one candidate, .* \(numpy;', text)
    assert 1.0 < float(speed) < 1e7


def test_it_tells_what_is_on_a_log_scale(run):
    _, text, _ = run('heat_exchanger_reduced', '--window', '4', '--noise', 'Tp=0.05')
    line = '  parameter  k1               N/m      3000 to 12000, log scale, nominal 6089'
    assert line in text.splitlines()


def test_the_rollout_is_that_of_the_model(run):
    """A pendulum without friction, held: its energy, and so its amplitude, stays."""
    _, text, _ = run(PENDULUM, '--value', 'angle=1', '--value', 'friction=0', '--window', '8')
    ranges = {
        name: (float(low), float(high))
        for name, low, high in re.findall(r'state +(\w+) +from .*within (\S+) to (\S+)', text)
    }
    # At the bottom rate^2 = 2 k (1 - cos 1).
    fastest = np.sqrt(2.0 * 9.81 * (1.0 - np.cos(1.0)))
    assert ranges['angle'] == pytest.approx((-1.0, 1.0), rel=2e-3)
    assert ranges['rate'] == pytest.approx((-fastest, fastest), rel=2e-3)


def test_what_it_promises_is_what_estimates_then_say(run):
    start = ('--value', 'angle=1', '--value', 'rate=1')
    _, text, _ = run(PENDULUM, '--window', '4', '--noise', 'angle=0.002', *start)
    promised = limits(text)
    model = load_model(PENDULUM)
    t, x = 0.02 * np.arange(201), np.array([1.0, 1.0])
    angles = [x[0]]
    for _ in t[1:]:
        k = []
        for share in (0.0, 0.01, 0.01, 0.02):
            at = x + share * k[-1] if k else x
            k.append(np.array(model.dynamics(0.0, at, (0.0,), (9.81, 0.1))))
        x = x + 0.02 / 6.0 * (k[0] + 2 * k[1] + 2 * k[2] + k[3])
        angles.append(x[0])
    y = np.array(angles) + 0.002 * np.random.default_rng(0).standard_normal(t.size)
    estimate = solve_window(model, Record(t, np.zeros(t.size), y), noise={'angle': 0.002}, seed=1)
    told = {**estimate.stddev, **estimate.initial_stddev}
    assert set(promised) == set(told)
    for name, limit in promised.items():
        assert limit == pytest.approx(2.0 * told[name], rel=0.05), name


def test_the_tutorial_quotes_it(run):
    text = (ROOT / 'docs' / 'your-own-plant.md').read_text()
    (arguments,) = re.findall(r'ros2 run obs_ros check_model (my_plant.pendulum.+)', text)
    (quoted,) = re.findall(r'stiffness to \+-(\S+) of 9\.81', text)
    assert limits(run(*arguments.split())[1])['stiffness'] == pytest.approx(float(quoted), rel=0.05)


def test_what_a_window_cannot_tell_is_named_with_what_would(run):
    hanging, moved = ('--window', '4', '--noise', 'angle=0.002'), ('--input', 'torque=2')
    _, text, _ = run(PENDULUM, *hanging)
    assert limits(text)['stiffness'] is None and limits(text)['friction'] is None
    assert 'stiffness is not determined' in text and 'move the inputs' in text
    _, text, _ = run(PENDULUM, *hanging, *moved)
    assert 'torque           moves within' in text and 'everything is determined' in text
    assert limits(text)['stiffness'] < 0.1


@pytest.mark.parametrize(
    ('arguments', 'words'),
    [
        (('three_tnak',), "unknown model 'three_tnak': did you mean 'three_tank'?"),
        (('my_plant.pendulum:PENDULM',), "did you mean 'PENDULUM'?"),
        (('my_plant.pendulumm:A',), 'is its package installed?'),
        (('three_tank', '--noise', 'h3=1'), "--noise: there is no 'h3': did you mean 'h2' or 'h1'"),
        (('three_tank', '--noise', 'h1=0'), 'a standard deviation must be positive'),
        (('three_tank', '--noise', 'h1'), "--noise must be h1=NUMBER, not 'h1'"),
        (('three_tank', '--input', 'Q3=1'), "--input: there is no 'Q3'"),
        (('three_tank', '--value', 'h1=nan'), 'the number must be finite'),
        (('three_tank', '--value', 'p1=2'), 'p1 = 2 is outside its bounds 0 to 1'),
        (('three_tank', '--window', '-1'), '--window must be a positive time in s, not -1'),
        (('three_tank', '--window', '1.5'), 'too short for samples every 1 s'),
        (('three_tank', '--window', '1e9'), 'has more than 1000000 samples'),
        (
            ('plants:NO_FUTURE', '--window', '0.3', '--period', '0.1'),
            's after it was started at x = 1.5',
        ),
    ],
)  # fmt: skip
def test_what_is_wrong_is_one_line_and_exit_code_1(run, arguments, words):
    code, text, complaint = run(*arguments)
    assert (code, text) == (1, '')
    (line,) = [line for line in complaint.splitlines() if not line.endswith(' ...')]
    assert line.startswith('check_model: ') and words in line


def test_a_bad_model_is_explained_with_its_line(tmp_path, monkeypatch, run):
    source = (EXAMPLE / 'my_plant' / 'pendulum.py').read_text()
    wrong = source.replace('return rate, u[0]', 'return rate, u[1]')
    assert wrong != source
    (tmp_path / 'wrong_plant.py').write_text(wrong)
    monkeypatch.syspath_prepend(tmp_path)
    code, _, complaint = run('wrong_plant:PENDULUM')
    number = wrong[: wrong.index('u[1]')].count('\n') + 1
    assert code == 1 and 'u has 1: torque' in complaint
    assert f'(wrong_plant.py:{number}: `return rate, u[1]' in complaint


def test_it_runs_without_ros_as_a_module():
    program = (
        'import sys; sys.modules["rclpy"] = None; import runpy\n'
        'sys.argv[1:] = ["three_tank", "--window", "20"]\n'
        'runpy.run_module("obs_ros.cli.check_model", run_name="__main__")\n'
    )
    found = subprocess.run(
        [sys.executable, '-c', program], cwd=ROOT, capture_output=True, text=True,
        env={**os.environ, 'OBS_ROS_BACKEND': 'numpy'}, check=False,
    )  # fmt: skip
    assert found.returncode == 0, found.stderr
    assert 'trial rollout: 20 s' in found.stdout
