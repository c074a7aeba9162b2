"""Tests of obs_ros.integration.input_history."""

from dataclasses import replace

import numpy as np
import pytest
from arx import ARX
from hypothesis import given
from hypothesis import strategies as st
from plants import BLOW_UP, NAN, VESSEL, with_interpolation

from obs_ros.core.interpolation import segments
from obs_ros.integration.input_history import InputHistory
from obs_ros.models.three_tank import THREE_TANK

S = 10**9
KINDS = ('hold', 'linear', 'mean')


def history(*samples: tuple[int, float], kind: str = 'hold') -> InputHistory:
    found = InputHistory(with_interpolation(VESSEL, kind))
    for t, u in samples:
        assert found.add(t * S, np.array([u]))
    return found


def test_a_path_has_a_piece_from_each_input_to_the_next() -> None:
    path = history((0, 1.0), (2, 3.0), (3, 5.0)).path(1 * S, 5 * S)
    assert path.pieces == 3
    assert path.t[:4].tolist() == [1, 2, 3, 5] and path.dt[:3].tolist() == [1, 1, 2]
    assert path.u[:4, 0].tolist() == [1, 3, 5, 5] and not path.slope.any()


def test_steps_are_no_longer_than_max_step_give_or_take_jitter() -> None:
    found = InputHistory(replace(VESSEL, max_step=0.5))
    found.add(0, np.ones(1))
    assert found.path(0, round(1.009 * S)).steps[0] == 2
    assert found.path(round(1.009 * S), 4 * S).steps[0] == 6


@pytest.mark.parametrize('kind', KINDS)
@given(
    stamps=st.lists(st.integers(1, 30), min_size=1, max_size=12, unique=True),
    end=st.integers(2, 40),
)
def test_whatever_the_order_of_arrival_inputs_are_those_of_a_window(
    kind: str, stamps: list[int], end: int
) -> None:
    found = history((0, 0.0), *((t, np.sin(t)) for t in stamps), kind=kind)
    path = found.path(1 * S, end * S)
    t = np.array(sorted({0, 1, *stamps, end}), dtype=float)
    known = np.isin(t, [0.0, *stamps])
    u = np.where(known, np.sin(t), NAN)[:, None]
    values, slopes = segments(t, u, [kind])  # type: ignore[list-item]
    rows = slice(1, 1 + path.pieces)
    np.testing.assert_allclose(path.u[: path.pieces], values[rows], atol=1e-12)
    np.testing.assert_allclose(path.slope[: path.pieces], slopes[rows], atol=1e-12)


def test_a_stamp_that_is_there_is_refused() -> None:
    found = history((0, 1.0), (2, 3.0))
    assert not found.add(2 * S, np.array([9.0])) and not found.add(0, np.array([9.0]))
    assert found.path(0, 3 * S).u[:2, 0].tolist() == [1.0, 3.0]


def test_an_entry_that_is_nan_keeps_its_value_also_of_a_sample_that_comes_late() -> None:
    found = InputHistory(THREE_TANK)
    for t, u in ((0, (1.0, 2.0)), (3, (NAN, 5.0)), (4, (NAN, NAN)), (5, (8.0, 8.0))):
        found.add(t * S, np.array(u))
    found.add(2 * S, np.array([9.0, NAN]))
    path = found.path(0, 6 * S)
    assert path.u[: path.pieces].tolist() == [[1, 2], [9, 2], [9, 5], [9, 5], [8, 8]]


def test_inputs_are_known_once_each_has_a_value() -> None:
    found = InputHistory(THREE_TANK)
    found.add(1 * S, np.array([1.0, NAN]))
    assert not found.known_at(5 * S)
    found.add(3 * S, np.array([NAN, 2.0]))
    assert [found.known_at(t * S) for t in (0, 2, 3, 9)] == [False, False, True, True]
    found.add(2 * S, np.array([NAN, 4.0]))
    assert found.known_at(2 * S)
    assert InputHistory(BLOW_UP).known_at(0)


def test_what_lies_before_the_end_is_forgotten_but_its_values_hold() -> None:
    found = InputHistory(THREE_TANK)
    for t, u in ((0, (1.0, 2.0)), (1, (NAN, 5.0)), (7, (3.0, 3.0))):
        found.add(t * S, np.array(u))
    found.path(0, 2 * S)
    assert len(found) == 2
    assert found.path(2 * S, 3 * S).u[0].tolist() == [1.0, 5.0]
    found.drop(1)
    assert len(found) == 1
    found.clear()
    assert len(found) == 0 and not found.known_at(9 * S)


def test_an_actuator_clips_what_the_plant_gets() -> None:
    inputs = (replace(VESSEL.inputs[0], range=(0.0, 2.0)),)
    found = InputHistory(replace(VESSEL, inputs=inputs))
    for t, u in ((0, 3.0), (1, -1.0), (2, 1.0)):
        assert found.add(t * S, np.array([u]))
    assert found.path(0, 3 * S).u[:3, 0].tolist() == [2.0, 0.0, 1.0]


def test_to_a_discrete_model_inputs_change_at_nodes() -> None:
    found, tenth = InputHistory(ARX), S // 10
    for stamp, u in ((0, 1.0), (tenth // 2, 2.0), (2 * tenth, 3.0), (2 * tenth + S // 500, 4.0)):
        found.add(stamp, np.array([u]))
    path = found.path(0, 4 * tenth + tenth // 30)
    assert path.pieces == 4 and path.steps[:4].tolist() == [1] * 4
    assert path.u[:5, 0].tolist() == [1.0, 2.0, 3.0, 4.0, 4.0]
    np.testing.assert_allclose(path.dt[:4], 0.1 + 0.1 / 120)
