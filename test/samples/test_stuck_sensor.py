import numpy as np
import pytest

from obs_ros.models.three_tank import THREE_TANK
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
