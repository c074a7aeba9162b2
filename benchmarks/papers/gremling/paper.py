"""Gremling & Passino 2000: genetic adaptive state estimation, parameters by a base-10 GA online.

The paper's mode and the default beside the adaptive Luenberger observer, least squares and Kalman
filters on two linear plants and a jet engine.
"""

from functools import partial

from benchmarks.documents import Quote
from benchmarks.papers.gremling.claims import claims
from benchmarks.papers.gremling.pictures import draw
from benchmarks.papers.gremling.report import report
from benchmarks.papers.gremling.run import Figures, measure
from benchmarks.papers.paper import Drawn, Paper


def pictures(figures: Figures) -> Drawn:
    """Return the picture by file name."""
    return {'papers_gremling.png': ('figures 2 to 5', partial(draw, figures.outcomes))}


RESULTS, PAGE = 'papers_gremling.md', 'docs/which-observer.md'
# Sums of squared errors of x2 / x3, by plant and observer.
QUOTES = tuple(
    Quote(PAGE, sentence, RESULTS, rf'^\| {plant} \| {observer} \| 1 \| ([\d.]+) / ([\d.]+) \|')
    for plant, observer, sentence in (
        ('minimum phase', r'RLS \+ Luenberger', r'over 100 s are ([\d.]+) / ([\d.]+) and'),
        ('non-minimum phase', r'RLS \+ Luenberger',
         r'over 100 s are [\d.]+ / [\d.]+ and ([\d.]+) / ([\d]+)\.'),
        ('minimum phase', 'adaptive Luenberger', r'within 0.5 %: ([\d.]+) / ([\d.]+) and'),
        ('non-minimum phase', 'adaptive Luenberger',
         r'within 0.5 %: [\d.]+ / [\d.]+ and ([\d.]+) / ([\d.]+),'),
    )
)  # fmt: skip

PAPER = Paper(
    title='Gremling & Passino 2000: genetic adaptive state estimation',
    measure=measure,
    claims=claims,
    report=report,
    pictures=pictures,
    quotes=QUOTES,
)
