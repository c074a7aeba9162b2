"""What makes a paper's report, and the papers that have one."""

import importlib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from benchmarks.documents import CLAIMS, Quote
from benchmarks.papers.claims import Claim, claims_table
from benchmarks.report import filled, pictures, publish

Drawn = Mapping[str, tuple[str, Callable[[], Any]]]  # title and picture, by file name


class Paper(NamedTuple):
    """A paper under test: `benchmarks.papers.NAME.paper.PAPER`.

    `measure` returns the figures of so many seeds for each rate, and nothing but these decides
    them; the others turn figures into claims, tables and pictures. `quotes` are the figures in the
    documents that come from its report.
    """

    title: str
    measure: Callable[[int], Any]
    claims: Callable[[Any], Sequence[Claim]]
    report: Callable[[Any], str]
    pictures: Callable[[Any], Drawn]
    quotes: Sequence[Quote] = ()


def papers() -> list[str]:
    """Return the names of the papers: of the folders beside this file that have one."""
    return sorted(path.parent.name for path in Path(__file__).parent.glob('*/paper.py'))


def load_paper(name: str) -> Paper:
    """Return a paper by its name; raises ModuleNotFoundError for an unknown one."""
    paper = importlib.import_module(f'benchmarks.papers.{name}.paper').PAPER
    assert isinstance(paper, Paper)
    return paper


def reported(name: str, seeds: int, results: Path) -> str:
    """Measure a paper, write `results/papers_NAME.md` with its pictures, and return the text."""
    paper = load_paper(name)
    figures = paper.measure(seeds)
    text = filled(
        'papers/report',
        name=name,
        seeds=seeds,
        heading=CLAIMS,
        claims=claims_table(paper.claims(figures)),
        report=paper.report(figures),
        pictures=pictures(results, paper.pictures(figures)),
    )
    return publish(results, f'papers_{name}', paper.title, text)
