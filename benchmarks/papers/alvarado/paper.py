"""Alvarado-Méndez et al. 2024: H-infinity adaptive observer of a suspension's tyre stiffness.

The printed equations without noise, and with noise the package's observers beside each other on
several roads.
"""

from functools import partial

from benchmarks.documents import Quote
from benchmarks.papers.alvarado.claims import claims
from benchmarks.papers.alvarado.pictures import draw_stiffness
from benchmarks.papers.alvarado.report import report
from benchmarks.papers.alvarado.run import Figures, measure
from benchmarks.papers.paper import Drawn, Paper


def pictures(figures: Figures) -> Drawn:
    """Return the pictures by file name."""
    return {'papers_alvarado_kt.png': ('kt over time', partial(draw_stiffness, figures.first))}


RESULTS = 'papers_alvarado.md'
OBSERVERS, FAULTS = 'docs/which-observer.md', 'docs/fault-isolation.md'
# Rows of the errors by drive: medians of the filtered regressor and of the EKF, largest of windows.
MEDIANS = r'\| [^|]*\| ([\d.]+) \([^|]*\| ([\d.]+) \('
LARGEST = r'\| (?:[^|]*\| ){3}[^|]*largest ([\d.]+) \|'
TRAPEZOID = r'^\| trap, eta 300 N, 0\.1 mm'
QUOTES = (
    Quote(OBSERVERS, r'within 10 % at most ([\d.]+) s after a bump starts', RESULTS,
          TRAPEZOID + r': filtered regressor[^|]*within 10 % of kt[^|]*\| ([\d.]+) s \|'),
    Quote(OBSERVERS, r'and has ([\d.]+) % RMS under 300 N, where an EKF that estimates the '
          r'disturbance too has ([\d.]+) %', RESULTS, f'{TRAPEZOID} {MEDIANS}'),
    Quote(OBSERVERS, r'the filtered regressor has ([\d.]+) %, the EKF ([\d.]+) %', RESULTS,
          rf'^\| kt_step, eta 300 N, 0\.1 mm {MEDIANS}'),
    Quote(FAULTS, r'kt is right within ([\d.]+) % while 300 N', RESULTS, f'{TRAPEZOID} {LARGEST}'),
    Quote(FAULTS, r'kt is right within ([\d.]+) % by windows of 1 s and within ([\d.]+) % by '
          r'windows of 3 s', RESULTS,
          rf'^\| cos, eta 0 N, 1 mm {LARGEST} [^|]*largest ([\d.]+) \|'),
)  # fmt: skip

PAPER = Paper(
    title="Alvarado-Méndez et al. 2024: H-infinity adaptive observer of a tyre's stiffness",
    measure=measure,
    claims=claims,
    report=report,
    pictures=pictures,
    quotes=QUOTES,
)
