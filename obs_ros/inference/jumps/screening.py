"""Gains in evidence that single further jumps promise, to first order, without solving anything.

This is the generalised likelihood ratio of Willsky & Jones (1976, IEEE Trans. Automatic Control 21,
108-112), of parameters in place of states and with a prior of the size. A jump by a size d changes
the residual from r to r + s d, with s (M,) its shape. The squares that it saves, once everything
else has been fitted anew, and what the evidence charges for one more unknown make

    gain = (s'r)^2 / h - log(h / w)    at    d = -s'r / h,    h = s's + w - s'J C J's

with w the prior precision of the size, J the Jacobian and C the covariance of the hypothesis as it
stands. One pass backward over one-step sensitivities gives the products of s for every sample as a
candidate time, see `sensitivities`.
"""

import functools
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from obs_ros.core.jit import accelerated
from obs_ros.core.linear_algebra import scaled_inverse
from obs_ros.core.typing import Array, IntArray
from obs_ros.inference.jumps.hypothesis import Hypothesis
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.jumps.sensitivities import products
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.inference.prior import Prior
from obs_ros.integration.delayed import DelayedKernels

HUGE = float(np.finfo(np.float64).max)
LEAST_LEFT = 1e-12  # of the determinant, that a wider prior leaves: below is rounding


class Screening(NamedTuple):
    """Gains (T, J) in -2 log evidence, penalties apart, and sizes (T, J) in boxes.

    Jumps begin at times (T,), shares of the window.
    """

    times: Array
    gains: Array
    sizes: Array


@functools.cache
def prepare() -> None:
    """Compile what is below, or load it compiled."""
    one, row = np.ones((2, 1)), np.ones(1)
    gains, _ = _gains(one, np.ones((2, 1, 2)), one[:1], row, 1.0)
    time_averages(np.arange(2.0), gains)
    _gains_earlier(np.zeros(1, dtype=np.int64), row, row, row, one[:1], one[:1])


def screen(base: Hypothesis, parameters: Sequence[int], times: Array | None = None) -> Screening:
    """Screen jumps of each parameter (J,) at each time (T,), a share of the window.

    A jump begins at the nearest node and lasts to the end. One right after the start is hardly told
    from another value all along, and then has no gain. Without times (None) all nodes from
    `settings.earliest` on are screened, or `settings.times_rolled` of them where candidates must be
    rolled out.
    """
    problem, linear = base.problem, base.linearisation
    nodes: slice | IntArray
    settings, t = problem.settings, problem.objective.grid.t
    columns = np.column_stack([linear.residual, linear.jacobian])
    if sees_every_node(problem):
        if times is None:
            since = t - t[0]
            nodes = slice(int(np.searchsorted(since, settings.earliest * since[-1])), t.size - 1)
        else:
            nodes = nearest_nodes(t, times)
        every = products(base, parameters, problem.at_nodes(columns))
        squares, pulled = every.squares[nodes], every.columns[nodes]
    else:
        if times is None:
            times = np.arange(1, settings.times_rolled) / settings.times_rolled
        nodes = nearest_nodes(t, times)
        shapes = _rolled_out(base, (t[nodes] - t[0]) / (t[-1] - t[0]), parameters)
        squares = (shapes**2).sum(axis=0)
        pulled = (shapes.reshape(len(shapes), -1).T @ columns).reshape(*squares.shape, -1)
    unknowns = problem.objective.unknowns
    weight = 1.0 / unknowns.box_variances[np.array(parameters) - unknowns.n_states]
    found = _gains(squares, pulled, base.covariance, weight, settings.least_share)
    return Screening((t[nodes] - t[0]) / (t[-1] - t[0]), *found)


def _gains_on_arrays(
    squares: Array, pulled: Array, covariance: Array, weight: Array, least_share: float
) -> tuple[Array, Array]:
    """Return the same on whole arrays."""
    slope, cross = pulled[:, :, 0], pulled[:, :, 1:]
    height = squares + weight - ((cross @ covariance) * cross).sum(axis=2)
    told = height > least_share * squares
    height = np.maximum(height, weight)
    gains = np.where(told, slope**2 / height - np.log(height / weight), -np.inf)
    return gains, -slope / height


def _gains_in_loops(
    squares: Array, pulled: Array, covariance: Array, weight: Array, least_share: float
) -> tuple[Array, Array]:
    """Return gains (T, J) and sizes (T, J) by products of shapes (T, J) and (T, J, 1 + D).

    `weight` (J,) are the prior precisions of the sizes.
    """
    times, count = squares.shape
    d = len(covariance)
    gains, sizes = np.empty((times, count)), np.empty((times, count))
    for k in range(times):
        for j in range(count):
            explained = 0.0
            for a in range(d):  # of a symmetric matrix, twice the half below its diagonal
                total = 0.5 * covariance[a, a] * pulled[k, j, 1 + a]
                for b in range(a):
                    total += covariance[a, b] * pulled[k, j, 1 + b]
                explained += 2.0 * total * pulled[k, j, 1 + a]
            height = squares[k, j] + weight[j] - explained
            told = height > least_share * squares[k, j]
            height = max(height, weight[j])
            slope = pulled[k, j, 0]
            sizes[k, j] = -slope / height
            gains[k, j] = slope**2 / height - np.log(height / weight[j]) if told else -np.inf
    return gains, sizes


_gains = accelerated(_gains_in_loops, _gains_on_arrays)


@accelerated
def time_averages(times: Array, gains: Array) -> Array:
    """Return -2 log of the inverse mean (J,) of exp(gain / 2) over a window, by gains (T, J).

    Each of the times (T,), shares of the window, stands for the part up to the next.
    """
    found = np.empty(gains.shape[1])
    for j in range(gains.shape[1]):
        best = -HUGE  # no gain at all: minus infinity
        for k in range(times.size):
            best = max(best, gains[k, j])
        total = 0.0
        for k in range(times.size):
            ahead = min(k, times.size - 2)
            total += (times[ahead + 1] - times[ahead]) * np.exp(0.5 * (gains[k, j] - best))
        found[j] = best + 2.0 * np.log(total)
    return found


def sees_every_node(problem: PiecewiseProblem) -> bool:
    """Whether every node is screened, not rollouts: not with delays, nor parameters that walk."""
    injection = problem.objective.grid.injection
    walking = injection is not None and injection.moving.size > 0
    return not (walking or isinstance(problem.objective.kernels, DelayedKernels))


def _rolled_out(base: Hypothesis, times: Array, parameters: Sequence[int]) -> Array:
    """Return the shapes (M, T, J) of jumps by sums of forward differences, all in one rollout."""
    problem, d = base.problem, len(parameters)
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
    return np.asarray(np.cumsum(pieces[:, ::-1], axis=1)[:, ::-1])


def screen_earlier(base: Hypothesis, parameters: Sequence[int]) -> tuple[Array, Array]:
    """Screen jumps of each parameter (J,) before the window, which widen the prior of one.

    Returns gains (J,) in -2 log evidence, penalties apart, and the squares (J,) that a window
    would have saved by each. A variance v more at place i takes s g g' from the precision P, with
    g = P e_i and s = v / (1 + v g_i): Sherman & Morrison's formula gives everything else.
    """
    prior, places = base.problem.prior, np.array(parameters)
    unknowns, d = base.problem.objective.unknowns, base.layout.dimension
    variances = unknowns.box_variances[places - unknowns.n_states]
    return _gains_earlier(
        places, variances, base.point[:d], prior.mean, prior.precision, base.covariance
    )


@accelerated
def _gains_earlier(
    places: IntArray, variances: Array, point: Array, mean: Array, precision: Array,
    covariance: Array,
) -> tuple[Array, Array]:  # fmt: skip
    """Return gains (J,) and squares (J,); see `screen_earlier`."""
    d, gains, squares = point.size, np.empty(places.size), np.empty(places.size)
    for j in range(places.size):
        i, variance = places[j], variances[j]
        share = variance / (1.0 + variance * precision[i, i])
        step, bent, pull = 0.0, 0.0, 0.0
        for a in range(d):
            total = 0.0
            for b in range(d):
                total += covariance[a, b] * precision[b, i]
            step = total if a == i else step
            bent += precision[a, i] * total
            pull += precision[a, i] * (point[a] - mean[a])
        left = max(1.0 - share * bent, LEAST_LEFT)
        gains[j] = share * pull**2 / left - np.log(left) - np.log1p(variance * precision[i, i])
        size = point[i] - mean[i] + step * share * pull / left
        squares[j] = size**2 / (covariance[i, i] + share * step**2 / left)
    return gains, squares


def widened(prior: Prior, unknowns: Unknowns, *places: int) -> Prior:
    """Return the prior with parameters that may since have jumped anywhere in their boxes."""
    covariance = scaled_inverse(prior.precision)
    n = unknowns.n_states
    variances = unknowns.box_variances
    for place in places:
        covariance[place, place] += variances[place - n]
    wide = Prior.of(unknowns, prior.mean[n:], covariance[n:, n:], prior.gap)
    return replace(wide, given=prior.given)


def nearest_nodes(t: Array, times: Array) -> IntArray:
    """Return the nodes (T,) nearest to `times` (T,), shares of the window, at which jumps begin."""
    nodes = np.searchsorted(t, t[0] + times * (t[-1] - t[0]))
    return np.asarray(np.clip(nodes, 1, t.size - 2))


def at_nodes(t: Array, times: Array) -> Array:
    """Return the shares of the window (T,) at which the nodes nearest to `times` (T,) lie."""
    return np.asarray((t[nearest_nodes(t, times)] - t[0]) / (t[-1] - t[0]))


def values_at(base: Hypothesis, parameter: int, times: Array) -> Array:
    """Return the values (T,) of a parameter at some times, in boxes."""
    values = np.full(times.shape, base.point[parameter])
    for jump in base.layout.jumped(base.point):
        if jump.parameter == parameter:
            values[times >= base.point[base.layout.times[jump.event]]] = base.point[jump.after]
    return values
