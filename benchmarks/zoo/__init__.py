"""Plants to try the search on, and random windows of them by seed.

Every model here is one like any user's. Noise is given as a signal-to-noise ratio: of the tanks
against 1 cm, as in the paper, of the others against each output's own standard deviation.
`experiments` has plants under poor and rich inputs, with noise in the outputs' units.
"""

from benchmarks.zoo.cases import CASES, MANY_UNKNOWNS, Case
from benchmarks.zoo.windows import Drawn, draw

__all__ = ['CASES', 'MANY_UNKNOWNS', 'Case', 'Drawn', 'draw']
