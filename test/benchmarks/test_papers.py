"""The frame of the papers' audits: claims, seeds, and what every paper has."""

import math
import re

import pytest

from benchmarks.documents import CLAIMS, RESULTS, cells, disagreements, table_below
from benchmarks.papers.__main__ import SEEDS, main
from benchmarks.papers.claims import Claim, Verdict, claims_table, reliable, share, verdict
from benchmarks.papers.paper import load_paper, papers
from benchmarks.papers.seeds import seeds_of

REPORTED = [name for name in papers() if (RESULTS / f'papers_{name}.md').exists()]


def test_a_claim_is_a_row_with_its_verdict() -> None:
    rows = [
        Claim('eq. 3', 'x is found', '200 seeds', share(200, 200), verdict(True), '1e-3'),
        Claim('Fig. 4', 'y stays small', '', '', verdict(False)),
        Claim('5.1', 'z is robust', 'no figure in print', '', Verdict.CANNOT_BE_JUDGED),
    ]
    assert claims_table(rows).splitlines() == [
        '| place | claim | judged by | found | verdict | our default |',
        '| --- | --- | --- | --- | --- | --- |',
        '| eq. 3 | x is found | 200 seeds | 200 of 200 (0.982 to 1.000) | holds | 1e-3 |',
        '| Fig. 4 | y stays small |  |  | **does not hold** |  |',
        '| 5.1 | z is robust | no figure in print |  | cannot be judged from the print |  |',
    ]


def test_what_fails_rarely_is_reliable() -> None:
    assert reliable(3, 200) and not reliable(5, 200) and not reliable(0, 50)


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
