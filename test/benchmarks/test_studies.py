"""The benchmark of studies."""

import pytest
from dask_processes import distributed

from benchmarks.studies.report import acceptance, speed_up
from benchmarks.studies.run import ALONE, LOCAL, ONE, REMOTE, TWO, Course, Measured, made

SECONDS = {ONE: [60.0, 62.0], TWO: [30.0, 31.0], ALONE: [66.0, 66.0], LOCAL: [36.0, 37.0],
           REMOTE: [33.0, 55.0]}  # fmt: skip


def test_the_acceptance_compares_speed_ups_of_one_run() -> None:
    assert speed_up(SECONDS, TWO) == 2.0
    found = Measured(SECONDS, ['a'] * 6, Course(8, 0, 10, 'a'), 10)
    local, remote, bits, none_twice = acceptance(found)
    assert local.met and local.measured == '1.81 / 2.00 = 0.90'
    assert not remote.met
    assert bits.met and none_twice.met
    found = found._replace(digests=['a'] * 5 + ['b'], course=Course(8, 1, 9, 'a'))
    assert [row.met for row in acceptance(found)][2:] == [False, False]


def test_recordings_are_the_same_for_the_same_seed(tmp_path) -> None:
    plans = []
    for name, seed in (('a', 1), ('b', 1), ('c', 2)):
        (tmp_path / name).mkdir()
        plans.append(made(tmp_path / name, 2, 50, seed))
    one, same, other = ([path.read_bytes() for path in plan.recordings] for plan in plans)
    assert one == same and one[1] == other[0] and one[0] != one[1]
    assert plans[0].runs == 10


@pytest.mark.slow
def test_the_studies_benchmark_reports_what_was_asked(tmp_path) -> None:
    distributed()
    from benchmarks.studies.__main__ import main

    text = main(['--recordings', '3', '--samples', '450', '--rounds', '1',
                 '--results', str(tmp_path)])  # fmt: skip
    assert text == (tmp_path / 'studies.md').read_text()
    assert '| 1 different tables of 4 | yes |' in text
    assert '| 15 of 15 results, ' in text and ', of which 0 were done again | yes |' in text
