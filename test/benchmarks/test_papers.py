"""The frame of the papers' audits: claims, seeds, and what every paper has."""

import math
import re

import pytest

from benchmarks.documents import CLAIMS, RESULTS, cells, disagreements, table_below
from benchmarks.papers import __main__ as command
from benchmarks.papers.__main__ import SEEDS, main
from benchmarks.papers.claims import (
    Claim,
    Verdict,
    as_well,
    below,
    claims_table,
    every,
    never,
    opposite,
    rarely,
    share,
    verdict,
    within,
)
from benchmarks.papers.paper import load_paper, papers
from benchmarks.papers.seeds import seeds_of

REPORTED = [name for name in papers() if (RESULTS / f'papers_{name}.md').exists()]


def test_a_claim_is_a_row_with_its_verdict() -> None:
    rows = [
        Claim('eq. 3', 'x is found', '200 seeds', share(200, 200), verdict(True), '1e-3'),
        Claim('Fig. 4', 'y stays small', '', '', verdict(False)),
        Claim('5.1', 'z is robust', 'no figure in print', '', Verdict.CANNOT_BE_JUDGED),
        Claim('6', 'v beats w', '20 seeds', '', Verdict.NOT_SHOWN),
    ]
    assert claims_table(rows).splitlines() == [
        '| place | claim | judged by | found | verdict | our default |',
        '| --- | --- | --- | --- | --- | --- |',
        '| eq. 3 | x is found | 200 seeds | 200 of 200 (0.982 to 1.000) | holds | 1e-3 |',
        '| Fig. 4 | y stays small |  |  | **does not hold** |  |',
        '| 5.1 | z is robust | no figure in print |  | cannot be judged from the print |  |',
        '| 6 | v beats w | 20 seeds |  | not shown |  |',
    ]


HOLDS, FAILS, NOT_SHOWN = Verdict.HOLDS, Verdict.DOES_NOT_HOLD, Verdict.NOT_SHOWN


@pytest.mark.parametrize(
    ('failures', 'runs', 'rare', 'none'),
    [(0, 200, HOLDS, HOLDS), (3, 200, HOLDS, FAILS), (5, 200, NOT_SHOWN, FAILS),
     (0, 50, NOT_SHOWN, NOT_SHOWN), (18, 200, FAILS, FAILS)],
)  # fmt: skip
def test_what_goes_wrong_is_rare_or_not_or_too_little_is_known(failures, runs, rare, none) -> None:
    assert rarely(failures, runs) is rare
    assert never(failures, runs) is none


@pytest.mark.parametrize(
    ('one', 'is_below', 'is_within'),
    [((1.0, 1.9), HOLDS, FAILS), ((1.0, 2.1), NOT_SHOWN, NOT_SHOWN), ((2.1, 2.9), NOT_SHOWN, HOLDS),
     ((2.0, 3.0), NOT_SHOWN, HOLDS), ((2.5, 3.5), NOT_SHOWN, NOT_SHOWN),
     ((3.1, 4.0), FAILS, FAILS)],
)  # fmt: skip
def test_intervals_that_overlap_show_nothing(one, is_below, is_within) -> None:
    assert below(one, (2.0, 3.0)) is is_below
    assert within(one, (2.0, 3.0)) is is_within


def test_one_that_is_no_larger_does_as_well() -> None:
    assert as_well((0.7, 1.09)) is HOLDS
    assert as_well((0.9, 1.2)) is NOT_SHOWN
    assert as_well((1.2, 1.3)) is FAILS


def test_one_claim_of_several_refutes_them_all() -> None:
    assert every([HOLDS, HOLDS]) is HOLDS
    assert every([HOLDS, NOT_SHOWN]) is NOT_SHOWN
    assert every([NOT_SHOWN, FAILS, HOLDS]) is FAILS
    assert [opposite(one) for one in (HOLDS, FAILS, NOT_SHOWN)] == [FAILS, HOLDS, NOT_SHOWN]


def test_no_two_runs_share_a_seed() -> None:
    seeds = [
        seed
        for paper in ('yang', 'porter')
        for scenario in ('base', 'chaotic', 'base chaotic')
        for seed in seeds_of(paper, scenario, 500)
    ]
    assert len(set(seeds)) == len(seeds) == 3000
    assert all(0 <= seed < 2**63 for seed in seeds)


def test_more_runs_begin_with_the_same_seeds() -> None:
    assert seeds_of('yang', 'base', 300)[:200] == seeds_of('yang', 'base', 200)
    mean = sum(seeds_of('yang', 'base', 2000)) / 2000 / 2**63
    assert math.isclose(mean, 0.5, abs_tol=4.0 * math.sqrt(1.0 / 12.0 / 2000))


def test_an_unknown_paper_is_refused(capsys) -> None:
    with pytest.raises(SystemExit):
        main(['yangg'])
    assert "invalid choice: 'yangg'" in capsys.readouterr().err


def test_a_stopped_run_tells_which_reports_are_written(monkeypatch, capsys, tmp_path) -> None:
    def measured(name: str, seeds: int, results: object) -> str:
        if name == papers()[2]:
            raise KeyboardInterrupt
        return ''

    monkeypatch.setattr(command, 'reported', measured)
    with pytest.raises(SystemExit) as stopped:
        main(['--results', str(tmp_path)])
    assert stopped.value.code == 130
    first, second, *left = papers()
    words = f'reports written: {first}, {second}; not written: {", ".join(left)}\n'
    assert capsys.readouterr().err == words


@pytest.mark.parametrize('name', papers())
def test_quoted_figures_are_those_of_the_results(name: str) -> None:
    assert disagreements(load_paper(name).quotes) == []


@pytest.mark.parametrize('name', REPORTED)
def test_the_committed_report_has_seeds_enough_and_a_verdict_for_every_claim(name: str) -> None:
    path = RESULTS / f'papers_{name}.md'
    seeds = re.search(r'^(\d+) independent seeds for each rate', path.read_text(), re.MULTILINE)
    assert seeds and int(seeds[1]) >= SEEDS == 200
    rows = [*cells(table_below(CLAIMS, path))]
    assert rows and {row['verdict'] for row in rows} <= {known.value for known in Verdict}
    assert all(row['place'] and row['claim'] and row['judged by'] for row in rows)
