"""Noise of the outputs by likelihood: white or correlated, of the size that is known or any.

A sensor that filters gives noise of first order, v_k = c v_(k-1) + w_k, w_k ~ N(0, (1 - c^2) R),
with R the variance of any sample (Box, Jenkins & Reinsel 2008, section 3.2). It is a rival of
process noise: what a sensor leaves from one sample to the next pushes no state.
"""

import numpy as np

from obs_ros.core.residual_tests import LIMITS, inflation
from obs_ros.core.typing import Array

TRIED = np.tanh(np.linspace(0.0, np.arctanh(LIMITS.most_correlation), 160))  # correlations
INFLATED = np.array([inflation(c) for c in TRIED])
# Of -2 log p: very strong evidence (Kass & Raftery 1995, J. Am. Stat. Assoc. 90, 773-795). What
# pushes a state that is measured looks much like noise of the state's own time constant.
EVIDENCE = 10.0


def likeliest_noise(residuals: Array) -> float:
    """Return -2 log p of scaled residuals (K, r; NaN = not measured) under the likeliest noise.

    It is but for a constant: white noise of the known size has the sum of squares. A correlation,
    and a size that is found, cost log N each for every output, with N all that was measured (BIC).
    Correlated noise must be likelier than white by `EVIDENCE` besides, finds no size above the
    known one, and forgets within an eighth of the samples: what does not is what the model lacks.
    """
    measured = np.isfinite(residuals)
    price = float(np.log(max(1, measured.sum())))
    white = likeliest = 0.0
    for column, known in zip(residuals.T, measured.T, strict=True):
        r = column[known]
        if not r.any():
            continue
        short = TRIED[INFLATED * LIMITS.blocks[0] <= max(r.size, LIMITS.blocks[0])]
        squares, shrunk = _whitened(r, short)
        freed = r.size * (np.log(squares / r.size) + 1.0) + price
        freed[1:][squares[1:] > r.size] = np.inf
        found = np.minimum(squares, freed) + shrunk
        white += float(found[0])
        likeliest += min(float(found[0]), float(found[1:].min(initial=np.inf)) + price)
    return min(white, likeliest + EVIDENCE)


def _whitened(r: Array, c: Array) -> tuple[Array, Array]:
    """Return the squares (m,) of residuals (N,) whitened by correlations c (m,), and log det's."""
    ahead, behind, product = r[1:] @ r[1:], r[:-1] @ r[:-1], r[1:] @ r[:-1]
    squares = r[0] ** 2 + (ahead - 2.0 * c * product + c**2 * behind) / (1.0 - c**2)
    return squares, (r.size - 1) * np.log1p(-(c**2))
