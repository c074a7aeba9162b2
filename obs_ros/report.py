"""Turn what a search found into an Estimate: values by name, the outcome, and why."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from obs_ros.estimate import Estimate, Jump, Outcome
from obs_ros.identifiability import advice, weak_directions
from obs_ros.information import Deviations, inflation_by
from obs_ros.mismatch import Whiteness, like_noise, too_small, whiteness
from obs_ros.model import Model, Variable, names
from obs_ros.objective import Objective
from obs_ros.record import Record
from obs_ros.search.result import Found
from obs_ros.sequence.race import Hypothesis
from obs_ros.typing import Array

AT_BOUND = 1e-9  # of the box
NEGLIGIBLE = 1e-6  # of the signal, root mean square: rounding, not noise


@dataclass(frozen=True)
class Certainty:
    """What the information about a window says: its hypothesis, with a joint covariance (D, D).

    `information` (q, q) is that about the estimated parameters with the initial state unknown;
    `finished` tells whether there was time to look for jumps.
    """

    hypothesis: Hypothesis
    covariance: Array
    information: Array
    jumps: tuple[Jump, ...] = ()
    finished: bool = True


def report(
    record: Record,
    objective: Objective,
    found: Found,
    certainty: Certainty | None,
    *,
    noise_known: bool,
    in_time: bool,
    solve_time: float,
) -> Estimate:
    """Return the estimate of a window whose search found something, before its deadline or not.

    Without `certainty` (None) there are no standard deviations.
    """
    unknowns, grid = objective.unknowns, objective.grid
    model = unknowns.model
    if certainty is None:
        final = found.z
        x0, p = (values[:, 0] for values in unknowns.values(found.z[None]))
        states, residuals = objective.trajectory(found.z)
    else:
        best = certainty.hypothesis
        point = best.point
        x0 = unknowns.values(point[None, : unknowns.dimension])[0][:, 0]
        final = point[best.layout.final(point)]
        p = unknowns.values(final[None])[1][:, 0]
        states, residuals = best.regimes.trajectory(point)
    last = int(np.flatnonzero(grid.measured)[-1])
    colour = whiteness(residuals)
    squares = found.cost if certainty is None else certainty.hypothesis.squares
    freedom = objective.count(objective.nodes) - objective.dimension
    negligible = squares <= NEGLIGIBLE**2 * objective.signal * max(freedom, 1)
    outcome, message = _judge(
        objective, found, final, squares, colour, negligible, noise_known, in_time
    )
    deviations, hint = Deviations.withheld(model), ''
    weak: tuple[str, ...] = ()
    jumps: tuple[Jump, ...] = ()
    if certainty is not None:
        jumps = certainty.jumps
        misfit = noise_known and not like_noise(squares, freedom)
        if certainty.finished and found.accepted and not misfit:
            deviations = Deviations.of(
                certainty.hypothesis, certainty.covariance, inflation_by(colour)
            )
            n = unknowns.n_states
            posterior = certainty.covariance[np.ix_(*[best.layout.final(point)[n:]] * 2)]
            weak = weak_directions(objective, final[n:], certainty.information, posterior)
            undetermined = np.array([
                i for i in range(n, unknowns.dimension)
                if np.isnan(deviations.parameters[unknowns.index[i] - len(model.states)])
            ], dtype=np.int64)  # fmt: skip
            if undetermined.size:
                hint = advice(objective, states[last], p, undetermined)
            if outcome in (Outcome.CONVERGED, Outcome.AT_BOUND):
                outcome, message = _identified(model, deviations, weak, hint, outcome, message)
        elif not certainty.finished:
            outcome = Outcome.DEADLINE
            message = 'no time was left to look for jumps: allow more time, or shorten the window'
        for jump in jumps:
            message = f'{message}; {jump}'
    residuals = residuals * grid.scale
    return Estimate(
        parameters=_named(model.parameters, p),
        initial_state=_named(model.states, x0),
        state=_named(model.states, states[last]),
        stddev={
            **_named(model.states, deviations.state),
            **_named(model.parameters, deviations.parameters),
        },
        initial_stddev=_named(model.states, deviations.initial),
        outcome=outcome,
        message=message,
        t0=float(grid.t[0]),
        t1=float(grid.t[last]),
        cost=0.5 * squares if objective.fitness == 'least_squares' else squares,
        residual_rms=float(np.sqrt(np.nanmean(residuals**2))),
        output_rms=_named(model.outputs, output_rms(residuals)),
        weak=weak,
        advice=hint,
        jumps=jumps,
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
        initial_stddev=_named(model.states, nothing),
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
    objective: Objective,
    found: Found,
    z: Array,
    squares: float,
    colour: Whiteness,
    negligible: bool,
    noise_known: bool,
    in_time: bool,
) -> tuple[Outcome, str]:
    if not found.accepted:
        effort = 'time' if not in_time else found.effort.split()[1].removesuffix('s') + 's'
        return Outcome.DEADLINE, (
            f'best of {objective.evaluations} candidates in {found.effort}, not confirmed: '
            f'allow more {effort}, or shorten the window'
        )
    freedom = objective.count(objective.nodes) - objective.dimension
    ratio = np.sqrt(squares / max(1, freedom))
    if noise_known and not like_noise(squares, freedom):
        return Outcome.MODEL_MISMATCH, (
            f'the residual is {ratio:.3g} times the noise ({found.accepted}): '
            'check the noise, the model and its fixed values, or shorten the window'
        )
    if noise_known and too_small(squares, freedom):
        return Outcome.MODEL_MISMATCH, (
            f'the residual is only {ratio:.3g} times the noise: check the noise that is given; '
            'with it too large, standard deviations are too large'
        )
    if not colour.white and not negligible and objective.fitness == 'least_squares':
        return Outcome.MODEL_MISMATCH, (
            f'the residual is not white, its lag-1 correlation is {colour.correlation:.2g} '
            f'({found.accepted}): the model leaves something out, a parameter moved inside the '
            'window, or the measurement is coarsely rounded'
        )
    at_bound = _at_bound(objective, z)
    if at_bound:
        return Outcome.AT_BOUND, f'{found.accepted}; {at_bound}: check the bounds, or the model'
    return Outcome.CONVERGED, found.accepted


def _identified(
    model: Model,
    deviations: Deviations,
    weak: tuple[str, ...],
    hint: str,
    outcome: Outcome,
    message: str,
) -> tuple[Outcome, str]:
    """Return another outcome and message where something is not determined."""
    lost = [
        variable.name
        for variables, values in (
            (model.states, deviations.state),
            (model.parameters, deviations.parameters),
        )
        for variable, value in zip(variables, values, strict=True)
        if np.isnan(value)
    ]
    if not lost:
        return outcome, message
    parts = [*weak] or [f'{", ".join(lost)} not determined']
    if hint:
        parts.append(hint)
    return Outcome.NOT_IDENTIFIABLE, '; '.join(parts)


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
