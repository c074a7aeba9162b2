"""Covariance of an output-error estimate of a plant whose states are pushed about.

Output error takes all that it misses for noise of the outputs. With J the Jacobian of the residuals
e, H = J'J + P and S the covariance of e under process noise, its estimate has the covariance

    H^-1 (J' S J + P) H^-1

(White 1982, Econometrica 50, 1-25; Ljung 1999, section 9.2). S need not be formed: with F and C of
the filter's pass, lambda_k = F_k' lambda_(k+1) + C_k' W_k J_k goes back through the window, and

    J' S J = sum_k lambda_k' Q_k lambda_k + J_k' W_k R W_k J_k,    W_k the weights,

with Q_k the noise that an interval adds, as in `FilterPass`.
"""

import numpy as np

from obs_ros.core.typing import Array
from obs_ros.inference.jumps.hypothesis import Hypothesis
from obs_ros.inference.process_noise import ProcessNoise
from obs_ros.integration.filter_pass import FilterPass


def output_error_covariance(plain: Hypothesis, noise: ProcessNoise, along: FilterPass) -> Array:
    """Return the covariance (d, d) of a hypothesis without jumps, under process noise.

    `along` is the filter's pass along its point.
    """
    n = along.transition.shape[1]
    weight = plain.problem.objective.grid.weight
    measured = weight > 0.0
    rows = np.zeros((*weight.shape, plain.point.size))
    rows[measured] = plain.linearisation.jacobian
    noises = (rows * (weight * noise.noise)[:, :, None])[measured]
    spread = noises.T @ noises
    sources = np.einsum('kra,krd->kad', along.sensitivity[:, :, :n] * weight[:, :, None], rows)
    adjoint = np.zeros(sources.shape[1:])
    walks = noise.walks[:n, None]
    for k in range(len(sources) - 1, 0, -1):
        adjoint = adjoint + sources[k]
        before = along.transition[k - 1, :, :n].T @ adjoint
        for pushed in (walks * adjoint, walks * (adjoint + before), walks * before):
            spread += along.dt[k - 1] / 6.0 * pushed.T @ pushed
        adjoint = before
    bread = plain.covariance
    precision = plain.problem.precision(plain.point)
    return np.asarray(bread @ (spread + precision) @ bread)
