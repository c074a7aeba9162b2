"""Combinations of parameters that a window does not determine, and longer windows that would.

A direction is not determined where its information is below that of a standard deviation of a tenth
of the box (local identifiability; Ljung 1999, section 4.5; Bellman & Astrom 1970).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from obs_ros.core.linear_algebra import eigen, inverted
from obs_ros.core.typing import Array, BoolArray, IntArray
from obs_ros.inference.assessment.power_products import power_product, sparse
from obs_ros.inference.assessment.structural import Confounded, confounded
from obs_ros.inference.objective import Objective
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.inference.prior import Prior
from obs_ros.integration.grid import usual_step


@dataclass(frozen=True)
class IdentifiabilitySettings:
    """Limits in naming what a window does not determine, and in advising on longer ones.

    - `undetermined` (boxes), `largest_share` (of the value, on a log scale): standard deviations
      above which nothing is known of a parameter;
    - `support`: share of a direction's largest entry below which a parameter does not belong to it;
    - `unseen`: standard deviations by which a change along such a product may show;
    - `smallest_value` (boxes): below, a relative change means nothing;
    - `horizon` (windows), `nodes`, `lengths`: how far ahead, in how many nodes at most and at how
      many lengths, each a fifth longer than the one before, longer windows are looked at.
    """

    undetermined: float = 0.1
    largest_share: float = 0.3
    support: float = 0.1
    unseen: float = 2.0
    smallest_value: float = 0.01
    horizon: int = 32
    nodes: int = 2048
    lengths: int = 25


LIMITS = IdentifiabilitySettings()


def undetermined(unknowns: Unknowns) -> Array:
    """Return the standard deviations (d,), in boxes, above which unknowns are not determined."""
    if not unknowns.scale.logarithmic:
        return np.full(unknowns.dimension, LIMITS.undetermined)
    with np.errstate(divide='ignore'):  # on a linear scale there is no such share
        return np.minimum(LIMITS.undetermined, LIMITS.largest_share / unknowns.scale.growth)


def undetermined_states(unknowns: Unknowns) -> Array:
    """Return the deviations (n,) of states above which they are not determined, in their units.

    Infinite where the initial state is given.
    """
    boxes = np.full(len(unknowns.model.states), np.inf)
    first = unknowns.n_states
    boxes[unknowns.index[:first]] = unknowns.scale.width[:first]
    return LIMITS.undetermined * boxes


def weak_directions(
    objective: Objective,
    values: Array,
    information: Array,
    covariance: Array,
    structural: Sequence[Confounded] = (),
) -> tuple[str, ...]:
    """Say which combinations of the estimated parameters the window does not determine.

    `structural` are those that no input tells apart, whose quantities are known. `values` (q,) are
    the parameters in boxes, `information` (q, q) that of the window about them, with the initial
    state unknown, `covariance` (q, q) their posterior one.
    """
    unknowns = objective.unknowns
    n = unknowns.n_states
    point = np.concatenate([np.full(n, 0.5), values])
    size = np.maximum(
        np.abs(unknowns.scale.values(point)) / unknowns.scale.slopes(point), LIMITS.smallest_value
    )[n:]
    # A power product means nothing where a value may change its sign.
    definite = (unknowns.scale.lower[n:] >= 0.0) | (unknowns.scale.upper[n:] <= 0.0)
    eigenvalues, vectors = eigen(information)
    weak = vectors[:, eigenvalues * LIMITS.undetermined**2 < 1.0].T
    found = []
    for relative in sparse(weak / size):
        words = _known_words(unknowns.names[n:], relative, structural) or _words(
            unknowns.names[n:], relative, definite, size, information
        )
        direction = relative * size / np.linalg.norm(relative * size)
        known = direction @ covariance @ direction < LIMITS.undetermined**2
        found.append(f'{words} (known from earlier windows)' if known else words)
    return tuple(found)


def unseparated(objective: Objective) -> tuple[Confounded, ...]:
    """Return the estimated parameters that no input tells apart in windows of this length."""
    grid = objective.grid
    return confounded(objective.kernels, objective.unknowns, float(grid.t[-1] - grid.t[0]))


def advice(
    objective: Objective,
    state: Array,
    p: Array,
    chosen: IntArray,
    structural: Sequence[Confounded] = (),
) -> str:
    """Say what would determine the parameters `chosen` (places of unknowns).

    Where no input can (`structural`), that is to fix one; else inputs, or a longer window.
    """
    names = {objective.unknowns.names[i] for i in chosen}
    hopeless = [each for each in structural if names & set(each.names)]
    lost = {name for each in hopeless for name in each.names}
    others = np.array(
        [i for i in chosen if objective.unknowns.names[i] not in lost], dtype=np.int64
    )
    parts = [str(each) for each in hopeless]
    if others.size and (longer := _longer(objective, state, p, others)):
        parts.append(longer)
    return '; '.join(parts)


def _longer(objective: Objective, state: Array, p: Array, chosen: IntArray) -> str:
    """Say how long a window must be to determine the parameters `chosen` (places of unknowns).

    The model is run ahead from `state` (n,) with parameters p (q,) and the last input held.
    """
    unknowns, grid = objective.unknowns, objective.grid
    length = float(grid.t[-1] - grid.t[0])
    jacobian = _jacobian_ahead(objective, state, p)
    if not np.isfinite(jacobian).all():
        return ''
    nodes = len(jacobian)
    ends = np.geomspace(nodes / (2 * LIMITS.horizon), nodes, LIMITS.lengths).astype(int)
    information = Prior.known(unknowns, start=True).precision
    deviations = []
    for first, last in pairwise([0, *ends]):
        part = jacobian[first:last].reshape(-1, unknowns.dimension)
        information = information + part.T @ part
        # Where an outgrown column leaves a variance below 0, nothing is known: NaN is not enough.
        with np.errstate(invalid='ignore'):
            deviations.append(np.sqrt(np.diagonal(inverted(information))[chosen]))
    names = ' and '.join(unknowns.names[i] for i in chosen)
    enough = np.flatnonzero((np.array(deviations) < LIMITS.undetermined).all(axis=1))
    if not enough.size:
        return (
            'move the inputs: while they stay as they are, no window up to '
            f'{LIMITS.horizon} times as long would determine {names}'
        )
    seconds = max(length * ends[enough[0]] * LIMITS.horizon / nodes, 2.0 * length)
    return (
        f'a window of about {float(f"{seconds:.2g}"):g} s would determine {names}, '
        'even if the inputs stay as they are; moving them may be quicker'
    )


def _jacobian_ahead(objective: Objective, state: Array, p: Array) -> Array:
    """Return the Jacobian (N, r, d) of scaled outputs over the horizon ahead, input held."""
    unknowns, grid = objective.unknowns, objective.grid
    n = len(unknowns.model.states)
    horizon = LIMITS.horizon * float(grid.t[-1] - grid.t[0])
    wanted = horizon / usual_step(unknowns.model, grid)  # steps in all
    each = max(1, math.ceil(wanted / (LIMITS.nodes - 1) - 1e-6))
    # As many nodes as these steps reach: more of them would only round each one's steps up.
    nodes = LIMITS.nodes if each == 1 else 1 + math.ceil(wanted / each - 1e-6)
    samples = objective.count(objective.nodes) / grid.y.shape[1] * LIMITS.horizon / nodes
    weight = np.tile(np.sqrt(samples) / grid.scale, (nodes, 1))
    ahead = replace(
        grid,
        t=np.linspace(0.0, horizon, nodes) + grid.t[-1],
        steps=np.full(nodes - 1, each),
        u=np.tile(grid.u[-1], (nodes, 1)),
        slope=np.zeros((nodes, grid.u.shape[1])),
        y=np.zeros_like(weight),
        weight=weight,
        measured=np.ones(nodes, dtype=bool),
        injection=None,
    )
    lanes = np.repeat(np.concatenate([state, p])[:, None], 1 + unknowns.dimension, axis=1)
    z = unknowns.scale.places(lanes[unknowns.index, 0])
    step = np.where(z > 0.5, -1e-7, 1e-7)
    lanes[unknowns.index, 1 + np.arange(unknowns.dimension)] += step * unknowns.scale.slopes(z)
    _, y = objective.kernels.trajectories(ahead, lanes[:n], lanes[n:], lanes.shape[1])
    with np.errstate(invalid='ignore'):  # the model may diverge ahead
        return np.asarray(weight[:, :, None] * (y[:, :, 1:] - y[:, :, :1]) / step)


def _known_words(names: tuple[str, ...], relative: Array, structural: Sequence[Confounded]) -> str:
    """Name a direction of relative changes (q,) that no input reveals; '' if it is none of them."""
    support = np.flatnonzero(np.abs(relative) > LIMITS.support * np.abs(relative).max())
    members = {names[i] for i in support}
    for each in structural:
        if each.quantity and members <= set(each.names):
            return f'only {each.quantity} is determined'
    return ''


def _words(
    names: tuple[str, ...],
    relative: Array,
    definite: BoolArray,
    size: Array,
    information: Array,
) -> str:
    """Name a direction of relative changes (q,) that leaves the outputs as they are.

    `size` (q,) turns them into boxes.
    """
    support = np.flatnonzero(np.abs(relative) > LIMITS.support * np.abs(relative).max())
    if support.size == 1:
        return f'{names[support[0]]} is not determined'
    if support.size == 2 and definite[support].all():
        a, b = support
        ratio = float(relative[a] / relative[b])
        if not (product := power_product(names[a], names[b], ratio)):
            part = information[np.ix_(support, support)]
            ratio = _nearest_unseen(ratio, size[support], part)
            product = power_product(names[a], names[b], ratio)
        if product:
            return f'only {product} is determined'
    share = relative[support] / np.abs(relative[support]).min()
    share *= np.sign(share[0])
    parts = ', '.join(f'{names[i]} {value:+.2g} %' for i, value in zip(support, share, strict=True))
    return f'{parts} leave the outputs unchanged'


def _nearest_unseen(ratio: float, size: Array, information: Array) -> float:
    """Return the ratio in halves beside `ratio` along which no change of a tenth of box is seen.

    Noise in the initial state turns the weakest direction a little, and an exact product with it.
    NaN if there is none, or no ratio; `size` (2,) turns relative changes into boxes, information
    is (2, 2).
    """
    seen: dict[float, float] = {}
    beside = {math.floor(2.0 * ratio), math.ceil(2.0 * ratio)} if math.isfinite(ratio) else set()
    for halves in beside - {0}:
        direction = np.array([0.5 * halves, 1.0]) * size
        direction *= LIMITS.undetermined / np.linalg.norm(direction)
        seen[0.5 * halves] = float(direction @ information @ direction)
    nearest = min(seen, key=lambda halves: seen[halves], default=math.nan)
    return nearest if seen.get(nearest, math.inf) < LIMITS.unseen**2 else math.nan
