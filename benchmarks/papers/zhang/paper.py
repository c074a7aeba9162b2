"""Zhang et al. 2020: interconnected observer of a heat exchanger's flows, through two valves.

Settling without noise, errors with noise over many seeds, and which valve the residuals name;
beside it sliding windows on the same plant.
"""

from functools import partial

from benchmarks.papers.paper import Drawn, Paper
from benchmarks.papers.zhang.claims import claims
from benchmarks.papers.zhang.pictures import draw_flows
from benchmarks.papers.zhang.report import report
from benchmarks.papers.zhang.run import Figures, measure


def pictures(figures: Figures) -> Drawn:
    """Return the pictures by file name."""
    return {
        'papers_zhang_flows.png': ('flows in the three cases', partial(draw_flows, figures.first))
    }


PAPER = Paper(
    title='Zhang et al. 2020: interconnected observer of the flows of a heat exchanger',
    measure=measure,
    claims=claims,
    report=report,
    pictures=pictures,
)
