"""The page on a replay."""

import math
import re

import numpy as np
import pytest
from ball_and_beam import made_up

from obs_ros.core.record import Sample
from obs_ros.replay.engine import replay
from obs_ros.replay.settings import setup
from obs_ros.replay.summary import largest, median, summary


class Nothing:
    """A recording that had nothing to say."""

    def __init__(self, **refused):
        self.refused, self.remarks = refused, ()


def page(rows=300, recording=None, **given):
    chosen = setup({'model': 'ball_and_beam:BALL', 'window.duration': 5.0, **given})
    t, u, y = made_up(300)
    samples = (
        sample
        for k in range(rows)
        for sample in (
            Sample(round(t[k] * 1e9), u=u[k : k + 1]), Sample(round(t[k] * 1e9), y=y[k : k + 1])
        )
    )  # fmt: skip
    account = replay(chosen, samples)
    return summary('run 1', chosen, account, recording or Nothing(), deadline=False)


def test_parameters_stand_with_their_deviations_beside_residuals_and_forecasts():
    text = page(recording=Nothing(wrong_length=3))
    lines = text.splitlines()
    assert lines[0] == '# Replay of run 1'
    assert 'observer `sliding_window`; windows of 5 s, one every 5 s; seed 0; no deadline' in text
    assert [line for line in lines if line.startswith('## ')] == [
        '## Outcomes', '## Parameters', '## States, at the end of each window', '## Jumps: 0',
        '## Residuals and forecasts', '## Dropped, mended and skipped',
    ]  # fmt: skip
    (row,) = [line for line in lines if line.startswith('| a |')]
    assert float(re.split(r' \| ', row)[4]) == pytest.approx(5.0, abs=0.05)
    assert '| `wrong_length` | 3 |' in lines and '| `converged` |' in text


def test_without_an_estimate_the_page_says_why():
    text = page(rows=10)
    assert 'There was no estimate: no window closed.' in text and '## Parameters' not in text


def test_an_observer_of_samples_has_innovations_in_place_of_forecasts():
    text = page(observer='ekf', **{'noise.y': 1e-4})
    assert 'Root mean square of the innovation over all outputs' in text
    assert '## Jumps' not in text and 'windows of' not in text


def test_figures_leave_out_what_is_not_known():
    values = np.array([1.0, math.nan, 3.0, 9.0])
    assert median(values) == 3.0 and largest(values) == 9.0
    nothing = np.full(2, math.nan)
    assert math.isnan(median(nothing)) and math.isnan(largest(nothing))
