"""Gremling & Passino 2000: genetic adaptive state estimation, parameters by a base-10 GA online.

The paper's mode and the default beside the adaptive Luenberger observer, least squares and Kalman
filters on two linear plants and a jet engine.
"""

from functools import partial

from benchmarks.papers.gremling.claims import claims
from benchmarks.papers.gremling.pictures import draw
from benchmarks.papers.gremling.report import report
from benchmarks.papers.gremling.run import Figures, measure
from benchmarks.papers.paper import Drawn, Paper


def pictures(figures: Figures) -> Drawn:
    """Return the picture by file name."""
    return {'papers_gremling.png': ('figures 2 to 5', partial(draw, figures.outcomes))}


PAPER = Paper(
    title='Gremling & Passino 2000: genetic adaptive state estimation',
    measure=measure,
    claims=claims,
    report=report,
    pictures=pictures,
)
