"""The page on a replay."""

import re
from dataclasses import replace

import pytest
from ball_and_beam import made_up

from obs_ros.core.estimate import Estimate, Jump, Outcome
from obs_ros.core.record import Sample
from obs_ros.replay.engine import Account, replay
from obs_ros.replay.history import History
from obs_ros.replay.settings import setup
from obs_ros.replay.summary import summary


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
    told_by_few = ('## Process noise', '## Scatter')
    heads = [line for line in lines if line.startswith('## ')]
    assert [head for head in heads if not head.startswith(told_by_few)] == [
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


def test_walks_skill_and_scatter_are_those_of_the_estimates():
    chosen = setup({'model': 'plants:VESSEL'})
    account = Account(History(chosen.model))
    for k, walk in enumerate((0.5, None, 0.25, 0.3)):
        walks = {} if walk is None else {'x': walk, 'd': 0.0}
        figures = {} if walk is None else {'forecast_skill': walk, 'scatter_over_sd.g': 2.0 * walk}
        account.history.add(
            Estimate(
                parameters={'d': 2.0, 'g': 0.0}, initial_state={'x': 1.0}, state={'x': 1.0},
                stddev={}, outcome=Outcome.APPROXIMATE, message='', t0=0.0, t1=1.0 + k,
                walks=walks, figures=figures,
            )
        )  # fmt: skip
    lines = summary('run 1', chosen, account, Nothing(), deadline=False).splitlines()
    unit = chosen.model.states[0].unit
    assert f'| x | {unit}/sqrt(s) | 3 of 4 | 0.3 | 0.5 |' in lines
    assert any('0.3 in the median of 3 windows, 0.3 in the last' in line for line in lines)
    assert '| g | 0.6 | 0.6 |' in lines
    assert not any(line.startswith('| d | ') and 'sqrt' in line for line in lines)


def test_intervals_stand_with_both_ends_and_jumps_with_what_came_of_them():
    chosen = setup({'model': 'plants:VESSEL'})
    account = Account(History(chosen.model), horizon=1.0)
    jump = Jump(0.5, 0.1, {'d': 1.0}, {'d': 0.1}, True, ('g', 'no jump'), probability=0.96)
    back = replace(jump, sizes={'d': 0.0}, stddev={'d': 0.0}, retracted=True)
    for k, jumps in enumerate(((jump,), (back,))):
        account.history.add(
            Estimate(
                parameters={'d': 2.0, 'g': 0.0}, initial_state={'x': 1.0}, state={'x': 1.0},
                stddev={'d': 0.5}, outcome=Outcome.CONVERGED, message='', t0=0.0, t1=1.0 + k,
                interval={'d': (1.75, 3.5)}, jumps=jumps, drifting=('g',),
            )
        )  # fmt: skip
    lines = summary('run 1', chosen, account, Nothing(), deadline=False).splitlines()
    (row,) = [line for line in lines if line.startswith('| d | ')]
    assert '| 2 (1.75 to 3.5) | 2 (1.75 to 3.5) |' in row
    (row,) = [line for line in lines if line.startswith('| g | ')]
    assert '| 0 (?) | 0 (?) |' in row
    assert '## Jumps: 1, 1 taken back' in lines
    announced = '- jump at 0.50 s +- 0.2 s: d +1 +- 0.2, probability 0.96 (or: g; no jump)'
    assert announced in lines and '- jump at 0.50 s taken back: d (or: g; no jump)' in lines
    (drift,) = [line for line in lines if line.startswith('Drifting: ')]
    assert drift.startswith('Drifting: g in 2 estimates; give it a walk: walk.g')
