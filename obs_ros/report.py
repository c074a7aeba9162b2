"""Turn what a search found into an Estimate: values by name, the outcome, and why."""

from collections.abc import Mapping, Sequence

import numpy as np

from obs_ros.estimate import Estimate, Outcome
from obs_ros.model import Model, Variable, names
from obs_ros.objective import Objective
from obs_ros.record import Record
from obs_ros.search.memetic import like_noise
from obs_ros.search.result import Found
from obs_ros.typing import Array

AT_BOUND = 1e-9  # of the box


def report(
    record: Record,
    objective: Objective,
    found: Found,
    *,
    noise_known: bool,
    in_time: bool,
    solve_time: float,
) -> Estimate:
    """Return the estimate of a window whose search found something, before its deadline or not."""
    model, grid = objective.unknowns.model, objective.grid
    x0, p = objective.unknowns.values(found.z[None])
    states, residuals = objective.trajectory(found.z)
    residuals = residuals * grid.scale
    last = int(np.flatnonzero(grid.measured)[-1])
    outcome, message = _judge(objective, found, noise_known, in_time)
    return Estimate(
        parameters=_named(model.parameters, p[:, 0]),
        initial_state=_named(model.states, x0[:, 0]),
        state=_named(model.states, states[last]),
        stddev=_named(model.unknowns, np.full(len(model.unknowns), np.nan)),
        outcome=outcome,
        message=message,
        t0=float(grid.t[0]),
        t1=float(grid.t[last]),
        cost=0.5 * found.cost if objective.fitness == 'least_squares' else found.cost,
        residual_rms=float(np.sqrt(np.nanmean(residuals**2))),
        output_rms=_named(model.outputs, output_rms(residuals)),
        evaluations=objective.evaluations,
        solve_time=solve_time,
        times=grid.t,
        states=states,
        stamp=record.stamp,
    )


def empty(model: Model, record: Record, outcome: Outcome, message: str) -> Estimate:
    """Return the estimate of a window that gave none: every value is NaN."""
    nothing = np.full(len(model.unknowns), np.nan)
    measured = record.t[np.isfinite(record.y).any(axis=1)]
    return Estimate(
        parameters=_named(model.parameters, nothing),
        initial_state=_named(model.states, nothing),
        state=_named(model.states, nothing),
        stddev=_named(model.unknowns, nothing),
        outcome=outcome,
        message=message,
        t0=float(record.t[0]),
        t1=float(measured[-1]),
        output_rms=_named(model.outputs, np.full(len(model.outputs), np.nan)),
        stamp=record.stamp,
    )


def output_rms(residuals: Array) -> Array:
    """Return the root mean square (r,) of residuals (K, r); NaN = not measured, 0 if all are."""
    count = np.maximum(1, np.isfinite(residuals).sum(axis=0))
    return np.asarray(np.sqrt(np.nansum(residuals**2, axis=0) / count))


def _judge(
    objective: Objective, found: Found, noise_known: bool, in_time: bool
) -> tuple[Outcome, str]:
    if not found.accepted:
        effort = 'time' if not in_time else found.effort.split()[1].removesuffix('s') + 's'
        return Outcome.DEADLINE, (
            f'best of {objective.evaluations} candidates in {found.effort}, not confirmed: '
            f'allow more {effort}, or shorten the window'
        )
    freedom = objective.count(objective.nodes) - objective.dimension
    if noise_known and not like_noise(found.cost, freedom):
        excess = np.sqrt(found.cost / max(1, freedom))
        return Outcome.MODEL_MISMATCH, (
            f'the residual is {excess:.3g} times the given noise ({found.accepted}): '
            'check the noise, the model and its fixed values, or shorten the window'
        )
    if found.white is False:
        return Outcome.MODEL_MISMATCH, (
            f'the residual is not white ({found.accepted}): the model leaves something out, a '
            'parameter moved inside the window, or the measurement is coarsely rounded'
        )
    at_bound = _at_bound(objective, found.z)
    if at_bound:
        return Outcome.AT_BOUND, f'{found.accepted}; {at_bound}: check the bounds, or the model'
    return Outcome.CONVERGED, found.accepted


def _at_bound(objective: Objective, z: Array) -> str:
    """Say which unknowns lie at a bound of their box, and at which."""
    unknowns = objective.unknowns
    variables = [unknowns.model.unknowns[i] for i in unknowns.index]
    found = []
    where = zip(unknowns.lower, unknowns.upper, z, unknowns.walls.T, strict=True)
    for variable, (low, high, zi, wall) in zip(variables, where, strict=True):
        unit = '' if variable.unit == '1' else f' {variable.unit}'
        if zi <= wall[0] + AT_BOUND:
            found.append(f'{variable.name} is at its lower bound {low:g}{unit}')
        elif zi >= wall[1] - AT_BOUND:
            found.append(f'{variable.name} is at its upper bound {high:g}{unit}')
    return ', '.join(found)


def _named(variables: Sequence[Variable], values: Array) -> Mapping[str, float]:
    return {name: float(value) for name, value in zip(names(variables), values, strict=False)}
