"""Gains in evidence that single further jumps promise, to first order, without solving anything.

This is the generalised likelihood ratio of Willsky & Jones (1976, IEEE Trans. Automatic Control 21,
108-112), of parameters in place of states and with a prior of the size. A jump by a size d changes
the residual from r to r + s d, with s (M,) its shape. The squares that it saves, once everything
else has been fitted anew, and what the evidence charges for one more unknown make

    gain = (s'r)^2 / h - log(h / w)    at    d = -s'r / h,    h = s's + w - s'J C J's

with w the prior precision of the size, J the Jacobian and C the covariance of the hypothesis as it
stands. All times and parameters share one rollout: the shapes are sums of forward differences.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from obs_ros.core.linear_algebra import scaled_inverse
from obs_ros.core.typing import Array
from obs_ros.inference.jumps.hypothesis import Hypothesis
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.inference.prior import Prior, box_variances

LEAST_LEFT = 1e-12  # of the determinant, that a wider prior leaves: below is rounding


class Screening(NamedTuple):
    """Gains (T, J) in -2 log evidence, penalties apart, and sizes (T, J) in boxes."""

    gains: Array
    sizes: Array


def screen(base: Hypothesis, times: Array, parameters: Sequence[int]) -> Screening:
    """Screen jumps of each parameter (J,) at each time (T,), a share of the window.

    A jump begins at the nearest node and lasts to the end.
    """
    problem, d = base.problem, len(parameters)
    times = at_nodes(problem.objective.grid.t, times)
    probe = replace(problem, events=(*problem.events, *[tuple(parameters)] * times.size))
    values = np.array([values_at(base, parameter, times) for parameter in parameters]).T
    point = np.concatenate([base.point, np.column_stack([times, values]).ravel()])
    points = np.repeat(point[None], 1 + times.size * d, axis=0)
    places = base.point.size + np.arange(times.size)[:, None] * (1 + d) + 1 + np.arange(d)
    step = np.where(values > 0.5, -1.0, 1.0).ravel() * problem.settings.probe_step
    points[1 + np.arange(step.size), places.ravel()] += step
    rows = probe.rows(points)
    with np.errstate(invalid='ignore'):  # the model may diverge
        pieces = ((rows[:, 1:] - rows[:, :1]) / step).reshape(-1, times.size, d)
    pieces = np.nan_to_num(pieces, nan=0.0, posinf=0.0, neginf=0.0)
    # A piece lasts to the next time; a jump, to the end.
    shapes = np.cumsum(pieces[:, ::-1], axis=1)[:, ::-1].reshape(-1, times.size * d)
    unknowns = problem.objective.unknowns
    variances = box_variances(unknowns)[np.array(parameters) - unknowns.n_states]
    weight = np.tile(1.0 / variances, times.size)
    cross = base.linearisation.jacobian.T @ shapes
    height = (shapes**2).sum(axis=0) + weight
    height -= (cross * (base.covariance @ cross)).sum(axis=0)
    height = np.maximum(height, weight)
    slope = shapes.T @ base.linearisation.residual
    gains = slope**2 / height - np.log(height / weight)
    return Screening(gains.reshape(times.size, d), (-slope / height).reshape(times.size, d))


def screen_earlier(base: Hypothesis, parameters: Sequence[int]) -> tuple[Array, Array]:
    """Screen jumps of each parameter (J,) before the window, which widen the prior of one.

    Returns gains (J,) in -2 log evidence, penalties apart, and the squares (J,) that a window
    would have saved by each. A variance v more at place i takes s g g' from the precision P, with
    g = P e_i and s = v / (1 + v g_i): Sherman & Morrison's formula gives everything else.
    """
    prior, places = base.problem.prior, np.array(parameters)
    unknowns, d = base.problem.objective.unknowns, base.layout.dimension
    columns, own = prior.precision[:, places], prior.precision[places, places]
    variances = box_variances(unknowns)[places - unknowns.n_states]
    share = variances / (1.0 + variances * own)
    step = base.covariance[:d, :d] @ columns
    left = np.maximum(1.0 - share * (columns * step).sum(axis=0), LEAST_LEFT)
    step = step[places, np.arange(places.size)]
    pull = columns.T @ (base.point[:d] - prior.mean)
    gains = share * pull**2 / left - np.log(left) - np.log1p(variances * own)
    size = base.point[places] - prior.mean[places] + step * share * pull / left
    spread = base.covariance[places, places] + share * step**2 / left
    return gains, size**2 / spread


def widened(prior: Prior, unknowns: Unknowns, *places: int) -> Prior:
    """Return the prior with parameters that may since have jumped anywhere in their boxes."""
    covariance = scaled_inverse(prior.precision)
    n = unknowns.n_states
    variances = box_variances(unknowns)
    for place in places:
        covariance[place, place] += variances[place - n]
    wide = Prior.of(unknowns, prior.mean[n:], covariance[n:, n:], prior.gap)
    return replace(wide, given=prior.given)


def at_nodes(t: Array, times: Array) -> Array:
    """Return the shares of the window (T,) at which the nodes nearest to `times` (T,) lie."""
    nodes = np.searchsorted(t, t[0] + times * (t[-1] - t[0]))
    return np.asarray((t[np.clip(nodes, 1, t.size - 2)] - t[0]) / (t[-1] - t[0]))


def values_at(base: Hypothesis, parameter: int, times: Array) -> Array:
    """Return the values (T,) of a parameter at some times, in boxes."""
    values = np.full(times.shape, base.point[parameter])
    for jump in base.layout.jumped(base.point):
        if jump.parameter == parameter:
            values[times >= base.point[base.layout.times[jump.event]]] = base.point[jump.after]
    return values
