"""Tests of obs_ros.inference.process_noise."""

import numpy as np
from plants import OSCILLATOR, window_of

from obs_ros import Record, load_model
from obs_ros.core.prior_knowledge import with_knowledge
from obs_ros.inference.prior import Prior
from obs_ros.inference.process_noise import (
    SETTINGS,
    LearnedProcessNoise,
    ProcessNoise,
    groups_of,
    least_noise,
)
from obs_ros.inference.window_state import WindowState
from obs_ros.models.three_tank import THREE_TANK

T = np.linspace(0.0, 2.0, 41)


def posed(y: np.ndarray) -> WindowState:
    record = Record(T, np.zeros(T.size), y)
    objective = window_of(OSCILLATOR, record, 1.0)
    return WindowState(record, objective, Prior.box(objective.unknowns), noise_known=False)


def test_noise_has_a_floor() -> None:
    y = np.column_stack([np.sin(T), np.full(T.size, 3.0)])
    y[::3, 0] = np.nan
    spread = np.nanstd(y[:, 0])
    # Of an output that never moves nothing is known: a floor in its unit.
    np.testing.assert_allclose(
        least_noise(posed(y)), SETTINGS.least_noise * np.array([spread, 1.0]), rtol=1e-12
    )


def test_states_of_one_unit_share_a_walk() -> None:
    assert [group.tolist() for group in groups_of(load_model('three_tank'))] == [[0, 1, 2]]
    assert [group.tolist() for group in groups_of(OSCILLATOR)] == [[0], [1]]


def test_words_name_the_states_that_are_pushed_about() -> None:
    noise = ProcessNoise(np.array([0.0, 0.123, 0.0, 0.0]), np.ones(2))
    assert noise.words(OSCILLATOR) == (
        'pushed about by what the model leaves out: velocity by 0.12 m/s/sqrt(s)'
    )
    assert ProcessNoise(np.zeros(4), np.ones(2)).words(OSCILLATOR) == ''


def test_walks_are_the_medians_of_the_windows_that_had_any() -> None:
    learned = LearnedProcessNoise()
    assert learned.pooled is None and not learned.settled
    for walk in (0.1, 0.2, 0.9):
        learned.add(ProcessNoise(np.array([walk, 0.0]), np.array([1.0])))
    pooled = learned.pooled
    assert pooled is not None
    np.testing.assert_array_equal(pooled.walks, [0.2, 0.0])
    assert not learned.settled
    learned.add(pooled, sound=False)
    assert not learned.settled, 'of a window that leaves more to explain'
    learned.add(pooled)
    assert learned.settled


def test_a_parameter_that_walks_though_the_model_does_not_say_so_drifts() -> None:
    noise = ProcessNoise(np.array([0.0, 0.0, 0.0, 0.0, 0.03, 0.0]), np.ones(2))
    assert noise.drifting(THREE_TANK) == ('p2',)
    assert noise.words(THREE_TANK) == 'p2 drifts: give `walk.p2: 0.03`'
    walking = with_knowledge(THREE_TANK, {'p2': 0.01}, {})
    assert noise.drifting(walking) == () and noise.words(walking) == ''


def test_process_noise_is_usual_where_half_of_the_latest_windows_have_it() -> None:
    learned = LearnedProcessNoise()
    assert learned.usual, 'nothing is known yet'
    learned.note(True)
    learned.note(False)
    learned.note(False)
    assert learned.usual, 'one calm window aside'
    learned.note(False)
    assert not learned.usual
    for _ in range(6):
        learned.note(True)
    assert learned.usual, 'windows long ago count no more'
