"""Tests of obs_ros.integration.input_path."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from obs_ros.core.interpolation import segments
from obs_ros.core.model import Interpolation
from obs_ros.core.typing import Array
from obs_ros.integration.input_path import InputPath, Pieces

T = 0.1 * np.arange(31)
KINDS: tuple[Interpolation, ...] = ('hold', 'linear', 'mean')


def path(kind: Interpolation = 'hold', seed: int = 0) -> InputPath:
    u = np.random.default_rng(seed).standard_normal((T.size, 2)) + 100.0
    return InputPath(T, *segments(T, u, [kind, kind]))


def value(path: InputPath, column: int, at: Array) -> Array:
    k = np.maximum(np.searchsorted(path.t, at, side='right') - 1, 0)
    return path.u[k, column] + np.maximum(at - path.t[k], 0.0) * path.slope[k, column]


@pytest.mark.parametrize('kind', KINDS)
def test_late_inputs_are_straight_lines_in_every_piece(kind: Interpolation) -> None:
    inputs, delays = path(kind), np.array([0.0, 0.013, 0.25, -0.08, 50.0])
    changes = inputs.changes(1)
    pieces = Pieces.of(T, [changes.t[1:, None] + delays], delays.size)
    u, slope = changes.after(pieces.changed[0], pieces.t - delays)
    for share in (0.01, 0.5, 0.99):
        after = share * np.diff(pieces.t, axis=0)
        line = u[:-1] + after * slope[:-1]
        exact = value(inputs, 1, pieces.t[:-1] + after - delays)
        long = after > 1e-9  # a change at an end is no nearer to it than floats are
        assert line[long] == pytest.approx(exact[long], abs=1e-9)


def test_steps_are_cut_nowhere_but_at_changes_of_some_candidate() -> None:
    t = np.array([0.0, 1.0, 2.0, 3.0])
    held = InputPath(t, np.array([[1.0], [1.0], [2.0], [2.0]]), np.zeros((4, 1)))
    changes = held.changes(0)
    assert changes.t.tolist() == [0.0, 2.0] and changes.u.tolist() == [1.0, 2.0]
    pieces = Pieces.of(t, [changes.t[1:, None] + [-1.5, -1.0, 0.25]], 3)
    # 0.5, 1.0 and 2.25 s: none of them in the second step; halves where a candidate has no change.
    assert pieces.first.tolist() == [0, 2, 3, 5]
    assert pieces.t.T.tolist() == [[0, 0.5, 1, 2, 2.5, 3], [0, 0.5, 1, 2, 2.5, 3],
                                   [0, 0.5, 1, 2, 2.25, 3]]  # fmt: skip
    assert pieces.changed[0].T.tolist() == [[0, 1, 1, 1, 1, 1], [0, 0, 1, 1, 1, 1],
                                            [0, 0, 0, 0, 1, 1]]  # fmt: skip


def test_without_late_inputs_steps_stay_whole() -> None:
    pieces = Pieces.of(T, [], 3)
    assert pieces.first.tolist() == list(range(31)) and pieces.changed == []
    np.testing.assert_array_equal(pieces.t, np.repeat(T[:, None], 3, axis=1))


@settings(max_examples=50, deadline=None)
@given(
    late=st.lists(st.lists(st.integers(-20, 120), min_size=3, max_size=3), min_size=1, max_size=6),
    inputs=st.integers(1, 2),
)
def test_pieces_follow_each_other_and_count_all_changes(late: list[list[int]], inputs: int) -> None:
    t = np.array([0.0, 1.0, 4.0, 6.0, 9.0])
    changes = [np.sort(np.array(late) / 12.0 + 0.3 * i, axis=0) for i in range(inputs)]
    pieces = Pieces.of(t, changes, 3)
    np.testing.assert_array_equal(pieces.t[pieces.first], np.repeat(t[:, None], 3, axis=1))
    assert (np.diff(pieces.t, axis=0) >= 0.0).all()
    for own, changed in zip(changes, pieces.changed, strict=True):
        for lane in range(3):
            # Of pieces without length the last one counts.
            at, count = pieces.t[:, lane], changed[:, lane]
            last = np.append(np.diff(at) > 0.0, True)
            expected = np.searchsorted(own[:, lane], at, side='right')
            np.testing.assert_array_equal(count[last], expected[last])


def test_before_its_first_sample_an_input_is_as_at_it() -> None:
    changes = path('linear').changes(0)
    u, slope = changes.after(np.zeros(3, dtype=np.int64), np.array([-50.0, -1.0, 0.0]))
    assert u.tolist() == [changes.u[0]] * 3 and slope.tolist() == [0.0] * 3
