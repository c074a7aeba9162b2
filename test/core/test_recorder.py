"""Tests of obs_ros.core.recorder: operations once, decisions as they were asked for."""

import pytest

from obs_ros.core.recorder import LIMITS, Recorder, Untraceable


def test_equal_operations_are_recorded_once() -> None:
    recorder = Recorder()
    first = recorder.record('{} + {}', ('x[0]', '1'))
    assert recorder.record('{} + {}', ('x[0]', '1')) == first
    assert recorder.record('{} + {}', ('x[0]', '1.0')) == first + 1
    assert recorder.nodes == [('{} + {}', ('x[0]', '1')), ('{} + {}', ('x[0]', '1.0'))]


def test_decisions_are_taken_in_their_order_and_each_condition_asks_once() -> None:
    recorder = Recorder()
    recorder.begin((False,))
    assert [recorder.decide(c) for c in (4, 4, 7, 4)] == [False, False, True, False]
    assert recorder.taken == {4: False, 7: True}
    assert recorder.paths == 2  # one way more, with 7 decided otherwise


def test_too_many_ways_are_refused_with_the_cure() -> None:
    recorder = Recorder()
    recorder.begin(())
    with pytest.raises(Untraceable, match=r'use np\.where, or a loop of fixed length'):
        for condition in range(LIMITS.paths):
            recorder.decide(condition)
    assert recorder.paths == LIMITS.paths


def test_ways_that_part_in_one_place_are_selected_there() -> None:
    recorder = Recorder()
    a, b = (recorder.record('np.sin({})', (x,)) for x in ('x[0]', '2'))
    ours, others = (recorder.record('{} * {}', ('p[0]', v)) for v in (a, b))
    merged = recorder.merged('c', ours, others)
    assert recorder.nodes[merged] == ('{} * {}', ('p[0]', merged - 1))
    assert recorder.nodes[merged - 1] == ('np.sin({})', (merged - 2,))
    assert recorder.nodes[merged - 2] == ('np.where({}, {}, {})', ('c', 'x[0]', '2.0'))
    assert recorder.merged('c', ours, ours) == ours


def test_ways_that_part_in_two_places_are_selected_whole() -> None:
    recorder = Recorder()
    ours = recorder.record('{} * {}', ('p[0]', 'x[0]'))
    others = recorder.record('{} * {}', ('p[1]', 'x[1]'))
    assert recorder.nodes[recorder.merged('c', ours, others)][1] == ('c', ours, others)
