import csv
import os
import subprocess
import sys
from pathlib import Path

import pytest
from bags import BagMaker, read_vectors
from ball_and_beam import made_up, write_table

from obs_ros.cli import replay as command
from obs_ros.replay import extras

ROOT = Path(__file__).parents[2]
PARAMETERS = """
/**/estimator:
  ros__parameters:
    model: ball_and_beam:BALL
    window: {duration: 5.0, period: 2.5}
"""
T, U, Y = made_up(rows=160)
COUNT = 5  # windows of it


@pytest.fixture
def table(tmp_path):
    (tmp_path / 'rig.yaml').write_text(PARAMETERS)
    return write_table(tmp_path / 'rig.csv', T, U, Y)


@pytest.fixture(autouse=True)
def _signals_stay(monkeypatch):
    monkeypatch.setattr(command.signal, 'signal', lambda *_: None)


@pytest.fixture
def undrawn(monkeypatch):
    """No pictures, which take most of the time of a replay and are not looked at."""
    monkeypatch.setattr(command, '_draw', lambda *_: None)


def replay(table, *options):
    return command.main([str(table), '--params', str(table.parent / 'rig.yaml'), *options])


def test_a_table_gives_estimates_summary_and_pictures(table, capsys):
    pytest.importorskip('matplotlib')
    assert replay(table) == 0
    folder = table.parent / 'rig.csv_replay'
    assert f'{COUNT} estimates' in capsys.readouterr().out
    with (folder / 'estimates.csv').open() as file:
        rows = list(csv.DictReader(file))
    assert [float(row['t']) for row in rows] == [5.0, 7.5, 10.0, 12.5, 15.0]
    for row in rows:
        assert float(row['a']) == pytest.approx(5.0, abs=0.05)
        assert 0.0 < float(row['a_stddev']) < 0.05
        assert float(row['a_lower']) < float(row['a']) < float(row['a_upper'])
        assert float(row['residual_rms.y']) == pytest.approx(1e-4, rel=0.4)

    found = read_vectors(folder / 'estimates')
    topics = [topic for topic, *_ in found]
    doubts = ('state_stddev', 'parameters_stddev', 'parameters_interval')
    for name in ('state', 'parameters', *doubts, 'solver'):
        assert topics.count(f'/estimator/{name}') == COUNT
    values = [values for topic, _, _, values in found if topic == '/estimator/parameters']
    assert [v['a'] for v in values] == [float(row['a']) for row in rows]
    assert [s for topic, _, s, _ in found if topic == '/estimator/state'] == [
        int(row['stamp_ns']) for row in rows
    ]

    page = (folder / 'summary.md').read_text()
    assert '| `converged` | 5 |' in page
    assert '15.9 s of recording, 320 samples and 5 estimates' in page
    assert '## Jumps: 0' in page
    line = next(line for line in page.splitlines() if line.startswith('| a |'))
    assert '| m/s2 |' in line and line.endswith('| 5 of 5 |')
    assert next(line for line in page.splitlines() if line.startswith('| y |')).count('?') == 0
    report = (folder / command.REPORT).read_text()
    assert '<title>Replay of rig.csv</title>' in report and f'{COUNT} estimates' in report
    for name in command.PICTURES:
        picture = (folder / name).read_bytes()
        assert picture.startswith(b'\x89PNG') and len(picture) > 10_000


@pytest.mark.usefixtures('undrawn')
def test_a_bag_gives_the_estimates_of_the_table_bit_by_bit(table):
    with BagMaker(table.parent / 'bag') as bag:
        for t, u, y in zip(T, U, Y):
            stamp = round(t * 1e9)
            bag.vector('/plant/input', stamp, stamp, u=u)
            bag.vector('/plant/output', stamp + 1, stamp, y=y)
    assert replay(table) == 0
    assert replay(table.parent / 'bag') == 0
    one, other = (table.parent / f'{name}_replay' / 'estimates.csv' for name in ('rig.csv', 'bag'))
    assert one.read_bytes() == other.read_bytes()


def test_the_same_again_gives_the_same_bytes(table):
    written = []
    for name in ('one', 'two'):
        assert replay(table, '--output', str(table.parent / name)) == 0
        folder = table.parent / name
        files = ('estimates.csv', 'estimates/estimates.mcap', 'parameters.png')
        written.append([(folder / file).read_bytes() for file in files])
    assert written[0] == written[1]


@pytest.mark.usefixtures('undrawn')
def test_parameters_on_the_line_count_more_than_those_of_the_file(table, capsys):
    assert replay(table, '-p', 'window.period:=5.0', '-p', 'nonsense:=1') == 0
    streams = capsys.readouterr()
    assert '3 estimates' in streams.out
    assert "ignored, as there are no such parameters: 'nonsense'" in streams.err


@pytest.mark.usefixtures('undrawn')
def test_the_summary_compares_process_noise_unless_told_otherwise(table, capsys):
    page = table.parent / 'rig.csv_replay' / 'summary.md'
    columns = '|  | `process_noise` auto | `process_noise` off |'
    assert replay(table) == 0
    assert 'once more with process_noise:=off' in capsys.readouterr().out
    assert columns in page.read_text()
    assert '| outcomes | converged 5 | converged 5 |' in page.read_text()
    assert replay(table, '--force', '--compare', 'none') == 0
    assert '`process_noise` off' not in page.read_text()
    assert 'once more' not in capsys.readouterr().out
    assert replay(table, '--force', '--compare', 'window.period:=5.0') == 0
    assert '| every sd given | 5 of 5 | 3 of 3 |' in page.read_text()


@pytest.mark.usefixtures('undrawn')
def test_nothing_is_overwritten_unless_told_so(table, capsys):
    folder = table.parent / 'rig.csv_replay'
    assert replay(table) == 0
    before = (folder / 'estimates.csv').read_bytes()
    (folder / 'estimates.csv').write_bytes(b'mine')
    (folder / 'notes.txt').write_text('mine')
    assert replay(table) == 1
    assert 'exists and is not empty: --force to overwrite' in capsys.readouterr().err
    assert (folder / 'estimates.csv').read_bytes() == b'mine'
    assert replay(table, '--force') == 0
    assert (folder / 'estimates.csv').read_bytes() == before
    assert (folder / 'notes.txt').read_text() == 'mine'


@pytest.mark.parametrize(
    ('options', 'message'),
    [
        (['--period', '0.1'], "'t' tells the time already"),
        (['--column', 'y'], "--column 'y' is not of the form NAME=VALUE"),
        (['-p', 'model=x'], "'model=x' is not of the form name:=value"),
        (['-p', 'model:=no_such'], "unknown model 'no_such'"),
        (['-p', 'window.duration:=no'], 'window.duration must be a number, not False'),
        (['-p', 'search.method:=x'], "unknown search.method 'x'"),
        (['--compare', 'deadlin:=1.0'], "--compare: there is no parameter 'deadlin'"),
        (['--node', '/other/name'], 'nothing for the node /other/name'),
        (['--params', '/no/such/file'], '/no/such/file'),
    ],
)
def test_what_is_wrong_is_told_in_one_line(table, capsys, options, message):
    assert replay(table, *options) == 1
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert line.startswith('replay: ') and message in line
    assert not (table.parent / 'rig.csv_replay').exists()


def test_a_wrong_row_far_down_is_told_with_its_line(table, capsys):
    with table.open('a') as file:
        file.write('16.0,0.1\n')
    assert replay(table) == 1
    assert 'rig.csv:162: 2 fields, but 3 columns' in capsys.readouterr().err


@pytest.mark.usefixtures('undrawn')
def test_a_recording_shorter_than_a_window_says_so(table):
    assert replay(table, '-p', 'window.duration:=100.0') == 0
    page = (table.parent / 'rig.csv_replay' / 'summary.md').read_text()
    assert 'no window closed' in page and '## With another' not in page


def test_an_immediate_observer_is_replayed_too(table):
    assert replay(table, '-p', 'observer:=ekf', '-p', 'noise.y:=1e-4', '--column', 'y=y') == 0
    folder = table.parent / 'rig.csv_replay'
    page = (folder / 'summary.md').read_text()
    assert '160 estimates' in page and 'innovation' in page
    assert {file.name for file in folder.iterdir()} >= {'states.png', 'misfit.png'}


def test_without_rosbags_and_matplotlib_the_rest_is_written(table, capsys, monkeypatch):
    def missing(module, what):
        raise extras.MissingPackageError(f'{what} needs the package {module}')

    for place in ('writers', 'picture', 'bag'):
        module = __import__(f'obs_ros.replay.{place}', fromlist=['require'])
        monkeypatch.setattr(module, 'require', missing)
    assert replay(table) == 0
    streams = capsys.readouterr()
    assert 'no estimates: writing a bag needs the package rosbags' in streams.err
    assert 'drawing needs the package matplotlib' in streams.err
    files = {file.name for file in (table.parent / 'rig.csv_replay').iterdir()}
    assert files == {'estimates.csv', 'report.html', 'summary.md'}
    (table.parent / 'bag').mkdir()
    assert replay(table.parent / 'bag') == 1
    assert 'reading a bag needs the package rosbags' in capsys.readouterr().err


def test_it_starts_without_ros_and_without_its_own_extras(table):
    """As a process of its own, in which none of these can be imported."""
    blocked = ['rosbags', 'matplotlib', 'rclpy', 'sensor_msgs', 'builtin_interfaces', 'std_msgs']
    program = (
        'import sys\n'
        f'sys.modules.update(dict.fromkeys({blocked}))\n'
        'from obs_ros.cli.replay import main\n'
        'sys.exit(main(sys.argv[1:]))\n'
    )
    run = subprocess.run(
        [sys.executable, '-c', program, str(table), '--params', str(table.parent / 'rig.yaml')],
        cwd=ROOT, env={**os.environ, 'PYTHONPATH': f'{ROOT}:{ROOT / "test"}'},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert run.returncode == 0, run.stderr
    assert f'{COUNT} estimates' in run.stdout
    assert 'pip install rosbags' in run.stderr
    assert 'pip install matplotlib' in run.stderr


def test_it_runs_as_a_module():
    run = subprocess.run(
        [sys.executable, '-m', 'obs_ros.replay', '--help'],
        cwd=ROOT, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert '--params FILE' in run.stdout
