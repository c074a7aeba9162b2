"""Documents say what the committed results say."""

from pathlib import Path

import pytest

from benchmarks.documents import (
    Quote,
    cells,
    counted_verdicts,
    disagreements,
    pages,
    refresh,
    table_below,
    with_figures,
    with_tables,
)

REPORT = """# A paper

## What the paper claims

| place | verdict |
| --- | --- |
| eq. 1 | holds |
| eq. 2 | **does not hold** |
| eq. 3 | cannot be judged from the print |
| eq. 4 | holds |
| eq. 5 | not shown |

## Starts

Words first.

| start | error |
| --- | --- |
| cubic | 0.0523 |
"""


@pytest.fixture
def results(tmp_path: Path) -> Path:
    folder = tmp_path / 'benchmarks' / 'results'
    folder.mkdir(parents=True)
    (folder / 'papers_a.md').write_text(REPORT)
    return folder


@pytest.mark.parametrize('page', pages(), ids=lambda page: page.name)
def test_tables_in_documents_are_those_of_the_results(page: Path) -> None:
    text = page.read_text()
    assert text.count('<!-- papers:begin') == text.count('<!-- papers:end -->')
    assert with_tables(text) == text, 'run `python -m benchmarks.papers --documents`'


def test_a_marked_table_is_replaced_and_nothing_else(results: Path) -> None:
    page = 'Before.\n<!-- papers:begin a: Starts -->\nold\n<!-- papers:end -->\nAfter.\n'
    new = with_tables(page, results)
    assert 'old' not in new and '| cubic | 0.0523 |' in new
    assert new.startswith('Before.\n') and new.endswith('<!-- papers:end -->\nAfter.\n')
    assert with_tables(new, results) == new


def test_a_paper_without_results_says_so(results: Path) -> None:
    page = with_tables('<!-- papers:begin b -->\n<!-- papers:end -->', results)
    assert 'Not measured yet: `python -m benchmarks.papers b`.' in page


def test_verdicts_are_counted(results: Path) -> None:
    page = with_tables('<!-- papers:begin verdicts -->\n<!-- papers:end -->', results)
    assert '| A paper | 5 | 2 | 1 | 1 | 1 |' in page
    assert [*cells(counted_verdicts(results))] == [
        {'paper': 'A paper', 'claims': '5', 'holds': '2', 'does not hold': '1',
         'not shown': '1', 'cannot be judged': '1'}
    ]  # fmt: skip


def test_a_heading_without_a_table_is_told(results: Path) -> None:
    with pytest.raises(ValueError, match=r"has none below 'Ends'"):
        table_below('Ends', results / 'papers_a.md')


@pytest.mark.parametrize(
    ('prose', 'wrong'),
    [
        ('The error is\n0.05 (cubic).', ''),
        ('The error is .0523 (cubic).', ''),
        ('The error is 0.06 (cubic).', 'has 0.06, papers_a.md 0.0523'),
        ('The error is small.', 'no sentence'),
    ],
)
def test_a_quoted_figure_may_be_rounded_to_its_last_digit(
    results: Path, prose: str, wrong: str
) -> None:
    (results.parents[1] / 'page.md').write_text(prose)
    quote = Quote('page.md', r'error is ([\d.]+) \(cubic', 'papers_a.md', r'^\| cubic \| (\S+) \|')
    told = disagreements([quote], results.parents[1])
    assert len(told) == bool(wrong)
    assert not wrong or wrong in told[0]


def test_a_quote_whose_figure_is_gone_from_the_results_is_told(results: Path) -> None:
    (results.parents[1] / 'page.md').write_text('The error is 0.05.')
    quote = Quote('page.md', r'error is ([\d.]+\d)', 'papers_a.md', r'^\| sobol \| (\S+) \|')
    assert 'nothing' in disagreements([quote], results.parents[1])[0]


CUBIC = Quote('page.md', r'error is ([\d.]+) \(cubic', 'papers_a.md', r'^\| cubic \| (\S+) \|')


def test_a_quoted_figure_is_written_with_its_decimals(results: Path) -> None:
    page = 'First.\nThe error\nis 0.07 (cubic), not 0.07.'
    new = with_figures(page, CUBIC, results)
    assert new == 'First.\nThe error\nis 0.05 (cubic), not 0.07.'
    assert with_figures(new, CUBIC, results) == new


def test_pages_are_refreshed_from_the_results(results: Path) -> None:
    root = results.parents[1]
    (root / 'README.md').write_text('The error is 0.071 (cubic).')
    refresh([CUBIC._replace(page='README.md')], root)
    assert (root / 'README.md').read_text() == 'The error is 0.052 (cubic).'


def test_figures_that_are_not_measured_yet_stay(results: Path) -> None:
    (results.parents[1] / 'page.md').write_text('The error is 0.07 (cubic).')
    later = CUBIC._replace(results='papers_b.md')
    assert (
        with_figures('The error is 0.07 (cubic).', later, results) == 'The error is 0.07 (cubic).'
    )
    assert disagreements([later], results.parents[1]) == []
    (told,) = disagreements([later._replace(sentence='no ([0-9]+)')], results.parents[1])
    assert 'no sentence' in told
