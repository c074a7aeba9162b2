"""Estimates are written so that they are read back bit by bit."""

import csv
import math

import pytest

from obs_ros.core.estimate import Estimate, Jump, Outcome
from obs_ros.models import load_model
from obs_ros.replay.writers import bag_writer, table_writer

TANKS = load_model('three_tank')
LEVELS, VALVES = {'h1': 0.1 + 0.2, 'h2': 2.0, 'h3': 1 / 3}, {'p1': 0.1, 'p2': 0.2, 'p3': 1e-17}
ESTIMATE = Estimate(
    VALVES, LEVELS, LEVELS, {'h1': 0.7}, Outcome.AT_BOUND, 'p3 at its bound', 0.5, 9.5,
    cost=2.0, residual_rms=0.1, output_rms={'h1': 0.01}, stamp=9_500_000_000,
    innovation={'h1': 0.25, 'h2': math.nan}, innovation_stddev={'h1': 0.125, 'h2': math.nan},
    jumps=(
        Jump(5.0, 0.1, {'p1': -0.3}, {'p1': 0.01}, True, stamp=5 * 10**9, probability=0.97),
    ),
    interval={'p1': (0.05, 0.1 + 0.2), 'h1': (0.0, 2.0)},
)  # fmt: skip


def test_a_row_has_every_number_bit_by_bit(tmp_path):
    with table_writer(tmp_path / 'estimates.csv', TANKS) as take:
        take(ESTIMATE, 2)
    with (tmp_path / 'estimates.csv').open(newline='') as file:
        (row,) = csv.DictReader(file)
    assert {name: float(row[name]) for name in (*LEVELS, *VALVES)} == {**LEVELS, **VALVES}
    assert (row['t'], row['stamp_ns'], row['outcome']) == ('9.5', '9500000000', 'at_bound')
    assert float(row['h1_stddev']) == 0.7 and math.isnan(float(row['p1_stddev']))
    assert (float(row['p1_lower']), float(row['p1_upper'])) == (0.05, 0.1 + 0.2)
    assert (float(row['h1_lower']), float(row['h1_upper'])) == (0.0, 2.0)
    assert math.isnan(float(row['p2_lower'])) and math.isnan(float(row['p2_upper']))
    assert float(row['residual_rms.h1']) == 0.01 and math.isnan(float(row['residual_rms.h2']))
    assert row['skipped'] == '2' and row['jumps'].startswith('jump at 5.00 s')


def test_a_bag_has_the_topics_of_the_node(tmp_path):
    anyreader = pytest.importorskip('rosbags.highlevel')
    with bag_writer(tmp_path / 'bag', TANKS) as take:
        take(ESTIMATE, 2)
    with anyreader.AnyReader([tmp_path / 'bag']) as bag:
        found = {
            connection.topic: (recorded, bag.deserialize(raw, connection.msgtype))
            for connection, recorded, raw in bag.messages()
        }
    recorded, state = found['/estimator/state']
    assert recorded == ESTIMATE.stamp and state.header.stamp.nanosec == 500_000_000
    assert dict(zip(state.name, state.position.tolist(), strict=True)) == LEVELS
    _, residual = found['/estimator/residual']
    assert (residual.name, residual.position[0], residual.effort[0]) == (['h1', 'h2'], 0.25, 0.125)
    _, interval = found['/estimator/parameters_interval']
    assert interval.name == ['p1', 'p2', 'p3']
    assert (interval.position[0], interval.velocity[0]) == (0.05, 0.1 + 0.2)
    recorded, jump = found['/estimator/jump']
    assert (jump.effort[0], jump.velocity[0]) == (0.01, 0.97)
    assert recorded == ESTIMATE.stamp and (jump.header.stamp.sec, jump.position[0]) == (5, -0.3)
