import math

import numpy as np
import pytest
from plants import VESSEL, tank_record

from obs_ros import Model, Record, Variable, solve_window
from obs_ros.models.three_tank import THREE_TANK
from obs_ros.samples.range_check import (
    COUNTS,
    LARGEST,
    RangeSettings,
    anything,
    limits,
    measured,
    without_absurd,
)

BOXES = RangeSettings().boxes
RANGES = [(-1.0, 2.0), (0.0, 5.0)]


def taken(*values: float) -> tuple[list[float] | None, dict[str, int]]:
    counts = dict.fromkeys(COUNTS, 0)
    found = measured(np.array(values), RANGES, counts)
    return None if found is None else found.tolist(), {k: n for k, n in counts.items() if n}


def test_values_in_range_pass_as_they_are():
    values, counts = np.array([-1.0, 5.0]), dict.fromkeys(COUNTS, 0)
    assert measured(values, RANGES, counts) is values
    assert not any(counts.values())


@pytest.mark.parametrize(
    ('values', 'left', 'counted'),
    [
        ((math.nan, 1.0), [None, 1.0], {'nan': 1}),
        ((1.0, math.inf), [1.0, None], {'nan': 1}),
        ((2.1, 1.0), [None, 1.0], {'huge': 1}),
        ((1e300, math.nan), None, {'huge': 1}),
        ((math.nan, -math.inf), None, {'all_nan': 1}),
        ((-2.0, -1.0), None, {'huge': 1}),
    ],
)
def test_what_is_no_measurement_is_taken_out_and_counted(values, left, counted):
    found, counts = taken(*values)
    assert counts == counted
    expected = left and [math.nan if value is None else value for value in left]
    assert found == pytest.approx(expected, nan_ok=True) if left else found is None


def test_limits_are_a_million_boxes_of_the_output_or_of_the_state_of_its_name():
    (low, high), _ = limits(THREE_TANK, THREE_TANK.outputs)  # h1: 0 to 100 cm
    assert (low, high) == (-100.0 * BOXES, 100.0 + 100.0 * BOXES)
    own = Model(
        name='own', states=(Variable('x'),), outputs=(Variable('y', lower=-1.0, upper=1.0),),
        dynamics=lambda t, x, u, p: (0.0 * x[0],), output=lambda t, x, u, p: (x[0],),
    )  # fmt: skip
    assert limits(own, own.outputs) == [(-1.0 - 2.0 * BOXES, 1.0 + 2.0 * BOXES)]


def test_without_bounds_the_nominal_value_counts_and_else_what_can_be_squared():
    assert limits(THREE_TANK, THREE_TANK.inputs)[0] == (-30.0 * BOXES, 30.0 * BOXES)
    assert limits(VESSEL, VESSEL.outputs) == [(-LARGEST, LARGEST)] == anything(1)
    assert math.isfinite(1e6 * LARGEST**2)


def window(y):
    t = np.arange(float(len(y)))
    return Record(t, np.zeros((t.size, 0)), np.asarray(y, dtype=float)[:, None])


NOISE = np.random.default_rng(1).standard_normal(100)
SPARSE = np.where(np.arange(100) % 50 == 7, 1e6, 0.0)


@pytest.mark.parametrize(
    'y',
    [
        NOISE,
        np.where(np.arange(100) < 50, 0.0, 1e6),
        SPARSE,
        SPARSE * 1e30,
        SPARSE + 1e-16 * NOISE,
        NOISE + 100.0 * (np.arange(100) == 30),
        1e99 * np.sin(np.arange(100.0)),
        np.full(100, 1e99),
    ],
)
def test_a_real_signal_stays_as_it_is(y):
    record = window(y)
    assert without_absurd(record) == (record, 0)


@pytest.mark.parametrize('absurd', [1e99, -1e30, 3.4e38])
def test_absurd_values_are_told_by_the_spread_of_their_window(absurd):
    y = NOISE.copy()
    y[[3, 40]] = absurd
    record, count = without_absurd(window(y))
    assert count == 2
    assert np.flatnonzero(np.isnan(record.y[:, 0])).tolist() == [3, 40]


def test_a_window_without_its_absurd_values_is_solved_as_if_they_were_not_measured():
    found = []
    for value in (1e99, np.nan):
        record = tank_record(nodes=101)
        y = record.y.copy()
        y[50, 0] = value
        found.append(solve_window('three_tank', record.with_outputs(y), backend='numpy'))
    assert found[0].parameters == found[1].parameters
    assert '1 values beyond any signal of this window count as not measured' in found[0].message
