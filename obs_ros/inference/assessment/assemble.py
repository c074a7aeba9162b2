"""The Estimate of a window: its values by name, its standard deviations, its outcome and why."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from obs_ros.core.changes import replace
from obs_ros.core.estimate import UNKNOWN, Estimate, Outcome
from obs_ros.core.model import Model, Variable, names
from obs_ros.core.periods import periods, within
from obs_ros.core.record import Record
from obs_ros.core.typing import Array
from obs_ros.inference.assessment.contradiction import contradictions
from obs_ros.inference.assessment.deviations import Deviations
from obs_ros.inference.assessment.fit import Fit, root_mean_square
from obs_ros.inference.assessment.identifiability import advice, unseparated, weak_directions
from obs_ros.inference.assessment.outcome import (
    Findings,
    at_bound,
    is_told,
    judged,
    states_at_bound,
    unknowns_at_bound,
)
from obs_ros.inference.assessment.uncertainty import Uncertainty
from obs_ros.inference.objective import Objective
from obs_ros.inference.outlier_count import newest, words
from obs_ros.inference.parameterisation import BOX_VARIANCE
from obs_ros.inference.window_state import WindowState
from obs_ros.optimization.result import Found

UNADVISED = 'take a longer window, move the inputs, or fix what is known'


def report(
    window: WindowState,
    found: Found,
    uncertainty: Uncertainty | None,
    *,
    in_time: bool,
    solve_time: float,
) -> Estimate:
    """Return the estimate of a window whose search found something, before its deadline or not.

    Without `uncertainty` (None) there are no standard deviations. The function is as long as an
    Estimate and its Findings have fields.
    """
    objective, unknowns = window.objective, window.objective.unknowns
    model, grid = unknowns.model, objective.grid
    squares, final, states, residuals = _optimum(objective, found, uncertainty)
    x0, p = unknowns.values(final[None])  # no initial state ever jumps
    end = None if uncertainty is None else uncertainty.end
    if end is not None and end.parameters is not None:
        p = end.parameters[:, None]
    path = states if end is None or end.path is None else end.path
    last = int(np.flatnonzero(grid.measured)[-1])
    period = periods(model.states)
    shown = within(states[last], period)
    turns = shown - states[last]  # whole periods
    if uncertainty is None:
        fit = Fit.of(objective, squares, residuals, noise_known=window.noise_known)
    else:
        fit = replace(uncertainty.fit, noise_known=window.noise_known)
    fit = replace(fit, trimmed=bool(window.outliers))
    known = _knowledge(objective, found, uncertainty, fit, states[last], p[:, 0])
    bounded = at_bound(unknowns, final)
    outcome, message = judged(
        Findings(
            found=found,
            fit=fit,
            uncertainty=uncertainty,
            candidates=objective.evaluations,
            in_time=in_time,
            squares=objective.is_least_squares,
            # Of what lies at a bound, that is what is to be said.
            undetermined=tuple(name for name in known.undetermined if name not in bounded),
            unidentified=known.said,
            bounds=unknowns_at_bound(unknowns, final),
            resting=states_at_bound(model, states),
            contradicted=_contradicted(uncertainty, found, fit),
        )
    )
    jumps = () if uncertainty is None else uncertainty.jumps
    walking = None if uncertainty is None else uncertainty.process_noise
    residuals = grid.unscaled(residuals)
    state, parameters = _named(model.states, shown), _named(model.parameters, p[:, 0])
    stddev = {
        **_named(model.states, known.deviations.state),
        **_named(model.parameters, known.deviations.parameters),
    }
    return Estimate(
        parameters=parameters,
        initial_state=_named(model.states, within(x0[:, 0], period)),
        state=state,
        stddev=stddev,
        interval=_intervals(model, known.deviations, turns),
        initial_stddev=_named(model.states, known.deviations.initial),
        covariance=known.deviations.joint,
        noise={} if uncertainty is None else _named(model.outputs, uncertainty.noise),
        walks={} if walking is None else _named(model.variables, walking.walks),
        outcome=outcome,
        message='; '.join(
            [message, *map(str, jumps), *words(window.outliers, names(model.outputs))]
        ),
        t0=float(grid.t[0]),
        t1=float(grid.t[last]),
        cost=0.5 * squares if objective.is_least_squares else squares,
        residual_rms=_rms(residuals),
        output_rms=_named(model.outputs, root_mean_square(residuals)),
        weak=known.weak,
        advice=known.advice,
        jumps=jumps,
        last_outlier=newest(window.outliers, names(model.outputs)),
        drifting=() if uncertainty is None else uncertainty.walking,
        evaluations=objective.evaluations,
        solve_time=solve_time,
        times=grid.t,
        states=path + turns if period.any() else path,
        stamp=window.record.stamp,
    )


def _optimum(
    objective: Objective, found: Found, uncertainty: Uncertainty | None
) -> tuple[float, Array, Array, Array]:
    """Return squares, unknowns at the end (d,), states (K, n) and scaled residuals (K, r)."""
    if uncertainty is None:
        return found.cost, found.z, *objective.trajectory(found.z)
    best = uncertainty.hypothesis
    return best.squares, best.point[best.final], *best.trajectory


def _intervals(
    model: Model, deviations: Deviations, turns: Array
) -> Mapping[str, tuple[float, float]]:
    """Return the intervals by name, those of states (n,) so many whole periods away."""
    moved = np.append(turns, np.zeros(len(model.parameters))).tolist()
    found = {}
    for i, (variable, off) in enumerate(zip(model.variables, moved, strict=True)):
        low, high = deviations.interval(i)
        found[variable.name] = (low + off, high + off) if off else (low, high)
    return found


def empty(model: Model, record: Record, outcome: Outcome, message: str) -> Estimate:
    """Return the estimate of a window that gave none: every value is NaN."""
    nothing = np.full(len(model.variables), np.nan)
    measured = record.t[np.isfinite(record.y).any(axis=1)]
    return Estimate(
        parameters=_named(model.parameters, nothing),
        initial_state=_named(model.states, nothing),
        state=_named(model.states, nothing),
        stddev=_named(model.variables, nothing),
        initial_stddev=_named(model.states, nothing),
        interval=dict.fromkeys(names(model.variables), UNKNOWN),
        outcome=outcome,
        message=message,
        t0=float(record.t[0]),
        t1=float(measured[-1]),
        output_rms=_named(model.outputs, np.full(len(model.outputs), np.nan)),
        stamp=record.stamp,
    )


@dataclass(frozen=True)
class Knowledge:
    """Standard deviations; `weak` combinations and `advice` on them, in words.

    `undetermined` names the states and parameters without a standard deviation.
    """

    deviations: Deviations
    weak: tuple[str, ...] = ()
    advice: str = ''
    undetermined: tuple[str, ...] = ()

    @property
    def said(self) -> str:
        """Advice first, then what is not determined."""
        parts = self.weak or (f'{", ".join(self.undetermined)} not determined',)
        return '; '.join([self.advice or UNADVISED, *parts])


def _knowledge(
    objective: Objective,
    found: Found,
    uncertainty: Uncertainty | None,
    fit: Fit,
    state: Array,
    p: Array,
) -> Knowledge:
    """Return how well an estimate with end state (n,) and parameters (q,) is known.

    Standard deviations are withheld where the model is not confirmed.
    """
    unknowns = objective.unknowns
    model = unknowns.model
    if uncertainty is None or not is_told(uncertainty, found, fit):
        return Knowledge(Deviations.withheld(model))
    best, n = uncertainty.hypothesis, unknowns.n_states
    deviations = Deviations.of(
        best, uncertainty.covariance, fit.enlargement, uncertainty.end, uncertainty.interval
    )
    if uncertainty.excess is not None:
        deviations = deviations.beside(best, fit.enlargement * uncertainty.excess)
    if (structure := uncertainty.structure) is not None:  # a mean over the window is no value
        deviations.parameters[unknowns.index[n:][structure.moving] - len(model.states)] = np.nan
    if uncertainty.process_noise is None and uncertainty.skill is not None and not fit.white:
        # What the model leaves out is in the state, which nothing corrects.
        deviations = deviations.without_state
    final = best.final_parameters
    covariance = uncertainty.covariance[np.ix_(final, final)]
    if (alone := uncertainty.determined_alone) is not None:
        deviations.parameters[unknowns.index[n:][~alone] - len(model.states)] = np.nan
        covariance = covariance + np.diag(np.where(alone, 0.0, BOX_VARIANCE))
    lost = any(np.isnan(deviations.parameters[unknowns.index[n:] - len(model.states)]))
    structural = unseparated(objective) if lost else ()
    weak = weak_directions(
        objective, best.point[final], uncertainty.information, covariance, structural
    )
    values = np.concatenate([deviations.state, deviations.parameters])
    estimated = [i for i in unknowns.index[n:] if np.isnan(values[i])]
    chosen = np.flatnonzero(np.isin(unknowns.index, estimated))
    hopeless = {name for each in structural for name in each.names}
    told = np.array([i for i in chosen if unknowns.names[i] in hopeless], dtype=np.int64)
    return Knowledge(
        deviations,
        weak,
        # A model that is only roughly right foretells no longer window.
        advice(objective, state, p, chosen if fit.is_noise else told, structural),
        tuple(np.array(names(model.variables))[np.isnan(values)].tolist()),
    )


def _contradicted(uncertainty: Uncertainty | None, found: Found, fit: Fit) -> str:
    """Say which given priors are contradicted; nothing of a point that is not believed."""
    if uncertainty is None or not found.accepted:
        return ''
    best = uncertainty.hypothesis
    wrong = contradictions(best, fit.inflation)
    return ', '.join(each.words(best.problem.objective.unknowns) for each in wrong)


def _named(variables: Sequence[Variable], values: Array) -> Mapping[str, float]:
    return {name: float(value) for name, value in zip(names(variables), values, strict=False)}


def _rms(residuals: Array) -> float:
    """Return the root mean square of residuals (K, r) that are finite; NaN where none is."""
    known = residuals[np.isfinite(residuals)]
    return float(np.sqrt(np.mean(known**2))) if known.size else np.nan
