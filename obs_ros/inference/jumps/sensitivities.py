"""How outputs move with a parameter that jumps at a node, for all nodes, by one pass backward.

With one-step sensitivities A_k = d z_{k+1} / d z_k of the state with the parameters that may jump,
z = (x, v), and C_k = d y_k / d z_k of the scaled outputs, a jump at node k by d has the shape

    s_i = C_i A_{i-1} ... A_k e d   at nodes i >= k,

e the unit vector of the parameter in z. Its products with itself and with any columns c_i are

    s's = e' G_k e with G_k = C_k' C_k + A_k' G_{k+1} A_k,
    s'c = e' W_k   with W_k = C_k' c_k + A_k' W_{k+1}.

Where measurements correct the state, x and y are as predicted, and A_k includes the correction.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from obs_ros.core.jit import accelerated
from obs_ros.core.typing import Array
from obs_ros.inference.jumps.hypothesis import Hypothesis
from obs_ros.integration.backends import Kernels, tiny_window
from obs_ros.integration.delayed import DelayedKernels
from obs_ros.integration.filter_pass import sizes
from obs_ros.integration.grid import Grid

STATE_STEP = 1e-7  # of a state's largest size in the window, for the differences


class Products(NamedTuple):
    """Products of the shapes of jumps at all nodes: s's (K, J), and s'c (K, J, D) with columns."""

    squares: Array
    columns: Array


class OneStep(NamedTuple):
    """One-step sensitivities: A (K - 1, n, m) of the states, and C (K, r, m) of scaled outputs.

    `update` (K, m, m) is that of the corrected z by the predicted one; empty without corrections.
    """

    transition: Array
    output: Array
    update: Array


def products(base: Hypothesis, parameters: Sequence[int], columns: Array) -> Products:
    """Return the products of jumps of parameters (J,) with columns (K, r, D), 0 if not measured.

    Sizes of jumps are in boxes.
    """
    return Products(*_pulled_back(*one_step(base, parameters), columns))


def one_step(base: Hypothesis, parameters: Sequence[int]) -> OneStep:
    """Return the sensitivities along a hypothesis, of parameters (J,) in boxes.

    They are forward differences, of parameters towards the middle of the box.
    """
    problem = base.problem
    objective, unknowns = problem.objective, problem.objective.unknowns
    grid, model = objective.grid, unknowns.model
    n, step = len(model.states), problem.settings.probe_step
    states = base.trajectory[0]
    largest = np.nan_to_num(np.abs(states).max(axis=0), nan=0.0, posinf=0.0)
    taken = np.empty(n + len(parameters))
    taken[:n] = STATE_STEP * np.maximum(largest, sizes(model)[0, :n])
    sets, along, there = problem.schedule(base.point)
    lanes = np.repeat(sets[:, :, None], 1 + len(parameters), axis=2)
    first, places = unknowns.n_states, np.array(parameters)
    rows, columns = unknowns.index[first:] - n, 1 + np.arange(places.size)
    z = unknowns.scale.places_of(sets[:, rows], first)
    around = np.where(z[0] > 0.5, -step, step)
    values = unknowns.scale.values(z + around, slice(first, None))
    taken[n:] = around[places - first]
    lanes[:, rows[places - first], columns] = values[:, places - first]

    objective.counter.candidates += 1 + taken.size
    transition, sensitivity = objective.kernels.one_step(
        grid, (_predicted(base), states), taken[:n], lanes, along, there
    )
    for each in (transition, sensitivity):
        each /= taken
        if not np.isfinite(each).all():  # the model may diverge
            np.nan_to_num(each, copy=False, nan=0.0, posinf=0.0, neginf=0.0)
    return OneStep(transition, *_corrected(grid, sensitivity, n))


def _predicted(base: Hypothesis) -> Array:
    """Return the states (K, n) of a hypothesis before measurements correct them."""
    grid = base.problem.objective.grid
    states, outputs = base.linearisation.path
    if grid.injection is None:
        return states
    innovations = np.where(grid.weight > 0.0, grid.y - outputs, 0.0)
    gain = grid.injection.gain[:, :, : states.shape[1]]
    return np.asarray(states - (innovations[:, None] @ gain)[:, 0])


def _corrected(grid: Grid, sensitivity: Array, n: int) -> tuple[Array, Array]:
    """Return the sensitivities of scaled outputs, and of the z that measurements correct."""
    injection, m = grid.injection, sensitivity.shape[2]
    if injection is None:
        return sensitivity * grid.weight[:, :, None], np.empty((0, m, m))
    for i in range(sensitivity.shape[1]):
        for j in range(i):
            sensitivity[:, i] -= injection.cross[:, i, j, None] * sensitivity[:, j]
    update = np.repeat(np.eye(m)[None], len(sensitivity), axis=0)
    update[:, :n] -= injection.gain[:, :, :n].transpose(0, 2, 1) @ sensitivity
    return sensitivity * grid.weight[:, :, None], update


def jumps_rehearsed(kernels: Kernels) -> Iterator[None]:
    """Run once, which compiles it, what screening needs."""
    if not isinstance(kernels, DelayedKernels):
        grid, x0, p = tiny_window(kernels.model)
        always, sets = np.zeros(2, dtype=np.int64), p[None]
        x = np.repeat(x0.T, 2, axis=0)
        step = kernels.one_step(grid, (x, x), x0[:, 0], sets, always, always)
        yield
        _pulled_back(*step, np.empty((0, len(x0), len(x0))), np.zeros((*grid.y.shape, 1)))
        yield


@accelerated
def led(transition: Array, update: Array, step: Array) -> None:
    """Write the derivatives (n, m) of the next states by z before a node's measurements, if any."""
    n, m = step.shape
    for i in range(n):
        for j in range(m):
            step[i, j] = transition[i, j]
    if len(update) > 0:
        for i in range(n):
            for j in range(m):
                total = transition[i, j] if j >= n else 0.0
                for h in range(n):
                    total += transition[i, h] * update[0, h, j]
                step[i, j] = total


@accelerated
def _pulled_back(
    transition: Array, output: Array, update: Array, columns: Array
) -> tuple[Array, Array]:
    """Return `Products` of all parameters, the last ones of z."""
    nodes, outputs, m = output.shape
    n, width = transition.shape[1], columns.shape[2]
    count = m - n
    squares, crossed = np.zeros((nodes, count)), np.zeros((nodes, count, width))
    gram, after = np.zeros((m, m)), np.zeros((m, m))
    pulled, pulled_after = np.zeros((m, width)), np.zeros((m, width))
    step, product = np.zeros((n, m)), np.zeros((m, m))
    for k in range(nodes - 1, -1, -1):
        if k < nodes - 1:  # of the step to the next node the states alone change: others stay
            led(transition[k], update[k : k + 1], step)
            for i in range(m):
                for j in range(m):
                    total = gram[i, j] if j >= n else 0.0
                    for h in range(n):
                        total += gram[i, h] * step[h, j]
                    product[i, j] = total
            for i in range(m):
                for j in range(i + 1):
                    total = product[i, j] if i >= n else 0.0
                    for h in range(n):
                        total += step[h, i] * product[h, j]
                    after[i, j] = total
                    after[j, i] = total
                for j in range(width):
                    total = pulled[i, j] if i >= n else 0.0
                    for h in range(n):
                        total += step[h, i] * pulled[h, j]
                    pulled_after[i, j] = total
            gram, after = after, gram
            pulled, pulled_after = pulled_after, pulled
        for o in range(outputs):
            for i in range(m):
                c = output[k, o, i]
                if c != 0.0:
                    for j in range(m):
                        gram[i, j] += c * output[k, o, j]
                    for j in range(width):
                        pulled[i, j] += c * columns[k, o, j]
        for i in range(count):
            squares[k, i] = gram[n + i, n + i]
            for j in range(width):
                crossed[k, i, j] = pulled[n + i, j]
    return squares, crossed
