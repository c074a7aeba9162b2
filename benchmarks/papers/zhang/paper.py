"""Zhang et al. 2020: interconnected observer of a heat exchanger's flows, through two valves.

Settling without noise, errors with noise over many seeds, and which valve the residuals name;
beside it sliding windows on the same plant.
"""

from functools import partial

from benchmarks.documents import Quote
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


RESULTS, PAGE = 'papers_zhang.md', 'docs/which-observer.md'
PAIR = r'([\d.]+) % / ([\d.]+) %'
# Cells with a median and its interval: of Fp and of Fu, on plateaus and in motion.
NOISY = r'\| ([\d.]+) \([^)]*\), [\d.]+ \| \d+ \| ([\d.]+) \('
MOVING = r'\| ([\d.]+) \([^)]*\) \| ([\d.]+) \('
QUOTES = tuple(
    Quote(PAGE, sentence, RESULTS, f'^\\| {measured}')
    for sentence, measured in (
        (f'with theta 2 and 0.05 K of noise, {PAIR} of Fp', f'interconnected, theta 2 {NOISY}'),
        (r'in (\d+) of (\d+) runs of the utility valve and (\d+) of (\d+) of the process',
         r'interconnected, theta 2 \| (\d+) of (\d+) \([^|]*\| (\d+) of (\d+) \('),
        (f'while valves move it has {PAIR}', f'high gain, theta 2 {MOVING}'),
        (f'and `interconnected` {PAIR}', f'interconnected, theta 2 {MOVING}'),
        (r'settles in ([\d.]+) s \(Fp\) and ([\d.]+) s \(Fu\)',
         r'unknown input \| [^|]*\| [\d.]+ \| ([\d.]+) / ([\d.]+) \|'),
        (f'after a fault, with {PAIR} of noise', f'unknown input {NOISY}'),
        (r'theta 80 settles in ([\d.]+) s in its',
         r'interconnected, theta 80 \| ([\d.]+) / [\d.]+ \| [\d.]+ \|'),
        (f'turns 0.05 K into {PAIR}', f'interconnected, theta 80 {NOISY}'),
    )
)  # fmt: skip

PAPER = Paper(
    title='Zhang et al. 2020: interconnected observer of the flows of a heat exchanger',
    measure=measure,
    claims=claims,
    report=report,
    pictures=pictures,
    quotes=QUOTES,
)
