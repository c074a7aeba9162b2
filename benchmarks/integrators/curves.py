"""Error beside time of each method's rollout, from one step a sample on, and of other solvers."""

import importlib.util
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any, NamedTuple, get_args

import numpy as np

from benchmarks.integrators.plants import PLANTS
from benchmarks.integrators.reference import outputs
from benchmarks.integrators.run import FINE, drawn
from benchmarks.runner import cpu_seconds, repeats_for
from obs_ros import Record
from obs_ros.core.model import Method
from obs_ros.core.typing import Array
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid

LANES = 64
STEPS = tuple(2**k for k in range(0, 11))
TOLERANCES = 1e-3, 1e-5, 1e-7
LOCAL = tuple(10.0**-k for k in range(3, 11))  # tolerances of steps of each candidate's own
BUDGET = 1_000_000  # of these
MEASUREMENT = 0.02  # s of process time
EXACT = 1e-8  # error below which more steps tell nothing
OTHERS = 'Radau', 'BDF', 'LSODA'
SHOWN = 'motor, L/R .1 ms', 'van der Pol 100', 'Robertson, even', 'thermal network', 'battery'


class Point(NamedTuple):
    """Rollouts of one candidate: ns a sample, greatest error in shares of the outputs' deviation.

    `how` is the number of steps a sample, or the (relative) tolerance.
    """

    plant: str
    method: str
    how: float
    nanoseconds: float
    error: float


def points(name: str, seed: int = 0) -> Iterator[Point]:
    """Yield the points of a plant: of our methods, of scipy's, and of CasADi's where it is."""
    plant, window = PLANTS[name], drawn(PLANTS[name], PLANTS[name].model, seed)
    record, n = window.record, len(PLANTS[name].model.states)
    x0, p = window.truth[:n], window.truth[n:]
    exact = outputs(plant.model, record.t, record.u, x0, p, rtol=FINE)
    scale = exact.std(axis=0)

    def error(y: Array) -> float:
        return float(np.max(np.abs(y - exact) / scale))

    for method in get_args(Method):
        if method not in ('euler', 'discrete'):
            yield from _own(name, method, record, x0, p, error)
    for method in OTHERS:
        for rtol in TOLERANCES:
            roll = _scipy(name, record, x0, p, method, rtol)
            y = roll()
            yield Point(name, method, rtol, 1e9 * cpu_seconds(roll) / record.t.size, error(y))
    if importlib.util.find_spec('casadi') is not None:
        for rtol in TOLERANCES:
            roll = _idas(name, record, x0, p, rtol)
            y = roll()
            yield Point(name, 'IDAS', rtol, 1e9 * cpu_seconds(roll) / record.t.size, error(y))


def _scipy(
    name: str, record: Record, x0: Array, p: Array, method: str, rtol: float
) -> Callable[[], Array]:
    """Return a call of an integrator of scipy."""
    model = PLANTS[name].model
    return lambda: outputs(model, record.t, record.u, x0, p, method=method, rtol=rtol)


def _own(
    name: str, method: Method, record: Record, x0: Array, p: Array, error: Callable[[Array], float]
) -> Iterator[Point]:
    """Yield the points of a method, by steps of the grid and of the candidates' own."""
    model = replace(PLANTS[name].model, integrator=method)
    kernels = kernels_for(model)
    plain = Grid.of(model, record, np.ones(len(model.outputs)))
    states, parameters = np.tile(x0[:, None], LANES), np.tile(p[:, None], LANES)

    def point(label: str, how: float, grid: Grid) -> Point:
        def roll() -> Any:
            return kernels.squares(grid, np.array([grid.t.size]), states, parameters)

        found = error(kernels.trajectories(grid, x0[:, None], p[:, None])[1][:, :, 0])
        seconds = cpu_seconds(roll, repeats_for(roll, MEASUREMENT))
        return Point(name, label, how, 1e9 * seconds / (LANES * record.t.size), found)

    for steps in STEPS:
        yield (last := point(method, steps, replace(plain, steps=steps + 0 * plain.steps)))
        if last.error < EXACT:
            break
    for tolerance in LOCAL if kernels.own_steps else ():
        grid = replace(plain, tolerance=tolerance, budget=BUDGET)
        yield (last := point(f'{method}, own steps', tolerance, grid))
        if last.error < EXACT:
            break


def _idas(name: str, record: Record, x0: Array, p: Array, rtol: float) -> Callable[[], Array]:
    """Return a call of SUNDIALS' IDAS by CasADi, from node to node with its inputs held."""
    import casadi

    model = PLANTS[name].model
    sizes = len(model.states), len(model.inputs), len(model.parameters)
    x, u, q, h, t = (casadi.SX.sym(s, k) for s, k in zip('xuqht', (*sizes, 1, 1), strict=True))
    split = [casadi.vertsplit(v) if v.numel() else [] for v in (x, u, q)]
    rates = casadi.vertcat(*model.dynamics(t, *map(tuple, split)))
    ode = {'x': x, 'p': casadi.vertcat(u, q, h), 't': t, 'ode': h * rates}
    step = casadi.integrator('step', 'idas', ode, 0.0, 1.0, {'reltol': rtol, 'abstol': rtol * 1e-3})

    def roll() -> Array:
        now, y = x0, [model.output(0.0, tuple(x0), tuple(record.u[0]), tuple(p))]
        for k in range(record.t.size - 1):
            given = np.concatenate([record.u[k], p, [record.t[k + 1] - record.t[k]]])
            now = np.array(step(x0=now, p=given)['xf']).ravel()
            y.append(model.output(0.0, tuple(now), tuple(record.u[k + 1]), tuple(p)))
        return np.array(y)

    return roll
