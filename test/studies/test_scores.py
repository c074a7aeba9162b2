import math

import numpy as np
import pytest

from obs_ros.studies.result import Result
from obs_ros.studies.scores import Score, Scores, outcomes, parameters


def result(outcome=('converged', 'at_bound', 'converged'), error=(1.0, 3.0, np.nan)):
    held = np.array([2.0, 4.0, np.nan])
    return Result(
        {
            'outcome': list(outcome),
            'forecast_rms.y': np.array(error), 'held_rms.y': held,
            'forecast_rms.z': np.zeros(3), 'held_rms.z': held,
            'scatter_over_sd.a': np.array([np.nan, 1.5, 2.0]),
            'scatter_over_sd.b': np.full(3, np.nan),
        },
        {'every_sd': 2, 'jumps': 1, 'failed': 0, 'wall_time': 3.0},
    )  # fmt: skip


def test_the_skill_of_a_run_is_that_of_all_its_forecasts():
    score = Score.of(result())
    # y: 1 - (1 + 9) / (4 + 16), z: 1.
    assert score.skill == pytest.approx((0.5 + 1.0) / 2.0)
    assert Score.of(result(error=(math.inf, 1.0, 1.0))).skill == -math.inf
    assert score.estimates == 3 and score.outcomes == {'converged': 2, 'at_bound': 1}
    assert score.scatter['a'] == 2.0 and math.isnan(score.scatter['b'])


def test_a_run_without_forecasts_has_no_skill():
    empty = Result({'outcome': [], 'forecast_rms.y': np.empty(0), 'held_rms.y': np.empty(0)},
                   {'every_sd': 0, 'jumps': 0, 'failed': 0, 'wall_time': 0.0})  # fmt: skip
    assert math.isnan(Score.of(empty).skill)
    assert Scores({'a': Score.of(empty)}).share('converged') == 0.0


def test_a_variant_has_shares_of_all_its_estimates():
    scores = Scores({'a': Score.of(result()), 'b': Score.of(result(('diverged',) * 3))})
    assert scores.estimates == 6 and scores.jumps == 2 and scores.seconds == 3.0
    assert scores.share('diverged') == 0.5 and scores.share('converged') == pytest.approx(1 / 3)
    assert scores.every_sd == pytest.approx(4 / 6)
    np.testing.assert_array_equal(scores.scatter('a'), [2.0, 2.0])
    assert np.isnan(scores.scatter('c')).all()
    assert outcomes([scores]) == ['diverged', 'converged', 'at_bound']
    assert parameters([scores]) == ['a']


def test_variants_are_compared_where_both_have_forecasts():
    good, bad = Score.of(result(error=(0.0, 0.0, 0.0))), Score.of(result())
    one = Scores({'a': good, 'b': good, 'c': good})
    two = Scores({'a': bad, 'b': good, 'd': bad})
    assert one.better(two) == (1, 2)
    assert two.better(one) == (0, 2)
