"""Cells of a page: figures, units, tables."""

import math

import numpy as np

from obs_ros import Variable
from obs_ros.replay.cells import (
    cell,
    figure,
    largest,
    median,
    table,
    unit,
    with_interval,
)  # fmt: skip


def test_figures_leave_out_what_is_not_known():
    values = np.array([1.0, math.nan, 3.0, 9.0])
    assert median(values) == 3.0 and largest(values) == 9.0
    nothing = np.full(2, math.nan)
    assert math.isnan(median(nothing)) and math.isnan(largest(nothing))
    assert (figure(math.nan), figure(0.0123456)) == ('?', '0.01235')
    assert (unit(Variable('share')), unit(Variable('v', 'm/s'))) == ('', 'm/s')
    assert with_interval(2.0, 1.75, 3.5) == '2 (1.75 to 3.5)'
    assert with_interval(1.0, math.nan, math.nan) == '1 (?)'


def test_a_text_stays_in_its_cell():
    assert cell('a | b\nc') == 'a \\| b c'
    assert table(('x', 'y'), [('1', '2')]) == '| x | y |\n| --- | --- |\n| 1 | 2 |'
