import dataclasses
import math

from obs_ros.studies.page import SHOWN, Findings, page
from obs_ros.studies.scores import Score, Scores

GOOD = Score(10, {'converged': 9, 'at_bound': 1}, 10, 1, 0, 0.75, {'a': 1.25}, 0.5)
BAD = Score(10, {'model_mismatch': 10}, 5, 0, 2, 0.25, {'a': math.nan}, 1.5)
NONE = Score(0, {}, 0, 0, 0, math.nan, {}, 0.1)
SCORES = {
    'seed=1': Scores({'x.csv': BAD, 'y.csv': BAD}),
    'seed=2': Scores({'x.csv': GOOD, 'y.csv': dataclasses.replace(GOOD, skill=-math.inf)}),
}


def test_variants_stand_beside_each_other():
    text = page(Findings(2, SCORES, pictures=['variants.png'], seconds=12.0, about='model `m`'))
    assert 'model `m`.\n\n2 recordings, 2 variants: 4 runs with 40 estimates' in text
    assert 'none without a result' in text
    assert '| seed=1 | 20 | 100 % | 0 % | 0 % | 50 % | 0 | 4 | 1.5 s |' in text
    assert '| seed=2 | 20 | 0 % | 90 % | 10 % | 100 % | 2 |  | 0.5 s |' in text
    assert '| seed=1 | 0.25 | 0.25 to 0.25 |  |' in text
    assert '| seed=2 | -inf | -inf to 0.75 | 1 of 2 |' in text
    assert '| variant | a |\n| --- | --- |\n| seed=1 | ? |\n| seed=2 | 1.25 |' in text
    assert '| x.csv | 0.25 | 0.75 |' in text
    assert '![variants.png](variants.png)' in text
    assert '## Without a result' not in text and '## Remarks' not in text


def test_what_is_missing_is_told_with_its_reason():
    missing = [(f'{k}.csv', 'seed=1', 'no | such column') for k in range(SHOWN + 9)]
    text = page(Findings(SHOWN + 9, SCORES, missing, ['a remark']))
    assert f'## Without a result: {SHOWN + 9}' in text
    assert '| 0.csv | seed=1 | no \\| such column |' in text
    assert text.count('no \\| such column') == SHOWN
    assert text.endswith('## Remarks\n\n- a remark\n')


def test_a_study_without_estimates_says_so():
    text = page(Findings(1, {'as given': Scores({'x.csv': NONE})}))
    assert 'There was no estimate: is `window.duration` shorter' in text
    assert '## Forecast skill' not in text
