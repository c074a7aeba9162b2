"""Random windows of three tanks, judged."""

from benchmarks.judge import values_of
from benchmarks.tanks import random_window
from benchmarks.windows import run as windows
from obs_ros import solve_window


def test_the_judge_sees_a_search_that_stopped_short():
    window = random_window(7, 200, 20.0)
    estimate = solve_window('three_tank', window.record, seed=7)
    found = values_of(estimate)
    short = {**found, 'p2': found['p2'] - 0.01}
    verdict = windows.judged(7, 200, 20.0, 2, {'unknown': found, 'known': short})
    assert abs(verdict.excess['unknown']) <= windows.SOLVED
    assert verdict.excess['known'] > 10.0
