"""Sensors as they are: faults put in, scores of windows, judgements, what fails or is left out."""

import dis
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.recordings import PLANTS
from benchmarks.sensors import angles, coarse, delays, functions, spiked, spikes
from benchmarks.sensors.__main__ import left_out, main
from benchmarks.sensors.attempts import Failure, attempted, carried_out, judged
from benchmarks.sensors.scores import (
    accepted,
    coverage,
    efficiency,
    median_ratio,
    rms_ratio,
    worst_ratio,
)
from benchmarks.sensors.solved import Solved, alone, in_sequence
from benchmarks.sensors.spring import INTERVAL, NOISE, SAMPLES, SPRING, run
from benchmarks.sensors.ways import PLAIN, WAYS, model
from plant_sim.actuators import Actuator
from plant_sim.sensors import Sensor


def window(error: tuple[float, ...], sd: float = 1.0, **changes: object) -> Solved:
    """A window whose true parameters are 0."""
    off, half = np.array(error), 1.96 * sd
    found = Solved(
        values=off, error=off, sd=np.full(off.size, sd), lower=off - half, upper=off + half,
        state=off, outcome='converged', message='', jumps=0, seconds=0.1,
    )  # fmt: skip
    return found._replace(**changes)


def windows(scale: float, count: int = 400, seed: int = 1) -> list[Solved]:
    rng = np.random.default_rng(seed)
    return [window(tuple(scale * rng.standard_normal(2))) for _ in range(count)]


def fails(words: str) -> None:
    raise ValueError(words)


def test_a_run_that_fails_is_told_and_does_not_meet_what_is_asked() -> None:
    found = attempted(fails, 'no | such\nthing')
    assert found == Failure('ValueError: no | such thing')
    zero, fine = carried_out(divmod, {'both': [(7, 0), (7, 2)]}, 'runs')['both']
    assert isinstance(zero, Failure) and 'ZeroDivisionError' in zero.words and fine == (3, 1)
    row = judged('all is well', [1, found], lambda results: ('never', True))
    assert row == (
        'all is well', '1 of 2 runs failed: ValueError: no / such thing', False
    )  # fmt: skip
    assert not judged('all is well', [], lambda results: ('never', True)).met
    assert judged('all is well', [1, 2], lambda own: (f'{sum(own)}', sum(own) == 3)).met


def test_scores_of_windows() -> None:
    clean, twice = windows(1.0), windows(2.0)
    ratio, low, high = rms_ratio(twice, clean)
    assert ratio == pytest.approx(2.0) and low == pytest.approx(high)
    assert efficiency(twice, clean)[0] == pytest.approx(0.25)
    assert worst_ratio(twice, clean) == pytest.approx(2.0)
    share, low, high = coverage(clean)
    assert low < 0.95 < high and abs(share - 0.95) < 0.03
    assert coverage(twice)[2] < 0.8
    assert median_ratio([2.0, 3.0, 4.0], [1.0, 1.0, 1.0])[0] == 3.0
    withheld = window((0.0, 0.0), sd=np.nan)
    assert accepted([*clean, withheld])[0] == pytest.approx(400 / 401)
    assert not window((0.0,), outcome='approximate').accepted
    assert math.isnan(coverage([withheld])[0])


def test_faults_of_the_spring_leave_its_plant_and_noise_alone() -> None:
    clean = run(5)
    again = run(5, sensor=Sensor(outlier_rate=0.1))
    assert clean.truth == again.truth
    np.testing.assert_array_equal(clean.x, again.x)
    late = run(5, sensor=Sensor(delay=2.0 * INTERVAL)).record.y - run(5).record.y
    moved = clean.x[:-2, 0] - clean.x[2:, 0]
    np.testing.assert_allclose(late[2:, 0], moved, atol=1e-6)
    dead = run(5, actuator=Actuator(delay=0.1))
    np.testing.assert_array_equal(dead.record.u, clean.record.u)
    assert np.abs(dead.x - clean.x).max() > 10.0 * NOISE
    # 40 dB below the positions.
    assert 0.5 < np.std([run(seed).x[:, 0].std() for seed in range(8)]) / NOISE < 100.0


@pytest.mark.parametrize(
    ('kind', 'least', 'most'),
    [
        ('one spike of 10 sigma', 1, 1),
        ('one spike of 100 sigma', 1, 1),
        ('a spike every 2 s', 1, 2),
        ('a burst of 10 samples', 10, 10),
        ('dropouts to zero', 0, 12),
        ('1 % outliers of 5-100 sigma', 0, 8),
        ('3 % outliers of 5-100 sigma', 0, 14),
    ],
)
def test_each_window_has_the_outliers_that_are_said(kind: str, least: int, most: int) -> None:
    clean, bad = spikes.spoiled(spikes.CLEAN, 3), spikes.spoiled(kind, 3)
    changed = (clean.record.y != bad.record.y).reshape(-1, SAMPLES).sum(axis=1)
    assert changed.size == spikes.IN_RUN
    assert least <= changed.min() and changed.max() <= most and changed.any()
    off = np.abs(bad.record.y - clean.record.y)[clean.record.y != bad.record.y] / NOISE
    if kind != 'dropouts to zero':
        assert off.min() >= 5.0 and off.max() <= 100.0 + 1e-9


def test_clean_windows_meet_what_is_asked_of_them() -> None:
    """Alone and in sequence the same windows; errors as their deviations say."""
    drawn = run(7, 4 * SAMPLES)
    noise = {'y': NOISE}
    one = [alone(SPRING, each, drawn.truth, 1, noise=noise) for each in drawn.windows()]
    other = in_sequence(SPRING, drawn.windows(), drawn.truth, 1, noise=noise)
    assert len(one) == len(other) == 4 and all(each.accepted for each in one + other)
    np.testing.assert_allclose(one[0].values, other[0].values, rtol=1e-3)
    assert np.abs([each.error / each.sd for each in one]).max() < 4.0


def test_headings_wrap_and_are_the_same_unwrapped() -> None:
    for scene in angles.SCENES:
        wrapped, free = (angles.sailed(scene, 2, wrapped=wraps).record for wraps in (True, False))
        assert np.abs(wrapped.y).max() <= math.pi
        turned = free.y - angles.TURN * np.floor(free.y[0] / angles.TURN + 0.5)
        np.testing.assert_allclose(angles.shifted(wrapped).y, turned, atol=1e-9)
        wraps = int((np.abs(np.diff(wrapped.y[:, 0])) > math.pi).sum())
        assert wraps >= {'crossing': 1, 'hovering at pi': 3, 'many turns': 3}[scene], scene


def test_windows_are_apart_by_deviations_and_by_what_they_determine() -> None:
    one, other = window((1.0, 2.0)), window((1.0, 2.5))
    assert angles.apart([one, one], [one, other]) == pytest.approx([0.0, 0.5])
    withheld = window((1.0, 2.0), sd=np.nan)
    assert angles.apart([withheld], [one])[0] == math.inf
    assert angles.apart([withheld], [withheld])[0] == 0.0


def test_suggestions_are_read() -> None:
    assert delays.said(['', 'all is well; y looks 48.2 ms late'])
    assert delays.said(['force looks 55 ms late'])
    for other in ('y is late', 'y looks 20 ms late', 'y looks 50 ms early', 'x looks 50 ms late'):
        assert not delays.said([other])
    for kind in delays.KINDS:
        drawn = delays.late(kind, 1.5, 3)
        assert np.isfinite(drawn.record.y).sum() == delays.SAMPLES


def test_sensors_are_as_coarse_and_narrow_as_said() -> None:
    rounded = run(3, sensor=coarse.KINDS['8-bit converter'].sensor).record.y / coarse.STEP
    np.testing.assert_allclose(rounded, np.round(rounded), atol=1e-9)
    held = run(3, 1500, sensor=coarse.KINDS['saturating sensor'].sensor).record.y
    assert (held.min(), held.max()) == coarse.LIMITS
    assert 0.1 < np.isin(held, coarse.LIMITS).mean() < 0.7


def operations(function: Any) -> int:
    """The number of operations in a function's code."""
    work = ('BINARY_OP', 'COMPARE_OP', 'UNARY_NEGATIVE', 'CALL')
    return sum(step.opname in work for step in dis.get_instructions(function))


@pytest.mark.parametrize('way', WAYS)
def test_every_way_of_writing_comes_to_the_same_operations(way: str) -> None:
    plain, other = model(PLAIN), model(way)
    for place in (2.5, 0.5, -2.5):
        at = 0.0, (place, -1.5), (2.0 * place,), (9.0, 0.8)
        np.testing.assert_allclose(other.dynamics(*at), plain.dynamics(*at), rtol=1e-12)
        np.testing.assert_allclose(other.output(*at), plain.output(*at), rtol=1e-12)
    assert operations(other.dynamics) <= functions.TIME * operations(plain.dynamics)


@pytest.mark.slow
def test_the_plain_way_of_writing_finds_the_truth() -> None:
    found = functions.written(PLAIN, 1)
    assert found.accepted and np.abs(found.error / found.sd).max() < 4.0


@pytest.fixture
def board(tmp_path: Path) -> Path:
    """A recording of a heater board that stays nearly where it is."""
    rng, t = np.random.default_rng(1), 5.0 * np.arange(900)
    heat = 25.0 + 25.0 * (t // 400.0 % 2)
    level = 40.0 + 0.2 * rng.standard_normal((t.size, 2))
    columns = np.column_stack([t, heat, level])
    rows = '\n'.join(','.join(f'{value:.4f}' for value in row) for row in columns)
    (tmp_path / PLANTS['heater board'].file).write_text(f't,heat,t1,t2\n{rows}\n')
    return tmp_path


def test_recordings_are_spiked_by_their_noise(board: Path) -> None:
    clean, bad = (spiked.record('heater board', board, kind) for kind in spiked.KINDS)
    noise = spiked.noise(clean.y)
    np.testing.assert_allclose(noise, 0.2, rtol=0.15)
    off = np.abs(bad.y - clean.y) / noise
    share = float((off > 1e-9).mean())
    assert 0.003 < share < 0.02
    assert off[off > 1e-9].min() >= 5.0 - 1e-6 and off.max() <= 30.0 + 1e-6
    steps = np.round(clean.y)
    assert (spiked.noise(steps) >= 0.25).all()


def test_errors_of_forecasts_are_compared_over_all_outputs() -> None:
    def forecasts(scale: float, seed: int = 1) -> list[list[spiked.Forecasts]]:
        sizes = np.random.default_rng(seed).uniform(1.0, 2.0, (41, 2)) * (1.0, scale)
        sizes[-1] = np.nan  # beyond the recording
        return 2 * [[spiked.Forecasts({'a window': row}, 'converged') for row in sizes]]

    ratio, low, high = spiked.error_ratio(forecasts(16.0), forecasts(1.0), 'a window')
    assert ratio == pytest.approx(2.0) and low == pytest.approx(high) == pytest.approx(2.0)
    ratio, low, high = spiked.error_ratio(forecasts(1.0, seed=2), forecasts(1.0), 'a window')
    assert low < 1.0 < high and ratio == pytest.approx(1.0, abs=0.05)


@pytest.mark.slow
def test_recordings_are_solved_clean_and_spiked(board: Path) -> None:
    rows, text = spiked.measured(board, most=2)
    assert len(rows) == 4 and all('forecast over' in row.asked for row in rows)
    assert text.count('| heater board |') == 4 and '| 2 alone |' in text and '| 8 alone |' in text


def test_recordings_that_are_not_there_are_told(board: Path, tmp_path: Path) -> None:
    assert left_out(['outliers', 'coarse'], board) == []
    missing = left_out(['recordings', 'angles', 'coarse'], tmp_path / 'nowhere')
    assert len(missing) == 4 and all('left out, there is no' in line for line in missing)


@pytest.mark.slow
def test_the_command_reports_every_row_asked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    chosen = ['--only', 'outliers', 'coarse', '--runs', '1', '--data', str(tmp_path / 'nowhere')]
    text = main([*chosen, '--results', str(tmp_path)])
    assert 'coarse: left out, there is no' in text and 'left out' in capsys.readouterr().err
    assert text.count(': no jump') == 5 and text.count('RMS error <= 1.15 x clean') == 8
    assert text.count('8-bit converter, noise') == 4
    assert '| clean | given, alone | 10 |' in text
    assert (tmp_path / 'sensors.md').read_text() == text
