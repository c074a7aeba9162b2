"""The contest of searches, and its acceptance."""

import pytest

from benchmarks.report import requirements
from benchmarks.search.__main__ import main as measure_search
from benchmarks.search.contest import KNOWN, Score, Verdict, contested, limited_name
from benchmarks.search.report import acceptance, believed


def test_a_contest_tells_the_optimum_from_what_the_papers_search_finds():
    verdict = contested('three tanks 50, 20 dB', 70_000, 1, 2)
    assert verdict.judge_excess <= 0.1
    for way in ('memetic', KNOWN, 'DE + LM', 'scipy, 1 start', limited_name('memetic', 0.1)):
        assert verdict.scores[way].solved, way
        assert verdict.scores[way].accepted, way
    assert not verdict.scores['paper mode'].solved
    assert 0.0 < verdict.scores['memetic'].seconds < 0.1


def test_a_window_off_the_optimum_that_was_believed_is_a_false_accept():
    right = Score(0.5, 0.01, True, True)
    wrong, doubted = Score(1.5, 0.01, True, False), Score(2.0, 0.01, False, False)
    verdicts = [Verdict({'memetic': score}, 0.0) for score in (right, wrong, doubted)]
    assert believed(verdicts, 'memetic') == (2, 1)


@pytest.mark.slow
def test_the_search_benchmark_reports_what_it_accepts(tmp_path):
    arguments = ['--windows', '1', '--cases', 'three tanks 50, 20 dB', '--results', str(tmp_path)]
    text = measure_search(arguments)
    assert text == (tmp_path / 'search.md').read_text()
    assert '| those cells together >= 99.5 % | 100.0 % | yes |' in text
    assert (tmp_path / 'search_success.png').stat().st_size > 10_000


def test_acceptance_fails_where_windows_are_missed():
    score = Score(0.0, 0.01, True, True)
    missed = score._replace(excess=3.0)
    ways = ('memetic', KNOWN, 'memetic, safe', limited_name('memetic', 0.02))
    own = [Verdict(dict.fromkeys(ways, one), 0.0) for one in (score, score, missed)]
    told = requirements(acceptance({'Lorenz 5': own, 'Lorenz 10': own}, []))
    assert 'Lorenz 5 67 % | **no** |' in told
    assert '| Lorenz 10 >= 88 % | 67 % | **no** |' in told
    assert '2 of 6: 33.33 % | **no** |' in told
