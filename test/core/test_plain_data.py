"""Tests of obs_ros.core.plain_data."""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from obs_ros.core.plain_data import Shapes, described, from_plain, to_plain
from obs_ros.core.typing import Array


class Word(StrEnum):
    CALM = 'calm'
    ROUGH = 'rough'


class Pair(NamedTuple):
    first: float
    second: str


@dataclass(frozen=True)
class Inner:
    values: Array
    square: Array
    names: frozenset[str]


@dataclass(frozen=True)
class Outer:
    number: float
    any_number: float
    count: int
    yes: bool
    word: Word
    maybe: float | None
    pairs: tuple[Pair, ...]
    two: tuple[int, str]
    inner: Inner
    rates: Mapping[str, float]
    counts: Mapping[float, int]
    flags: list[bool]


SHAPES = Shapes(
    {'Inner.values': 'q', 'Inner.square': 'q K'}, {'q': 2}, frozenset({'Outer.any_number'})
)
OUTER = Outer(
    0.1, math.nan, 3, True, Word.ROUGH, None, (Pair(1e-300, 'a'), Pair(-0.0, '')), (7, 'x'),
    Inner(np.array([1 / 3, -0.0]), np.ones((2, 5)), frozenset({'b', 'a'})), {'k': 2.5},
    {0.5: 2, -1.0: 1}, [True, False],
)  # fmt: skip


def through_text(value: Any, kind: Any = Outer) -> Any:
    return from_plain(kind, json.loads(json.dumps(to_plain(value), allow_nan=False)), SHAPES)


def test_everything_comes_back() -> None:
    back = through_text(OUTER)
    assert math.isnan(back.any_number)
    assert back.inner.values.tobytes() == OUTER.inner.values.tobytes()
    assert back.inner.square.shape == (2, 5)
    assert back.inner.names == {'a', 'b'}
    assert math.copysign(1.0, back.pairs[1].first) == -1.0
    same = {'any_number': 0.0, 'inner': None}
    assert replace(back, **same) == replace(OUTER, **same)


@given(st.floats(allow_nan=True), st.lists(st.floats(), min_size=2, max_size=2))
def test_bits_are_the_same(number: float, values: list[float]) -> None:
    array = np.array(values)
    loose = replace(SHAPES, not_finite=frozenset({'Outer.any_number', 'Inner.values'}))
    outer = replace(OUTER, any_number=number, inner=replace(OUTER.inner, values=array))
    back = from_plain(Outer, json.loads(json.dumps(to_plain(outer), allow_nan=False)), loose)
    assert repr(back.any_number) == repr(number)
    assert back.inner.values.tobytes() == array.tobytes()


def changed(**changes: Any) -> dict[str, Any]:
    return {**to_plain(OUTER), **changes}


@pytest.mark.parametrize(
    ('changes', 'said'),
    [
        ({'number': 1}, 'number must be a finite number, not 1'),
        ({'number': 'nan'}, "number must be a finite number, not 'nan'"),
        ({'any_number': 'none'}, "any_number must be a finite number, not 'none'"),
        ({'count': True}, 'count must be an integer, not True'),
        ({'count': 1.0}, 'count must be an integer'),
        ({'yes': 1}, 'yes must be true or false'),
        ({'word': 'mild'}, "word must be calm or rough, not 'mild'"),
        ({'maybe': 'x'}, 'maybe must be a finite number'),
        ({'pairs': {}}, 'pairs must be a list'),
        ({'pairs': [{'first': 1.0}]}, r'pairs\[0\] must be an object with first, second'),
        ({'two': [1]}, r'two must be 2 entries, not \[1\]'),
        ({'rates': [['k', 1.0], ['k', 2.0]]}, 'rates must be no entry twice'),
        ({'inner': None}, 'inner must be an object'),
    ],
)  # fmt: skip
def test_refusals_name_the_place(changes: dict[str, Any], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        from_plain(Outer, changed(**changes), SHAPES)


@pytest.mark.parametrize(
    ('array', 'said'),
    [
        (np.ones(3), 'an array of 2 as its q'),
        (np.ones((2, 1)), 'an array of 1 dimensions'),
        (np.array([1.0, math.nan]), 'finite numbers'),
        (np.array([1.0, math.inf]), 'finite numbers'),
    ],
)
def test_arrays_have_the_shape_that_is_known(array: np.ndarray, said: str) -> None:
    inner = {**to_plain(OUTER.inner), 'values': to_plain(array)}
    with pytest.raises(ValueError, match=f'inner.values must be {said}'):
        from_plain(Outer, changed(inner=inner), SHAPES)


@pytest.mark.parametrize(
    ('plain', 'said'),
    [
        ({'shape': [2], 'float64': '!!'}, 'base64'),
        ({'shape': [2], 'float64': 5}, 'base64'),
        ({'shape': [2], 'float64': 'AAAA'}, '16 bytes, not 3'),
        ({'shape': [True], 'float64': ''}, 'as its q'),
        ({'shape': 2, 'float64': ''}, 'dimensions'),
        ({'shape': [2]}, 'an array'),
        ([1.0, 2.0], 'an array'),
    ],
)
def test_arrays_that_are_none(plain: Any, said: str) -> None:
    inner = {**to_plain(OUTER.inner), 'values': plain}
    with pytest.raises(ValueError, match=said):
        from_plain(Outer, changed(inner=inner), SHAPES)


def test_one_letter_has_one_length_in_an_object() -> None:
    shapes = replace(SHAPES, shapes={'Inner.values': 'K', 'Inner.square': 'q K'})
    with pytest.raises(ValueError, match=r'inner\.square must be an array of 2 as its K'):
        from_plain(Outer, to_plain(OUTER), shapes)


def test_what_is_not_known_is_not_written() -> None:
    with pytest.raises(TypeError, match='object cannot be written'):
        to_plain([object()])


def test_the_layout_in_words() -> None:
    assert 'Inner(values: Array, square: Array, names: frozenset[str])' in described(Outer)
    assert 'Pair(first: float, second: str)' in described(Outer)
    assert 'maybe: Union[float, NoneType]' in described(Outer)
