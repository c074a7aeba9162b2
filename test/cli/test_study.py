"""`replay` of several recordings and variants."""

import csv
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from dask_processes import distributed
from patience import patience
from study_runs import parameter_file, recordings

from obs_ros.cli import replay as command
from obs_ros.cli import study
from obs_ros.replay.extras import MissingPackageError
from obs_ros.studies import cluster

ROOT = Path(__file__).parents[2]
VARY = ('--vary', 'seed=0,1')
FAST = ('-p', 'observer:=ekf', '-p', 'noise.y:=1e-4')


@pytest.fixture
def tables(tmp_path):
    parameter_file(tmp_path)
    return recordings(tmp_path, 3)


@pytest.fixture(autouse=True)
def _signals_stay(monkeypatch):
    monkeypatch.setattr(command.signal, 'signal', lambda *_: None)


@pytest.fixture
def undrawn(monkeypatch):
    monkeypatch.setattr(study, 'draw', lambda *_: [])


def replay(tables, *options):
    line = [*map(str, tables), '--params', str(tables[0].parent / 'rig.yaml'), *options]
    return command.main(line)


def files(folder):
    """Return results by name: which file each is, so that one written anew is another."""
    return {path.name: path.stat().st_ino for path in (folder / 'results').iterdir()}


def test_several_recordings_and_variants_give_one_table_and_a_summary(tables, capsys):
    pytest.importorskip('matplotlib')
    assert replay(tables, '--vary', 'process_noise=off,auto') == 0
    folder = tables[0].parent / 'study'
    told = capsys.readouterr().out
    assert '3 recordings, 2 variants: 6 runs, 0 of them done already' in told
    assert '18 estimates in 6 runs, 0 without a result' in told
    with (folder / 'estimates.csv').open() as file:
        rows = list(csv.DictReader(file))
    assert [(row['recording'], row['process_noise']) for row in rows[::3]] == [
        (f'rig{k}.csv', way) for k in (1, 2, 3) for way in ('off', 'auto')
    ]
    assert all(float(row['a']) == pytest.approx(5.0, abs=0.1) for row in rows)
    page = (folder / 'summary.md').read_text()
    assert 'model `ball_and_beam:BALL`, observer `sliding_window`, window.duration `5`' in page
    assert '| process_noise=off | 9 |' in page and '| process_noise=auto | 9 |' in page
    assert '![variants.png](variants.png)' in page
    assert (folder / 'variants.png').read_bytes().startswith(b'\x89PNG')


@pytest.mark.usefixtures('undrawn')
def test_a_second_call_does_only_what_is_new(tables, capsys):
    folder = tables[0].parent / 'study'
    assert replay(tables[:2], *FAST, *VARY) == 0
    first, table = files(folder), (folder / 'estimates.csv').read_bytes()
    assert len(first) == 4
    assert replay(tables[:2], *FAST, *VARY) == 0
    assert '4 runs, 4 of them done already' in capsys.readouterr().out
    assert files(folder) == first and (folder / 'estimates.csv').read_bytes() == table
    assert replay(tables, *FAST, '--vary', 'seed=0,1,2') == 0
    assert '9 runs, 4 of them done already' in capsys.readouterr().out
    assert first.items() <= files(folder).items() and len(files(folder)) == 9
    assert replay(tables[:2], *FAST, *VARY, '--force') == 0
    assert '4 runs, 0 of them done already' in capsys.readouterr().out
    assert (folder / 'estimates.csv').read_bytes() == table


@pytest.mark.usefixtures('undrawn')
def test_a_recording_that_cannot_be_read_is_told_and_the_others_go_on(tables, capsys):
    broken = tables[0].with_name('broken.csv')
    broken.write_text('t,u,y\n0.0\n')
    missing = tables[0].with_name('rig9.csv')
    folder = tables[0].with_name('study')
    folder.mkdir()
    assert replay([tables[0], broken, missing, folder], *FAST) == 1
    streams = capsys.readouterr()
    assert 'rig9.csv does not exist: did you mean' in streams.err
    assert 'replay: broken.csv: ' in streams.err and ':2: 1 fields, but 3 columns' in streams.err
    assert '110 estimates in 1 runs, 2 without a result' in streams.out
    assert '## Without a result: 2' in (folder / 'summary.md').read_text()


@pytest.mark.parametrize(
    ('options', 'message'),
    [
        (['--vary', 'sed=1,2'], "--vary: there is no parameter 'sed'"),
        (['--vary', 'seed'], 'is not of the form NAME=A,B'),
        (['--jobs', '0'], '--jobs must be 1 to 256'),
        (['--jobs', '2', '--scheduler', 'tcp://127.0.0.1:1'], 'not both'),
        (['--vary', 'seed=1,2', '--compare', 'none'], '--compare is for one recording'),
    ],
)
def test_what_is_wrong_is_told_in_one_line_before_anything_is_written(
    tables, capsys, options, message
):
    assert replay(tables, *options) == 1
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert line.startswith('replay: ') and message in line
    assert not tables[0].with_name('study').exists()


def test_a_folder_of_something_else_stays(tables, capsys):
    folder = tables[0].with_name('mine')
    folder.mkdir()
    (folder / 'notes.txt').write_text('mine')
    assert replay(tables, *FAST, '--output', str(folder)) == 1
    assert 'exists and is no study: --force to write there' in capsys.readouterr().err
    assert [path.name for path in folder.iterdir()] == ['notes.txt']


@pytest.mark.usefixtures('undrawn')
def test_packages_that_are_missing_are_told_in_words(tables, capsys, monkeypatch):
    def missing(module, what):
        raise MissingPackageError(f'{what} needs the package {module}: pip install {module}')

    monkeypatch.setattr('obs_ros.studies.tables.require', missing)
    monkeypatch.setattr(cluster, 'require', missing)
    assert replay(tables, *FAST) == 0
    assert 'no estimates.parquet: writing Parquet needs the package pyarrow' in (
        capsys.readouterr().err
    )
    assert replay(tables, *FAST, '--vary', 'seed=5', '--jobs', '2') == 1
    assert '--jobs or --scheduler needs the package distributed' in capsys.readouterr().err


@pytest.mark.slow
def test_ctrl_c_keeps_what_is_done_and_the_next_call_goes_on(tables):
    """In all processes at once, as a terminal does: one line, and nobody is left."""
    distributed()
    folder = tables[0].with_name('study')
    line = [
        sys.executable, '-m', 'obs_ros.replay', *map(str, tables), '--params',
        str(tables[0].with_name('rig.yaml')), '--vary', f'seed={",".join(map(str, range(20)))}',
    ]  # fmt: skip
    environment = {**os.environ, 'PYTHONPATH': f'{ROOT}:{ROOT / "test"}'}

    def start(*options):
        return subprocess.Popen(
            [*line, *options], env=environment, text=True, stdout=subprocess.PIPE,
            stderr=subprocess.PIPE, start_new_session=True,
        )  # fmt: skip

    run = start('--jobs', '2')
    end = time.monotonic() + patience(60.0)
    while len([*folder.glob('results/*.result')]) < 3:
        assert time.monotonic() < end and run.poll() is None
        time.sleep(0.02)
    os.killpg(run.pid, signal.SIGINT)
    _, errors = run.communicate(timeout=patience(30.0))
    *_, last = errors.strip().splitlines()
    assert run.returncode == 130
    assert last.startswith('replay: stopped; ') and last.endswith('goes on from there')
    assert 'Traceback' not in errors
    kept = files(folder)
    assert 3 <= len(kept) < 60
    run = start('--jobs', '2')
    out, errors = run.communicate(timeout=patience(120.0))
    assert run.returncode == 0, errors
    assert f'60 runs, {len(kept)} of them done already' in out
    assert len(files(folder)) == 60 and kept.items() <= files(folder).items()
    parallel = (folder / 'estimates.csv').read_bytes()
    run = start('--output', str(folder.with_name('serial')))
    out, errors = run.communicate(timeout=patience(120.0))
    assert run.returncode == 0, errors
    assert (folder.with_name('serial') / 'estimates.csv').read_bytes() == parallel
