"""Recorded plants: models that work, disjoint windows, forecasts of what followed."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from benchmarks.real_plants.__main__ import main
from benchmarks.real_plants.acceptance import acceptance
from benchmarks.real_plants.pictures import last_errors, told
from benchmarks.real_plants.run import Solved, in_sequence, solved
from benchmarks.real_plants.scores import (
    factors,
    good_share,
    near_share,
    scatter_over_sd,
    together,
)
from benchmarks.recordings import BALL, OVERLAP, PLANTS, recorded, starts
from obs_ros import Record
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid

A, B, C = 4.0, 0.3, 0.05


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A recording of a ball that its model explains, but for .1 mm of noise."""
    t = 0.1 * np.arange(500)
    u = 0.02 * np.sign(np.cos(0.4 * t)) - C / A
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
    assert 0.0 < abs(found.soon[0]) < 2e-3 and 0.0 < found.till_soon[0] < 2e-3
    late = solved('ball and beam', str(folder), 'off', 29.9)
    assert np.isnan(late.forecast['a window']).all() and np.isnan(late.hold['a window']).all()


def test_a_sequence_has_the_windows_that_are_solved_alone(folder: Path) -> None:
    times = starts(PLANTS['ball and beam'], recorded('ball and beam', folder))
    sequence = in_sequence('ball and beam', str(folder), 'off')
    first = solved('ball and beam', str(folder), 'off', times[0])
    assert len(sequence) == len(times)
    np.testing.assert_allclose(sequence[0].values, first.values, atol=1e-3)
    np.testing.assert_allclose(sequence[-1].values, [A, B, C], atol=0.05)


def windows(count: int, spread: float, shift: float = 0.0, factor: float = np.nan) -> list[Solved]:
    rng = np.random.default_rng(2)
    error = {'an eighth': np.array([0.1 + shift]), 'a window': np.array([0.2])}
    return [
        Solved(
            values=spread * rng.standard_normal(3) + shift,
            sd=np.ones(3),
            outcome='converged',
            message='',
            seconds=0.1,
            forecast=error,
            hold=error,
            soon=np.array([0.008 + shift]),
            till_soon=np.array([0.008]),
            factor=np.full(3, factor),
        )
        for _ in range(count)
    ]


def test_scatter_is_told_in_units_of_the_deviations() -> None:
    np.testing.assert_allclose(scatter_over_sd(windows(400, 2.0)), 2.0, rtol=0.1)
    withheld = [one._replace(sd=np.array([np.nan, 1.0, 1.0])) for one in windows(400, 1.0)]
    assert np.isnan(scatter_over_sd(withheld)[0]) and good_share(withheld) == 0.0
    assert np.isnan(scatter_over_sd(windows(8, 1.0))).all()


def test_values_keep_to_those_alone_or_do_not() -> None:
    alone = windows(40, 1.0)
    assert near_share(windows(40, 1.0, shift=2.9), alone, 3.0) == 1.0
    far = windows(40, 1.0, shift=3.1)
    assert near_share(far, alone, 3.0) == near_share(far, alone, 3.0, larger=True) == 0.0
    loose = [one._replace(sd=2.0 * one.sd) for one in alone]
    assert (near_share(far, loose, 3.0), near_share(far, loose, 3.0, larger=True)) == (0.0, 1.0)


def test_the_factor_of_the_first_half_stands_beside_the_scatter_of_the_second() -> None:
    shown, needed = factors(windows(800, 3.0, factor=2.0), windows(800, 3.0))
    np.testing.assert_array_equal(shown, 2.0)
    np.testing.assert_allclose(needed, 3.0, rtol=0.2)
    assert np.isnan(factors(windows(800, 3.0), windows(800, 3.0))[0]).all()
    assert np.isnan(factors(windows(4, 3.0), windows(4, 3.0))[1]).all()


def test_errors_in_different_units_go_together_by_their_product() -> None:
    assert together(np.array([0.1, 10.0])) == pytest.approx(1.0)


def judged(name: str, **changed: list[Solved]) -> list[bool]:
    own = windows(800, 1.0, factor=1.0)
    cells = {(name, mode, 'alone'): own for mode in ('off', 'auto')}
    cells[name, 'auto', 'in sequence'] = own
    cells |= {(name, 'auto', way.replace('_', ' ')): each for way, each in changed.items()}
    return [row.met for row in acceptance(cells)]


def test_what_is_asked_is_judged() -> None:
    assert judged('ball and beam') == [True] * 5
    far = judged('ball and beam', alone=windows(800, 1.0, shift=0.002))
    assert far == [True, True, True, False, True]
    wide = judged('ball and beam', alone=windows(800, 2.0))
    assert wide == [True, True, False, True, True]
    assert judged('heater board') == [True] * 9
    # Parameters of a sequence that scatter beyond their deviations, that show no factor, that are
    # off those alone, and forecast worse.
    bad = judged('heater board', in_sequence=windows(800, 3.0, shift=5.0))
    assert bad == [True, True, True, False, False, False, False, False, True]


def test_forecasts_of_the_picture_abut_and_meet_what_was_measured(folder: Path) -> None:
    whole = recorded('ball and beam', folder)
    windows = told(whole, 'off')
    ends = [one.end for one in windows]
    np.testing.assert_allclose(np.diff(ends), 1.0)
    np.testing.assert_allclose([one.forecast[0, 0] for one in windows], ends)
    np.testing.assert_allclose([one.forecast[-1, 0] for one in windows], np.add(ends, 1.0))
    assert ends[0] == pytest.approx(19.9) and ends[-1] == pytest.approx(47.9)
    inside = windows[:4]  # later the ball leaves the beam of the model
    assert np.abs([one.a - A for one in inside]).max() < 1e-3
    assert np.abs(last_errors(whole, inside)).max() < 1e-3  # m


def test_without_recordings_it_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(['--data', str(tmp_path / 'nowhere'), '--results', str(tmp_path)]) == ''
    assert 'no recording is there: name their folder with --data' in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_the_command_reports_what_is_there(folder: Path) -> None:
    text = main(['--data', str(folder), '--results', str(folder)])
    assert '| ball and beam | auto | 6 alone | ' in text and '| 6 in sequence |' in text
    assert 'battery' not in text
    if importlib.util.find_spec('matplotlib'):
        assert '(real_plants_ball.png)' in text
        assert (folder / 'real_plants_ball.png').stat().st_size > 20_000
