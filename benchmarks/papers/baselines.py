"""Plain methods beside the genetic observers: a constant gain, an open loop, least squares.

They know the truth's inputs and outputs only; each returns states (K, n) from 0.
"""

from collections.abc import Callable, Mapping

import numpy as np

from benchmarks.papers.truth import PERIOD, Truth
from obs_ros import Model, Record
from obs_ros.core.deadline import Deadline
from obs_ros.core.model import names
from obs_ros.core.typing import Array
from obs_ros.inference.objective import Objective
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid
from obs_ros.observers.papers.euler import euler_step
from obs_ros.optimization.levenberg_marquardt import levenberg_marquardt

ITERATIONS = 100  # of Levenberg-Marquardt, at most


@np.errstate(all='ignore')  # what diverges is judged, not warned of
def constant_gain(model: Model, truth: Truth, gains: tuple[float, ...]) -> Array:
    """Run the genetic observer's equation with one gain: forward Euler, y = x1, from 0."""
    p = np.array([variable.nominal for variable in model.parameters])
    x = np.zeros_like(truth.x)
    for k in range(len(truth.t) - 1):
        error = truth.y[k, 0] - x[k, 0]
        step = euler_step(model, truth.t[k], PERIOD, x[k], truth.u[k], p)
        x[k + 1] = step + np.array(gains) * error
    return x


@np.errstate(all='ignore')
def open_loop(model: Model, truth: Truth) -> Array:
    """Run the model with its parameters in the middle of their ranges, uncorrected, from 0."""
    p = np.array([0.5 * (variable.lower + variable.upper) for variable in model.parameters])
    x = np.zeros_like(truth.x)
    for k in range(len(truth.t) - 1):
        x[k + 1] = euler_step(model, truth.t[k], PERIOD, x[k], truth.u[k], p)
    return x


def window_fit(model: Model, truth: Truth, window: int) -> Array:
    """Fit the genetic estimator's windows by Levenberg-Marquardt alone, from the fit before.

    Parameters only, within their bounds: a window begins at the measured output and the hidden
    states estimated there, as for the genetic algorithm. The states are those at its end.
    """
    kernels, states = kernels_for(model), names(model.states)
    x = np.zeros_like(truth.x)
    p = {v.name: 0.5 * (v.lower + v.upper) for v in model.parameters}
    for k in range(1, len(truth.t)):
        first = max(0, k - window - 1)
        start = np.concatenate([truth.y[first], x[first, 1:]])
        unknowns = Unknowns.of(model, None, (), dict(zip(states, start, strict=True)))
        rows = slice(first, k + 1)
        record = Record(truth.t[rows], truth.u[rows], truth.y[rows])
        objective = Objective(kernels, Grid.of(model, record, np.ones(1)), unknowns)
        z = unknowns.point(p)[None]
        z = levenberg_marquardt(objective, z, objective.nodes, ITERATIONS, Deadline()).z[0]
        x[k] = objective.trajectory(z)[0][-1]
        p = dict(zip(unknowns.names, unknowns.values(z[None])[1][:, 0], strict=True))
    return x


BASELINES: Mapping[str, Callable[..., Array]] = {
    'constant gain': constant_gain, 'open loop': open_loop, 'window fit': window_fit
}  # fmt: skip
