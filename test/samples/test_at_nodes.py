"""Tests of obs_ros.samples.at_nodes: records of discrete models, one row a node."""

from dataclasses import replace

import numpy as np
import pytest
from arx import ARX
from plants import LAG

from obs_ros import Record, Variable
from obs_ros.samples.at_nodes import at_nodes
from obs_ros.samples.delay_line import at_own_times

NAN = np.nan


def test_a_record_on_nodes_stays_as_it_is() -> None:
    t = 5.0 + 0.1 * np.arange(6)
    record = Record(t, np.arange(6.0), np.arange(6.0), stamp=5_500_000_000)
    found, said = at_nodes(ARX, record)
    np.testing.assert_allclose(found.t, t, rtol=1e-12)
    np.testing.assert_array_equal(found.u, record.u)
    np.testing.assert_array_equal(found.y, record.y)
    assert (found.stamp, said) == (5_500_000_000, '')


def test_several_periods_between_two_outputs_are_rows_without_any() -> None:
    found, said = at_nodes(ARX, Record([0.0, 0.3, 0.4], [1.0, NAN, 2.0], [7.0, 8.0, 9.0]))
    np.testing.assert_allclose(found.t, [0.0, 0.1, 0.2, 0.3, 0.4], atol=1e-12)
    np.testing.assert_array_equal(found.y[:, 0], [7.0, NAN, NAN, 8.0, 9.0])
    np.testing.assert_array_equal(found.u[:, 0], [1.0, NAN, NAN, NAN, 2.0])
    assert said == ''


def test_the_input_in_force_at_a_node_is_the_last_up_to_it() -> None:
    t = [0.0, 0.04, 0.07, 0.1, 0.13, 0.2, 0.205]
    y = [1.0, NAN, NAN, 2.0, NAN, 3.0, NAN]
    found, said = at_nodes(ARX, Record(t, [1.0, 2.0, 3.0, NAN, 4.0, NAN, 5.0], y))
    np.testing.assert_array_equal(found.u[:, 0], [1.0, 3.0, 5.0])
    assert said.startswith('3 samples lie between the nodes, 0.1 s apart')


def test_jitter_goes_and_what_lies_between_is_told() -> None:
    rng = np.random.default_rng(0)
    t = 0.1 * np.arange(50) + rng.uniform(-0.008, 0.008, 50)
    t[20] += 0.03
    y = np.arange(50.0)
    found, said = at_nodes(ARX, Record(t, np.zeros(50), y))
    assert found.t.size == 50
    assert np.isnan(found.y[20, 0]) and np.isnan(found.y).sum() == 1
    assert 'samples lie between the nodes' in said


def test_known_delays_come_first() -> None:
    late = replace(ARX, outputs=(Variable('y', delay=0.2),))
    t = 0.1 * np.arange(6)
    record = at_own_times(late, Record(t, np.arange(6.0), np.arange(6.0)))
    found, said = at_nodes(late, record)
    np.testing.assert_allclose(found.t, t[:4], atol=1e-9)
    np.testing.assert_array_equal(found.y[:, 0], [2.0, 3.0, 4.0, 5.0])
    assert said == ''


def test_a_continuous_model_has_no_nodes() -> None:
    record = Record([0.0, 0.13, 0.2], np.zeros(3), np.zeros(3))
    assert at_nodes(LAG, record) == (record, '')


def test_records_that_no_node_can_hold_are_refused() -> None:
    with pytest.raises(ValueError, match='look at period and stamps: fewer than two outputs'):
        at_nodes(ARX, Record([0.0, 0.04], np.zeros(2), np.zeros(2)))
    with pytest.raises(ValueError, match='split the record: it has 1e\\+07 nodes'):
        at_nodes(ARX, Record([0.0, 1e6], np.zeros(2), np.zeros(2)))
