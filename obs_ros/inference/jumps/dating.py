"""Starts for jumps that screening cannot see, dated by the samples that the model alone explains.

Screening is linear. After a jump an oscillation is soon out of phase, and what is linear about a
fit to both sides of it tells nothing. But earlier windows know the parameters before the jump, so
the first part of the window, up to the jump, is noise about the model; it ends soon after. From
there on sizes are scanned all over the box, at some times before that end.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from obs_ros.core.deadline import Deadline
from obs_ros.core.residual_tests import like_noise
from obs_ros.core.typing import Array
from obs_ros.inference.jumps.hypothesis import Hypothesis
from obs_ros.inference.jumps.moves import Start
from obs_ros.inference.jumps.screening import at_nodes
from obs_ros.inference.prior import Posterior
from obs_ros.optimization.levenberg_marquardt import levenberg_marquardt


@dataclass(frozen=True)
class DatingSettings:
    """Limits in dating a jump.

    - `known`: share of its box's variance, below which earlier windows know a parameter;
    - `parts`: of the window, in which its first part, that the model explains, is measured;
    - `iterations`: of the fit of a first part;
    - `back`: parts before its end, in which the jump is sought: a small one shows late;
    - `sizes`: values after the jump, spread over the box;
    - `promising`: share of the squares without a jump, that a scan must fall below to be pursued;
    - `starts`: of different parameters, those of the least squares, that are solved.
    """

    known: float = 0.1
    parts: int = 32
    iterations: int = 15
    back: int = 6
    sizes: int = 32
    promising: float = 0.5
    starts: int = 3


DATING = DatingSettings()


def dated(still: Hypothesis, deadline: Deadline) -> Iterator[Start]:
    """Yield starts with one jump of one parameter each, the most promising first.

    There is none where earlier windows know no parameter, or explain no part. `still` is the
    hypothesis without jumps.
    """
    problem, unknowns = still.problem, still.problem.objective.unknowns
    parameters, n = unknowns.may_jump, unknowns.n_states
    variances = 1.0 / np.diagonal(problem.prior.precision)[n:]
    if not parameters or not (variances < DATING.known * unknowns.box_variances).any():
        return
    part, z = _explained(still, deadline)
    if part == 0:
        return
    first = max(0, part - DATING.back)
    shares = (np.arange(first, part + 1) + 0.5) / DATING.parts
    values = np.linspace(0.0, 1.0, DATING.sizes + 2)[1:-1]
    times = np.unique(at_nodes(problem.objective.grid.t, shares))
    squares = np.array([_scanned(still, z, time, parameters, values) for time in times])
    least = squares.min(axis=(0, 2))
    for i in np.argsort(least)[: DATING.starts]:
        if not least[i] < DATING.promising * still.squares:
            return
        time, size = np.unravel_index(np.argmin(squares[:, i]), squares[:, i].shape)
        point = np.concatenate([z, [times[time], values[size]]])
        yield Start(replace(problem, events=((parameters[i],),)), point, ())


def _explained(still: Hypothesis, deadline: Deadline) -> tuple[int, Array]:
    """Return how many parts from the start the model explains, and its optimum (d,) there."""
    problem, d = still.problem, still.layout.dimension
    posterior = Posterior(problem.objective, problem.prior)
    n = problem.objective.unknowns.n_states
    best = np.concatenate([still.point[:n], problem.prior.mean[n:d]])
    lowest, highest, part = 0, DATING.parts, 1
    while highest - lowest > 1:
        nodes = max(d + 1, posterior.nodes * part // DATING.parts)
        fit = levenberg_marquardt(posterior, best[None], nodes, DATING.iterations, deadline)
        if like_noise(float(fit.squares[0]), posterior.count(nodes)):
            lowest, best = part, fit.z[0]
        elif part == 1:
            break
        else:
            highest = part
        part = (lowest + highest) // 2
    return lowest, best


def _scanned(
    still: Hypothesis, z: Array, time: float, parameters: list[int], values: Array
) -> Array:
    """Return squares (J, V) of each parameter (J,) with each value (V,) from a time on."""
    problem, count = still.problem, len(parameters)
    probe = replace(problem, events=(tuple(parameters),))
    point = np.concatenate([z, [time], z[parameters]])
    points = np.tile(point, (count, values.size, 1))
    for j in range(count):
        points[j, :, z.size + 1 + j] = values
    with np.errstate(all='ignore'):  # the model may diverge
        rows = probe.rows(points.reshape(-1, point.size))
    measured = problem.objective.grid.weight > 0.0
    scaled = (problem.objective.grid.weight * problem.objective.grid.y)[measured]
    squares = np.sum((rows - scaled[:, None]) ** 2, axis=0)
    return np.asarray(np.nan_to_num(squares, nan=np.inf).reshape(count, values.size))
