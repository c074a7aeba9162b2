"""Porter & Passino 1995: genetic adaptive observers, gains evolved online by a base-10 GA.

The paper's mode beside its variants, a constant gain and Kalman filters on the linear plant and the
glycolytic oscillator.
"""

from functools import partial

from benchmarks.documents import Quote
from benchmarks.papers.paper import Drawn, Paper
from benchmarks.papers.porter.claims import claims
from benchmarks.papers.porter.pictures import draw
from benchmarks.papers.porter.plan import Outcomes
from benchmarks.papers.porter.report import report
from benchmarks.papers.porter.run import measure


def pictures(outcomes: Outcomes) -> Drawn:
    """Return the picture by file name."""
    return {'papers_porter.png': ('figures 1 to 12', partial(draw, outcomes))}


RESULTS, PAGE = 'papers_porter.md', 'docs/which-observer.md'
QUOTES = (
    Quote(PAGE, r'without the freeze (\d+) of 1200 runs of six cases', RESULTS,
          r'^\| all \| (\d+) of 1200'),
    Quote(PAGE, r'`tries` 0, the default\), (\d+) of', RESULTS,
          r'^\| all \| \d+ of 1200 \([^)]*\) \| (\d+) of 1200'),
    Quote(PAGE, r'freezes mean gains, (\d+) of 1200 fail', RESULTS, r'base 10: (\d+) of 1200'),
)  # fmt: skip

PAPER = Paper(
    title='Porter & Passino 1995: genetic adaptive observers',
    measure=measure,
    claims=claims,
    report=report,
    pictures=pictures,
    quotes=QUOTES,
)
