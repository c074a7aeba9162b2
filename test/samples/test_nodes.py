"""Tests of obs_ros.samples.nodes: phase learned and followed, samples at their nodes, counts."""

import numpy as np
import pytest

from obs_ros.core.typing import Array
from obs_ros.samples.merge import Role
from obs_ros.samples.nodes import NodeLine, Phase

P = 10**8  # ns, of a period of 0.1 s
NAN = np.nan


class Kept:
    """A store that takes each stamp of a stream once."""

    def __init__(self) -> None:
        self.passed: int | None = None
        self.samples: dict[str, dict[int, list[float]]] = {'input': {}, 'output': {}}

    def keep(self, role: Role, stamp: int, values: Array) -> bool:
        new = stamp not in self.samples[role]
        self.samples[role].setdefault(stamp, values.tolist())
        return new

    def forget(self) -> None:
        for stream in self.samples.values():
            stream.clear()

    @property
    def outputs(self) -> dict[int, list[float]]:
        return self.samples['output']


def line() -> tuple[NodeLine, Kept, dict[str, int]]:
    store, counts = Kept(), dict.fromkeys(('off_grid', 'duplicate', 'late'), 0)
    return NodeLine(store, 0.1, counts), store, counts


def put(line: NodeLine, stamp: float, *values: float, role: Role = 'output') -> None:
    line.keep(role, round(stamp * P), np.array(values))


def test_a_stamp_within_a_tenth_of_the_period_belongs_to_the_node() -> None:
    nodes, store, counts = line()
    for stamp in (6.0, 7.0, 8.1, 8.9, 10.11, 10.95, 12.5, 13.0):
        put(nodes, stamp, stamp)
    on = {6: 6.0, 7: 7.0, 8: 8.1, 9: 8.9, 11: 10.95, 13: 13.0}
    assert store.outputs == {k * P: [stamp] for k, stamp in on.items()}
    assert counts == {'off_grid': 2, 'duplicate': 0, 'late': 0}


@pytest.mark.parametrize('first', [-0.09, 0.0, 0.09])
def test_jitter_of_a_tenth_loses_no_output_once_the_phase_is_known(first: float) -> None:
    nodes, store, counts = line()
    jitter = np.random.default_rng(7).uniform(-0.09, 0.09, 2000)
    jitter[0] = first
    for k, off in enumerate(jitter):
        put(nodes, k + off, float(k))
        if k < 8:
            assert counts['off_grid'] <= 2
            counts['off_grid'] = 0
    assert counts == {'off_grid': 0, 'duplicate': 0, 'late': 0}
    found = np.array(list(store.outputs))[-1990:] / P
    assert np.abs(found - np.arange(10, 2000)).max() < 0.1


def test_a_first_output_off_the_grid_of_the_others_is_left_behind() -> None:
    nodes, store, counts = line()
    for k, stamp in enumerate([0.0, 1.4, 2.4, 3.4, 4.4, 5.4]):
        put(nodes, stamp, k)
    assert counts['off_grid'] == 2  # of the second and the third
    assert list(store.outputs) == [0, round(3.4 * P), round(4.4 * P), round(5.4 * P)]


@pytest.mark.parametrize('drift', [1e-3, -1e-3, 1e-5])
def test_nodes_follow_clocks_that_drift(drift: float) -> None:
    rng = np.random.default_rng(2)
    nodes, store, counts = line()
    stamps = np.arange(5000) * (1.0 + drift) + rng.uniform(-0.05, 0.05, 5000)
    for stamp in stamps:
        put(nodes, stamp, stamp)
    assert counts == {'off_grid': 0, 'duplicate': 0, 'late': 0}
    found = np.array(list(store.outputs)) / P
    assert len(found) == 5000
    assert np.abs(found - np.arange(5000) * (1.0 + drift)).max() < 0.1
    np.testing.assert_allclose(np.diff(found), 1.0, atol=0.11)


def test_of_two_sensors_that_take_turns_the_first_keeps_the_nodes() -> None:
    nodes, store, counts = line()
    for k in range(40):
        put(nodes, k, 1.0)
        put(nodes, k + 0.3, 2.0)
    assert counts['off_grid'] == 40
    assert set(map(tuple, store.outputs.values())) == {(1.0,)}


@pytest.mark.parametrize('ratio', [2, 5, 7])
def test_of_outputs_more_frequent_than_nodes_those_at_nodes_count(ratio: int) -> None:
    nodes, store, counts = line()
    for k in range(40 * ratio):
        put(nodes, k / ratio, float(k))
    assert list(store.outputs) == [k * P for k in range(40)]
    assert counts['off_grid'] == 40 * (ratio - 1)


def test_outputs_of_one_node_that_come_apart_go_on_together() -> None:
    nodes, store, counts = line()
    put(nodes, 0.0, 1.0, NAN)
    assert store.outputs == {}
    assert nodes.reached({'output': 0})['output'] < 0
    put(nodes, 0.05, NAN, 2.0)
    assert store.outputs == {0: [1.0, 2.0]}
    assert nodes.reached({'output': round(0.05 * P)})['output'] == P // 2
    put(nodes, 1.0, 3.0, NAN)
    put(nodes, 1.02, 4.0, NAN)  # measured already
    put(nodes, 1.3, 0.5, role='input')  # time has gone on
    assert store.outputs[P][0] == 3.0
    assert counts == {'off_grid': 1, 'duplicate': 1, 'late': 0}


def test_a_second_output_of_a_node_is_a_duplicate_though_the_phase_has_moved() -> None:
    nodes, store, counts = line()
    for k in range(30):
        put(nodes, k + 0.004 * k, float(k))
        put(nodes, k + 0.004 * k + 0.06, NAN if k % 2 else -1.0)
    assert len(store.outputs) == 30
    assert counts['duplicate'] == 30


def test_inputs_act_from_the_next_node_on_or_from_one_just_before() -> None:
    nodes, store, counts = line()
    put(nodes, 0.5, 1.0, role='input')  # no phase is known yet
    put(nodes, 1.0, 0.0)
    for stamp in (1.05, 1.5, 1.95):
        put(nodes, stamp, stamp, role='input')
    acting = np.ceil(np.array(list(store.samples['input'])) / P)
    np.testing.assert_array_equal(acting, [1, 1, 2, 2])
    assert counts['off_grid'] == 1


def test_late_outputs_are_sorted_in_or_counted() -> None:
    nodes, store, counts = line()
    for stamp in (0.0, 1.0, 3.0, 2.03):
        put(nodes, stamp, stamp)
    assert store.outputs[2 * P] == [2.03]
    store.passed = 2 * P
    put(nodes, 1.02, 9.0)
    assert counts == {'off_grid': 0, 'duplicate': 0, 'late': 1}


def test_a_new_timeline_has_a_phase_of_its_own() -> None:
    nodes, store, counts = line()
    put(nodes, 5.0, 1.0)
    nodes.forget()
    put(nodes, 1.3, 1.0)
    put(nodes, 2.3, 1.0)
    assert list(store.outputs) == [round(1.3 * P), round(2.3 * P)]
    assert counts['off_grid'] == 0


def test_stamps_without_any_period_move_no_node() -> None:
    phase = Phase(0.1)
    for stamp in np.random.default_rng(3).integers(0, 100 * P, 200):
        phase.follow(int(stamp))
    assert len({phase.offset(k * P) for k in range(100)}) <= 3


def test_the_phase_of_a_record_is_that_of_most_of_its_first_outputs() -> None:
    phase = Phase(0.1)
    phase.learn([0, *(k * P + P // 4 for k in range(1, 9))])
    assert phase.offset(20 * P + P // 4) == 0
