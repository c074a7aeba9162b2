"""`ros2 run obs_ros init`: what it writes works at once, and what it cannot write it refuses."""

import csv
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from catkin_pkg.package import parse_package
from hypothesis import given
from hypothesis import strategies as st
from patience import patience

from obs_ros.cli.init import check_package_name, main

ROOT = Path(__file__).resolve().parents[2]
OVEN = ('--input', 'heat=%', '--output', 'air=degC', '--output', 'wall')


@pytest.fixture
def oven(tmp_path):
    """A recording of an oven whose wall follows its air: two lags, by the exact solution."""
    lag, period = np.array([20.0, 60.0]), 1.0
    keep = np.exp(-period / lag)
    rows, x, rng = [], np.array([20.0, 20.0]), np.random.default_rng(1)
    for k in range(900):
        heat = 60.0 if k % 150 < 75 else 20.0
        noisy = x + 0.05 * rng.standard_normal(2)
        rows.append(f'{k},{heat},{noisy[0]:.4f},{noisy[1]:.4f}')
        end = np.array([20.0 + 1.5 * heat, 20.0 + 0.8 * heat])
        x = end + keep * (x - end)
    path = tmp_path / 'oven.csv'
    path.write_text('\n'.join(['t,heat,air,wall [degC]', *rows]) + '\n')
    return path


def written(folder, *arguments):
    return main([*arguments, '--destination-directory', str(folder)])


@given(st.one_of(st.text(max_size=70), st.from_regex(r'[a-z0-9_]+'), st.sampled_from(
    ['json', 'test', 'setup', 'config', 'numpy', 'obs_ros', 'plant_sim', 'class', 'a', 'a__b', 'a_']
)))  # fmt: skip
def test_a_package_is_refused_or_has_a_name_that_ros_and_python_take(name):
    try:
        check_package_name(name)
    except ValueError as error:
        assert str(error).startswith(('name the package', 'choose another name'))
        assert str(error).isprintable()
    else:
        assert name.isidentifier() and name.isascii() and name == name.lower()
        assert '__' not in name and not name.endswith('_') and 2 <= len(name) <= 60
        assert name not in sys.stdlib_module_names


@pytest.mark.parametrize(
    'name', ['json', 'test', 'setup', 'numpy', 'obs_ros', 'class', 'a', 'a__b']
)
def test_names_that_are_taken_or_wrong(name):
    with pytest.raises(ValueError, match=f"'{name}'"):
        check_package_name(name)


@pytest.mark.parametrize(
    ('arguments', 'words'),
    [
        (['Oven'], "small letters, digits and single _.*not 'Oven'"),
        (['oven'], 'at least one output'),
        (['oven', '--output', 'air', '--column', 'air=b'], '--column is for a table'),
        (['oven', '--output', 'air', '--period', '0'], '--period must be a time in s above 0'),
        (['oven', '--csv', 'CSV', '--column', 'air'], '--column must be NAME=COLUMN'),
        (['oven', '--csv', 'CSV', '--column', 'a=air', '--column', 'a=heat'], 'the second'),
        (['oven', '--csv', 'CSV'], 'there are heat, air, wall'),
        (['oven', '--csv', 'CSV', *OVEN, '--period', '1'], "the column 't' tells the time already"),
        (['oven', '--csv', 'no.csv', *OVEN], 'no.csv does not exist'),
    ],
)  # fmt: skip
def test_mistakes_are_told_in_one_line_and_nothing_is_written(
    oven, tmp_path, capsys, arguments, words
):
    before = sorted(tmp_path.iterdir())
    assert written(tmp_path, *(str(oven) if a == 'CSV' else a for a in arguments)) == 1
    told = capsys.readouterr()
    (line,) = told.err.splitlines()
    assert line.startswith('init: ') and not told.out
    assert re.search(words, line), line
    assert sorted(tmp_path.iterdir()) == before


def test_a_second_time_nothing_is_overwritten(tmp_path, capsys):
    assert written(tmp_path, 'oven', '--output', 'air=degC') == 0
    assert 'oven/README.md says how' in capsys.readouterr().out
    plant = tmp_path / 'oven' / 'oven' / 'plant.py'
    plant.write_text('mine')
    assert written(tmp_path, 'oven', '--output', 'air=degC') == 1
    assert 'nothing is overwritten' in capsys.readouterr().err
    assert plant.read_text() == 'mine'


def run(folder, *arguments):
    """Run Python in a package's folder as its README says; return what it printed."""
    done = subprocess.run(
        [sys.executable, '-m', *arguments], cwd=folder, capture_output=True, text=True,
        timeout=patience(30.0), check=False,
        env=os.environ | {'OBS_ROS_BACKEND': 'numpy', 'PYTHONPATH': str(ROOT)},
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def documented(package, module):
    """Return the words after `python -m` of the README's line with that module."""
    lines = (package / 'README.md').read_text().splitlines()
    (line,) = [line for line in lines if f'python -m {module}' in line]
    return shlex.split(line)[2:]


@pytest.mark.slow
@pytest.mark.parametrize(
    'arguments', [('--csv', 'CSV', *OVEN), ('--output', 'air')], ids=['csv', 'names']
)
def test_what_is_written_passes_its_test_and_the_look_at_it(oven, tmp_path, arguments):
    assert written(tmp_path, 'oven', *(str(oven) if a == 'CSV' else a for a in arguments)) == 0
    package = tmp_path / 'oven'
    told = run(package, *documented(package, 'pytest'), '-q', '-p', 'no:cacheprovider')
    assert '2 passed' in told
    first, *report = run(package, *documented(package, 'obs_ros.cli.check_model')).splitlines()
    assert first.startswith('oven: a first guess') and 'replace dynamics in oven/plant.py' in first
    assert any('everything is determined' in line for line in report)


@pytest.mark.slow
def test_the_replay_of_the_readme_finds_the_lags_of_the_recording(oven, tmp_path):
    """The oven is two lags of first order: there the first guess is the plant."""
    assert written(tmp_path, 'oven', '--csv', str(oven), *OVEN) == 0
    package = tmp_path / 'oven'
    words = documented(package, 'obs_ros.replay')
    run(package, *words, '--compare', 'none', '--output', 'report')
    with (package / 'report' / 'estimates.csv').open() as file:
        table = list(csv.DictReader(file))
    assert len(table) >= 8
    truth = {'lag_air': 20.0, 'lag_wall': 60.0, 'gain_air_heat': 1.5, 'gain_wall_heat': 0.8}
    for name, true in truth.items():
        columns = ([float(row[column]) for row in table] for column in (name, f'{name}_stddev'))
        values, deviations = map(np.array, columns)
        off = np.abs(values - true) / deviations
        assert np.nanmedian(off) < 1.5 and np.isfinite(off).mean() > 0.8, (name, off)


@pytest.mark.slow
def test_the_package_installs_as_ros_wants_it(tmp_path):
    assert written(tmp_path, 'oven', *OVEN) == 0
    manifest = parse_package(tmp_path / 'oven' / 'package.xml')
    manifest.validate()
    assert manifest.get_build_type() == 'ament_python'
    run(tmp_path, 'pip', 'install', '--quiet', '--no-deps', '--no-build-isolation', '--no-index',
        '--prefix', 'install', './oven')  # fmt: skip
    install = tmp_path / 'install'
    assert (install / 'share' / 'ament_index' / 'resource_index' / 'packages' / 'oven').is_file()
    assert (install / 'share' / 'oven' / 'config' / 'plant.yaml').is_file()
    assert len(list(install.glob('lib/python*/site-packages/oven/plant.py'))) == 1
    assert not list(install.glob('lib/python*/site-packages/test*'))


def test_both_nodes_take_its_parameter_file(ros, tmp_path, monkeypatch):
    """The simulator publishes where the estimator listens."""
    from ros import vector

    from obs_ros.ros.estimator import Estimator
    from plant_sim.node import Simulator

    monkeypatch.setenv('OBS_ROS_BACKEND', 'numpy')
    assert written(tmp_path, 'small_oven', '--input', 'heat', '--output', 'air') == 0
    monkeypatch.syspath_prepend(tmp_path / 'small_oven')
    monkeypatch.setenv('PYTHONPATH', str(tmp_path / 'small_oven'))  # of what compiles
    file = ('--ros-args', '--params-file', str(tmp_path / 'small_oven' / 'config' / 'plant.yaml'))
    estimator = ros.start(Estimator, *file, use_sim_time=True, deadline=60.0)
    found = ros.listen('/estimator/parameters')
    ros.spin_until(lambda: estimator.estimation.progress.ready, timeout=30.0)
    ros.start(Simulator, *file, speed=20.0)
    ros.spin_until(lambda: found, timeout=30.0)
    assert vector(found[0]).keys() == {'rest_air', 'gain_air_heat', 'lag_air'}
