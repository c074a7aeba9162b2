"""Readers make vectors of messages, whoever decoded them."""

import array
from types import SimpleNamespace

import numpy as np
import pytest

from obs_ros.interface.bindings import ARRIVAL, HEADER, Binding
from obs_ros.interface.field_path import FieldPath, MessageError
from obs_ros.interface.readers import (
    FieldReader,
    VectorReader,
    nanoseconds,
    topic_readers,
)  # fmt: skip


def joints(names, values, stamp=0):
    header = SimpleNamespace(stamp=SimpleNamespace(sec=stamp // 10**9, nanosec=stamp % 10**9))
    return SimpleNamespace(header=header, name=list(names), position=array.array('d', values))


def bound(name, path, topic='/a', stamp=HEADER, scale=1.0, offset=0.0):
    return Binding(name, topic, 'T', FieldPath.parse(path), scale, offset, stamp)


def test_a_stamp_is_in_nanoseconds():
    assert nanoseconds(SimpleNamespace(sec=2, nanosec=5)) == 2_000_000_005


def test_order_is_by_name():
    message = joints(('c', 'a', 'b'), (3.0, 1.0, 2.0))
    assert VectorReader(('a', 'b', 'c')).read(message, 0)[1].tolist() == [1.0, 2.0, 3.0]


@pytest.mark.parametrize(
    ('names', 'values', 'reason', 'text'),
    [
        (['a'], [1.0], 'missing_name', "'b' is missing"),
        (['a', 'bb'], [1.0, 2.0], 'missing_name', "'b' is missing: did you mean 'bb'"),
        (['a', 'b'], [1.0], 'wrong_length', '2 names but 1 positions'),
        (['a', 'b', 'a'], [1.0, 2.0, 3.0], 'wrong_length', "'a' stands twice"),
        ([], [], 'missing_name', "'a' is missing"),
    ],
)
def test_wrong_messages_say_why(names, values, reason, text):
    message = joints(names, values)
    with pytest.raises(MessageError, match=text) as caught:
        VectorReader(('a', 'b')).read(message, 0)
    assert caught.value.reason == reason


def test_further_names_are_ignored_and_their_messages_counted():
    reader = VectorReader(('a', 'b'), [1, 3], 4)
    for names, values in (
        (['c', 'b', 'a'], (3.0, 2.0, 1.0)), (['c', 'b', 'a'], (6.0, 5.0, 4.0)),
        (['b', 'a'], (8.0, 7.0)), (['a', 'x', 'x', 'b'], (9.0, 0.0, 0.0, 10.0)),
    ):  # fmt: skip
        found = reader.read(joints(names, values), 0)[1]
        wanted = dict(zip(names, values, strict=True))
        assert found[[1, 3]].tolist() == [wanted['a'], wanted['b']]
        assert np.isnan(found[[0, 2]]).all()
    assert reader.others == 3


def test_values_outlive_their_message():
    message = joints(('a',), (1.0,))
    values = VectorReader(('a',)).read(message, 0)[1]
    message.position[0] = 2.0
    assert values.tolist() == [1.0]


def test_bound_entries_are_scaled_and_the_others_left_open():
    reader = FieldReader({1: bound('b', 'position[x]', scale=100.0, offset=-1.0)}, 3)
    stamp, values = reader.read(joints(('w', 'x'), (0.0, 2.0), stamp=7), arrival=99)
    assert stamp == 7 and reader.places == [1] and reader.whole
    np.testing.assert_array_equal(values, [np.nan, 199.0, np.nan])


def test_the_arrival_is_the_stamp_where_that_is_asked_for():
    reader = FieldReader({0: bound('a', 'position[x]', stamp=ARRIVAL)}, 1)
    assert reader.read(joints(('x',), (1.0,), stamp=7), arrival=99)[0] == 99


def test_a_message_may_lack_some_entries_but_not_all():
    reader = FieldReader({0: bound('a', 'position[x]'), 1: bound('b', 'position[y]')}, 2)
    assert not reader.whole
    np.testing.assert_array_equal(reader.read(joints(('y',), (3.0,)), 0)[1], [np.nan, 3.0])
    with pytest.raises(MessageError, match="there is no 'x' in name") as caught:
        reader.read(joints(('z',), (3.0,)), 0)
    assert caught.value.reason == 'no_entry'


def test_named_entries_are_put_in_their_places():
    reader = VectorReader(['a', 'c'], places=[0, 2], width=3)
    _, values = reader.read(joints(('a', 'c'), (1.0, 3.0)), 0)
    np.testing.assert_array_equal(values, [1.0, np.nan, 3.0])


def test_each_topic_gets_one_reader_the_default_last():
    binding = {'a': bound('a', 'x', '/two'), 'c': bound('c', 'y', 'two')}
    readers = topic_readers(['a', 'b', 'c'], binding, 'plant/output', lambda t: f'/{t.strip("/")}')
    assert [topic for topic, _ in readers] == ['/two', 'plant/output']
    assert [list(reader.places) for _, reader in readers] == [[0, 2], [1]]
    ((topic, reader),) = topic_readers(['a', 'b'], {}, 'plant/output', str)
    assert topic == 'plant/output' and isinstance(reader, VectorReader)
    assert topic_readers([], {}, 'plant/input', str) == []
