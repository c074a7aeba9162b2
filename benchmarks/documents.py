"""Documents kept to the committed results: tables that come from them, and figures in prose.

A table stands between `<!-- papers:begin NAME: HEADING -->` and `<!-- papers:end -->`: the first
one below that heading of `results/papers_NAME.md`. Without a heading it is that of the claims;
`verdicts` in place of a name counts the verdicts of all papers.
"""

import re
from collections.abc import Iterable, Iterator, Sequence
from decimal import Decimal
from pathlib import Path
from typing import NamedTuple

from benchmarks.report import table

ROOT = Path(__file__).parents[1]
RESULTS = Path(__file__).with_name('results')
CLAIMS = 'What the paper claims'
VERDICTS = 'verdicts'
MARKED = re.compile(
    r'(<!-- papers:begin (\w+)(?:: ([^>]+?))? -->\n).*?(<!-- papers:end -->)', re.DOTALL
)


class Quote(NamedTuple):
    """Figures in prose, and where they were measured.

    `sentence` is a regular expression on the page, in which a blank stands for any white space,
    `measured` one on the file of results, within a line; their groups are the figures, in the same
    order. Figures of a file that is not there yet stay as they are.
    """

    page: str
    sentence: str
    results: str
    measured: str


def pages(root: Path = ROOT) -> list[Path]:
    """Return README, CHANGELOG and the pages of docs/."""
    named = [root / 'README.md', root / 'CHANGELOG.md', *sorted((root / 'docs').glob('*.md'))]
    return [page for page in named if page.exists()]


def refresh(quotes: Sequence[Quote] = (), root: Path = ROOT) -> None:
    """Write the tables that come from the results into all pages, and the figures quoted."""
    results = root / 'benchmarks' / 'results'
    for page in pages(root):
        text = page.read_text(encoding='utf-8')
        new = with_tables(text, results)
        for quote in quotes:
            if root / quote.page == page:
                new = with_figures(new, quote, results)
        if new != text:
            page.write_text(new, encoding='utf-8')


def with_tables(text: str, results: Path = RESULTS) -> str:
    """Return a page's text with its marked tables as the results have them."""

    def renewed(found: re.Match[str]) -> str:
        begin, name, heading, end = found.groups()
        path = results / f'papers_{name}.md'
        if name == VERDICTS:
            content = counted_verdicts(results)
        elif path.exists():
            content = table_below(heading or CLAIMS, path)
        else:
            content = f'Not measured yet: `python -m benchmarks.papers {name}`.'
        return f'{begin}\n{content}\n\n{end}'

    return MARKED.sub(renewed, text)


def table_below(heading: str, path: Path) -> str:
    """Return the first table below a heading of a report.

    Raises ValueError where there is none.
    """
    text = path.read_text(encoding='utf-8')
    below = re.search(rf'^#+ {re.escape(heading)}$(.*?)(?=^#+ |\Z)', text, re.DOTALL | re.MULTILINE)
    found = re.search(r'^\|.*\|(?:\n\|.*\|)*', below[1], re.MULTILINE) if below else None
    if found is None:
        raise ValueError(f'name a heading with a table: {path.name} has none below {heading!r}')
    return found[0]


def cells(markdown: str) -> Iterator[dict[str, str]]:
    """Yield the rows of a Markdown table by the heads of its columns."""
    rows = [[cell.strip() for cell in line.strip('|').split('|')] for line in markdown.splitlines()]
    for row in rows[2:]:
        yield dict(zip(rows[0], row, strict=True))


def counted_verdicts(results: Path = RESULTS) -> str:
    """Return the table of how many claims of each paper hold, by the committed reports."""
    rows = []
    for path in sorted(results.glob('papers_*.md')):
        title = path.read_text(encoding='utf-8').splitlines()[0].lstrip('# ')
        verdicts = [row['verdict'] for row in cells(table_below(CLAIMS, path))]
        judged = {
            word: sum(told.strip('*').startswith(word) for told in verdicts)
            for word in ('holds', 'does not hold', 'not shown', 'cannot be judged')
        }
        rows.append({'paper': title, 'claims': len(verdicts)} | judged)
    return table(rows)


def with_figures(text: str, quote: Quote, results: Path = RESULTS) -> str:
    """Return a page's text with the figures of a quote as measured, as many decimals as before."""
    found = _measured(quote, results)
    told = re.search(quote.sentence.replace(' ', r'\s+'), text)
    if found is None or told is None or len(told.groups()) != len(found.groups()):
        return text
    for i in range(len(found.groups()), 0, -1):
        figure = Decimal(found[i]).quantize(Decimal(told[i]))
        text = f'{text[: told.start(i)]}{figure}{text[told.end(i) :]}'
    return text


def _measured(quote: Quote, results: Path) -> re.Match[str] | None:
    path = results / quote.results
    text = path.read_text(encoding='utf-8') if path.exists() else ''
    return re.search(quote.measured, text, re.MULTILINE)


def disagreements(quotes: Iterable[Quote], root: Path = ROOT) -> list[str]:
    """Return what is wrong with quoted figures: each may be rounded, to its own last digit."""
    return [wrong for quote in quotes for wrong in _disagreements(quote, root)]


def _disagreements(quote: Quote, root: Path) -> Iterator[str]:
    page = ' '.join((root / quote.page).read_text(encoding='utf-8').split())
    results = root / 'benchmarks' / 'results'
    told, found = re.search(quote.sentence, page), _measured(quote, results)
    if told is None:
        yield f'{quote.page}: no sentence {quote.sentence!r}'
    if found is None and (results / quote.results).exists():
        yield f'{quote.results}: nothing {quote.measured!r}'
    if told is None or found is None:
        return
    if len(told.groups()) != len(found.groups()) or not told.groups():
        yield f'{quote.page}: as many figures are needed as {quote.results} has: {quote.sentence!r}'
        return
    for figure, measured in zip(told.groups(), found.groups(), strict=True):
        value = Decimal(figure)
        half = Decimal(5).scaleb(int(value.as_tuple().exponent) - 1)
        if abs(value - Decimal(measured)) > half:
            yield f'{quote.page}: {told[0]!r} has {figure}, {quote.results} {measured}'
