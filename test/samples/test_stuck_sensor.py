from dataclasses import replace

import numpy as np
import pytest

from obs_ros import Variable
from obs_ros.models.three_tank import THREE_TANK
from obs_ros.samples.resolution import Resolutions
from obs_ros.samples.stuck_sensor import Repeats, StuckSettings, long_runs, stuck, words

REPEATS = StuckSettings().repeats
RNG = np.random.default_rng(3)


def noisy(rows: int, columns: int = 2) -> np.ndarray:
    return RNG.standard_normal((rows, columns))


def frozen(y: np.ndarray, column: int, first: int, last: int) -> np.ndarray:
    y = y.copy()
    y[first : last + 1, column] = y[first, column]
    return y


@pytest.mark.parametrize('known', [True, False])
def test_a_run_of_one_output_while_another_moves_is_stuck(known):
    mask = stuck(frozen(noisy(60), 1, 20, 40), [known, known])
    assert np.flatnonzero(mask[:, 1]).tolist() == list(range(20, 41))
    assert not mask[:, 0].any()


@pytest.mark.parametrize('known', [True, False])
def test_all_at_rest_are_stuck_only_where_there_should_be_noise(known):
    mask = stuck(np.tile([3.0, 4.0], (50, 1)), [known, known])
    assert mask.all() == known and mask.any() == known


def test_a_run_must_be_long():
    y = noisy(60)
    assert stuck(frozen(y, 0, 20, 20 + REPEATS - 1), [True] * 2)[:, 0].sum() == REPEATS
    assert not stuck(frozen(y, 0, 20, 20 + REPEATS - 2), [True] * 2).any()


def test_a_sensor_that_rounds_is_not_stuck():
    slow = np.round(np.column_stack([np.linspace(0, 1, 400), np.linspace(0, 4, 400)]), 1)
    slow[:, 1] += noisy(400, 1)[:, 0]
    slow[::7, 0] += 0.1
    assert not stuck(slow, [True, True])[:, 0].any()


def test_what_was_not_measured_neither_breaks_a_run_nor_is_stuck():
    y = frozen(noisy(60), 0, 10, 59)
    y[12::5, 0] = np.nan
    mask = stuck(y, [False, False])
    assert mask[10:, 0].sum() == np.isfinite(y[10:, 0]).sum()
    assert not mask[np.isnan(y[:, 0]), 0].any()


def test_runs_at_the_edges_of_a_window_tell_nothing_of_rounding():
    y = frozen(frozen(noisy(60), 0, 0, 3), 0, 20, 40)
    assert long_runs(y[:, 0], REPEATS) == [(20, 40)]


def test_value_after_value_it_is_the_same():
    repeats = Repeats([False, False])
    y = frozen(noisy(60), 1, 20, 40)
    found = [repeats.note(row) for row in y]
    # The first ones cannot be known for what they are.
    assert [k for k, stuck in enumerate(found) if stuck] == list(range(20 + REPEATS - 1, 41))
    assert set(found) == {(), (1,)}


@pytest.mark.parametrize('known', [True, False])
def test_value_after_value_all_at_rest(known):
    repeats = Repeats([known, known])
    found = [repeats.note(np.array([3.0, 4.0])) for _ in range(30)]
    assert found[REPEATS - 2] == ()
    assert found[-1] == ((0, 1) if known else ())
    repeats.clear()
    assert repeats.note(np.array([3.0, 4.0])) == () == repeats.stuck


def test_value_after_value_a_sensor_that_rounds_is_not_stuck():
    repeats = Repeats([True, True])
    values = np.repeat(np.arange(20.0), 3)
    rows = np.column_stack([values, noisy(60, 1)[:, 0]])
    assert not any(repeats.note(row) for row in rows)
    assert not any(repeats.note(np.array([7.0, x])) for x in noisy(40, 1)[:, 0])


def test_the_words_name_the_sensor():
    assert words(THREE_TANK, [0, 1]) == (
        'look at the sensors: h1 and h2 repeat the same value, not taken for measured'
    )


def coarse_walk(rows: int, step: float, noise: float) -> np.ndarray:
    """A slow signal that a sensor rounds, beside one that moves."""
    slow = 20.0 + 10.0 * np.sin(np.arange(rows) / 200.0) + noise * RNG.standard_normal(rows)
    return np.column_stack([np.round(slow / step) * step, RNG.standard_normal(rows)])


@pytest.mark.parametrize('noise', [0.0, 0.05])
def test_a_sensor_whose_step_is_learned_or_declared_repeats_values_as_it_likes(noise):
    y = coarse_walk(3000, 1.0, noise)
    y = y[np.insert(np.diff(y[:, 0]) == 0.0, 0, True)] if noise else y  # no short runs
    assert stuck(y, [True, True])[:, 0].sum() > 100
    learned, declared = (Resolutions([Variable('a', resolution=step), Variable('b')])
                         for step in (None, 1.0))  # fmt: skip
    learned.note(y)
    for resolutions in (learned, declared):
        assert not stuck(y, [True, True], resolutions=resolutions).any()


@pytest.mark.parametrize('given', [3.0, np.nan])
def test_a_sensor_that_rounds_more_finely_than_its_noise_is_stuck_all_the_same(given):
    y = np.round(20.0 + 3.0 * noisy(4000))
    y = y[np.insert(np.diff(y[:, 0]) != 0.0, 0, True)][:2000]  # no short runs
    y = frozen(y, 0, 1500, 1999)
    resolutions = Resolutions([Variable('a'), Variable('b')])
    resolutions.note(y)
    noise = np.array([given, given])
    mask = stuck(y, [True, True], resolutions=resolutions, noise=noise)
    assert np.flatnonzero(mask[:, 0]).tolist() == list(range(1500, 2000))


def test_value_after_value_a_step_is_known_too():
    for declared in (None, 1.0):
        repeats = Repeats([True, True], outputs=[Variable('a', resolution=declared), Variable('b')])
        y = coarse_walk(3000, 1.0, 0.0)
        found = [repeats.note(row) for row in y]
        # A step that is learned takes its time.
        assert not any(found[2000:]) and (any(found) if declared is None else not any(found))
        assert repeats.resolutions.learned == ({} if declared else {'a': 1.0})


def test_a_sensor_at_the_end_of_its_range_is_not_stuck():
    repeats = Repeats.of(THREE_TANK, [0.1, 0.1])
    ranged = replace(THREE_TANK.outputs[0], range=(0.0, 10.0))
    saturated = Repeats.of(replace(THREE_TANK, outputs=(ranged, THREE_TANK.outputs[1])), [0.1, 0.1])
    rows = np.column_stack([np.full(30, 10.0), noisy(30, 1)[:, 0]])
    assert repeats.note(rows[0]) == ()
    assert any(repeats.note(row) for row in rows)
    assert not any(saturated.note(row) for row in rows)
