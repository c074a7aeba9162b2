"""Recorded plants: models that work, disjoint windows, forecasts of what followed."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.real_plants.__main__ import main
from benchmarks.real_plants.plants import BALL, PLANTS
from benchmarks.real_plants.run import OVERLAP, recorded, solved, starts
from obs_ros import Record
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid

A, B, C = 4.0, 0.3, 0.05


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A recording of a ball that its model explains, but for .1 mm of noise."""
    t = 0.1 * np.arange(500)
    u = 0.05 * np.sign(np.sin(0.4 * t)) - C / A
    grid = Grid.of(BALL, Record(t, u, np.zeros((t.size, 1))), np.ones(1))
    p = np.array([[A], [B], [C]])
    y = kernels_for(BALL).trajectories(grid, np.zeros((2, 1)), p)[1][:, 0, 0]
    y = y + 1e-4 * np.random.default_rng(1).standard_normal(y.size)
    rows = '\n'.join(f'{a:.9g},{b:.9g}' for a, b in zip(u, y, strict=True))
    (tmp_path / 'ball_and_beam.csv').write_text(f'u,y\n{rows}\n')
    return tmp_path


def test_a_window_finds_what_was_recorded_and_forecasts_what_followed(folder: Path) -> None:
    plant = PLANTS['ball and beam']
    record = recorded('ball and beam', folder)
    times = starts(plant, record)
    assert record.t.size == 500 and times[OVERLAP] - times[0] == pytest.approx(plant.window)
    found = solved('ball and beam', str(folder), 'off', times[0])
    np.testing.assert_allclose(found.values, [A, B, C], atol=0.05)
    assert found.forecast['an eighth'][0] < 2e-3 < found.hold['an eighth'][0]
    late = solved('ball and beam', str(folder), 'off', 29.9)
    assert np.isnan(late.forecast['a window']).all() and np.isnan(late.hold['a window']).all()


def test_without_recordings_it_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(['--data', str(tmp_path / 'nowhere'), '--results', str(tmp_path)]) == ''
    assert 'no recording is there: name their folder with --data' in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_the_command_reports_what_is_there(folder: Path) -> None:
    text = main(['--data', str(folder), '--results', str(folder)])
    assert '| ball and beam | auto | 6 | ' in text and 'battery' not in text
