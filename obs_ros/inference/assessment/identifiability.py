"""What a window cannot tell apart, in words, and which window could."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np

from obs_ros.core.linear_algebra import eigen, inverted
from obs_ros.core.typing import Array, BoolArray, IntArray
from obs_ros.inference.objective import Objective
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.inference.prior import Prior

UNDETERMINED = 0.1  # box; a standard deviation above says nothing
LARGEST_SHARE = 0.3  # of its value, of a parameter on a log scale
SUPPORT = 0.1  # of a direction's largest entry, relative changes
ROUND_RATIO = 0.05  # how near a ratio must be to a multiple of one half
MOST_HALVES = 6  # in a power product that still means something
UNSEEN = 2.0  # standard deviations, by which a change along what is called a product may show
SMALLEST_VALUE = 0.01  # box; below, a relative change means nothing
HORIZON = 32  # windows looked ahead
NODES = 2048  # over that horizon
GATES = 25  # lengths looked at, each a fifth longer than the one before


def undetermined(unknowns: Unknowns) -> Array:
    """Return the standard deviations (d,), in boxes, above which unknowns are not determined."""
    with np.errstate(divide='ignore'):  # on a linear scale there is no such share
        return np.minimum(UNDETERMINED, LARGEST_SHARE / unknowns.scale.growth)


def weak_directions(
    objective: Objective, values: Array, information: Array, covariance: Array
) -> tuple[str, ...]:
    """Say which combinations of the estimated parameters the window does not determine.

    `values` (q,) are the parameters in boxes, `information` (q, q) what the window tells of them
    with the initial state unknown, `covariance` (q, q) what is known in the end.
    """
    unknowns = objective.unknowns
    n = unknowns.n_states
    point = np.concatenate([np.full(n, 0.5), values])
    size = np.maximum(
        np.abs(unknowns.scale.values(point)) / unknowns.scale.slopes(point), SMALLEST_VALUE
    )[n:]
    # A power product means nothing where a value may change its sign.
    definite = (unknowns.scale.lower[n:] >= 0.0) | (unknowns.scale.upper[n:] <= 0.0)
    eigenvalues, vectors = eigen(information)
    weak = vectors[:, eigenvalues * UNDETERMINED**2 < 1.0].T
    found = []
    for relative in _sparse(weak / size):
        words = _words(unknowns.names[n:], relative, definite, size, information)
        direction = relative * size / np.linalg.norm(relative * size)
        known = direction @ covariance @ direction < UNDETERMINED**2
        found.append(f'{words} (known from earlier windows)' if known else words)
    return tuple(found)


def advice(objective: Objective, state: Array, p: Array, chosen: IntArray) -> str:
    """Say how long a window must be to determine the parameters `chosen` (places of unknowns).

    The model is run ahead from `state` (n,) with parameters p (q,) and the last input held.
    """
    unknowns, grid = objective.unknowns, objective.grid
    length = float(grid.t[-1] - grid.t[0])
    n_model = len(unknowns.model.states)
    t = np.linspace(0.0, HORIZON * length, NODES)
    samples = objective.count(objective.nodes) / grid.y.shape[1] * HORIZON / NODES
    weight = np.tile(np.sqrt(samples) / grid.scale, (NODES, 1))
    interval = t[1] / unknowns.model.max_step
    ahead = replace(
        grid,
        t=t + grid.t[-1],
        steps=np.full(NODES - 1, max(1, math.ceil(interval))),
        u=np.tile(grid.u[-1], (NODES, 1)),
        slope=np.zeros((NODES, grid.u.shape[1])),
        y=np.zeros_like(weight),
        weight=weight,
        measured=np.ones(NODES, dtype=bool),
    )
    lanes = np.repeat(np.concatenate([state, p])[:, None], 1 + unknowns.dimension, axis=1)
    z = unknowns.scale.places(lanes[unknowns.index, 0])
    step = np.where(z > 0.5, -1e-7, 1e-7)
    lanes[unknowns.index, 1 + np.arange(unknowns.dimension)] += step * unknowns.scale.slopes(z)
    _, y = objective.kernels.trajectories(ahead, lanes[:n_model], lanes[n_model:])
    with np.errstate(invalid='ignore'):  # the model may diverge ahead
        jacobian = weight[:, :, None] * (y[:, :, 1:] - y[:, :, :1]) / step
    if not np.isfinite(jacobian).all():
        return ''
    gates = np.geomspace(NODES / (2 * HORIZON), NODES, GATES).astype(int)
    information = Prior.box(unknowns).precision
    deviations = []
    for first, last in pairwise([0, *gates]):
        part = jacobian[first:last].reshape(-1, unknowns.dimension)
        information = information + part.T @ part
        # Where an outgrown column leaves a variance below 0, nothing is known: NaN is not enough.
        with np.errstate(invalid='ignore'):
            deviations.append(np.sqrt(np.diagonal(inverted(information))[chosen]))
    names = ' and '.join(unknowns.names[i] for i in chosen)
    enough = np.flatnonzero((np.array(deviations) < UNDETERMINED).all(axis=1))
    if not enough.size:
        return (
            'move the inputs: while they stay as they are, no window up to '
            f'{HORIZON} times as long would determine {names}'
        )
    seconds = max(length * gates[enough[0]] * HORIZON / NODES, 2.0 * length)
    return (
        f'a window of about {float(f"{seconds:.2g}"):g} s would determine {names}, '
        'even if the inputs stay as they are; moving them may be quicker'
    )


def _sparse(directions: Array) -> Array:
    """Return other directions (k, q) that span the same space, each with k - 1 zeros at least."""
    rows = directions.copy()
    pivots: list[int] = []
    for k in range(len(rows)):
        free = np.abs(rows[k])
        free[pivots] = 0.0
        pivot = int(free.argmax())
        rows[k] /= rows[k, pivot]
        for other in range(len(rows)):
            if other != k:
                rows[other] -= rows[other, pivot] * rows[k]
        pivots.append(pivot)
    return rows


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
    support = np.flatnonzero(np.abs(relative) > SUPPORT * np.abs(relative).max())
    if support.size == 1:
        return f'{names[support[0]]} is not determined'
    if support.size == 2 and definite[support].all():
        a, b = support
        ratio = float(relative[a] / relative[b])
        if not (product := _product(names[a], names[b], ratio)):
            part = information[np.ix_(support, support)]
            ratio = _nearest_unseen(ratio, size[support], part)
            product = _product(names[a], names[b], ratio)
        if product:
            return f'only {product} is determined'
    share = relative[support] / np.abs(relative[support]).min()
    share *= np.sign(share[0])
    parts = ', '.join(f'{names[i]} {value:+.2g} %' for i, value in zip(support, share, strict=True))
    return f'{parts} leave the outputs unchanged'


def _nearest_unseen(ratio: float, size: Array, information: Array) -> float:
    """Return the ratio in halves beside `ratio` along which no change of a tenth of box is seen.

    Noise in the initial state turns the weakest direction a little, and an exact product with it.
    NaN if there is none; `size` (2,) turns relative changes into boxes, information is (2, 2).
    """
    seen = {}
    for halves in {math.floor(2.0 * ratio), math.ceil(2.0 * ratio)} - {0}:
        direction = np.array([0.5 * halves, 1.0]) * size
        direction *= UNDETERMINED / np.linalg.norm(direction)
        seen[0.5 * halves] = float(direction @ information @ direction)
    nearest = min(seen, key=lambda halves: seen[halves], default=math.nan)
    return nearest if seen.get(nearest, math.inf) < UNSEEN**2 else math.nan


def _product(a: str, b: str, ratio: float) -> str:
    """Return the power product that does not change when a changes `ratio` times as much as b."""
    if math.isnan(ratio):
        return ''
    halves = round(2.0 * ratio)
    if abs(halves) > MOST_HALVES:
        return ''
    if halves == 0:  # the other way round
        return _product(b, a, 1.0 / ratio) if abs(ratio) > ROUND_RATIO else ''
    if abs(2.0 * ratio - halves) > 2.0 * ROUND_RATIO * max(1.0, abs(ratio)):
        return ''
    # d ln a = ratio * d ln b, so a / b^ratio stays.
    over, under = (1, abs(halves) // 2) if halves % 2 == 0 else (2, abs(halves))
    first = a if over == 1 else f'{a}^{over}'
    second = b if under == 1 else f'{b}^{under}'
    return f'{first}/{second}' if halves > 0 else f'{first}*{second}'
