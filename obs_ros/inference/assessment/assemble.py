"""Turn what a search found into an Estimate: values by name, the outcome, and why."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from obs_ros.core.estimate import Estimate, Jump, Outcome
from obs_ros.core.model import Model, Variable, names
from obs_ros.core.record import Record
from obs_ros.core.residual_tests import (
    Whiteness,
    independent_share,
    inflation,
    inflation_by,
    like_noise,
    too_small,
    whiteness,
)
from obs_ros.core.typing import Array, BoolArray
from obs_ros.inference.assessment.identifiability import advice, weak_directions
from obs_ros.inference.assessment.uncertainty import Deviations
from obs_ros.inference.jumps.hypothesis import Hypothesis
from obs_ros.inference.objective import Objective
from obs_ros.inference.prior import BOX_VARIANCE
from obs_ros.optimization.result import Found

AT_BOUND = 1e-9  # of the box
UNADVISED = 'take a longer window, move the inputs, or fix what is known'
MOMENT = 0.02  # of the samples, which a state may spend at its bound
NEGLIGIBLE = 1e-6  # of the signal, root mean square: rounding, not noise


@dataclass(frozen=True)
class Uncertainty:
    """What the information about a window says: its hypothesis, with a joint covariance (D, D).

    `information` (q, q) is that about the estimated parameters with the initial state unknown;
    `finished` tells whether there was time to look for jumps, `bent` whether the window is so far
    from linear that the covariance holds for single unknowns only; `correlation` is the lag-1 one
    of the noise that the covariance accounts for already. `told` (q,) says which parameters some
    window has told by itself: of the others nothing is known, whatever many windows seem to add up
    to along a bent valley.
    """

    hypothesis: Hypothesis
    covariance: Array
    information: Array
    jumps: tuple[Jump, ...] = ()
    finished: bool = True
    bent: bool = False
    correlation: float = 0.0
    told: BoolArray | None = None

    @property
    def drifting(self) -> bool:
        """Whether jumps at several times look like the steps of a ramp."""
        return len(self.hypothesis.layout.events) > 1

    @property
    def fit(self) -> 'Fit':
        """How what the hypothesis leaves compares with the noise, given or learned."""
        best = self.hypothesis
        return Fit.of(
            best.problem.objective,
            best.squares,
            best.trajectory[1],
            noise_known=True,
            correlation=self.correlation,
        )


def report(
    record: Record,
    objective: Objective,
    found: Found,
    uncertainty: Uncertainty | None,
    *,
    noise_known: bool,
    in_time: bool,
    solve_time: float,
) -> Estimate:
    """Return the estimate of a window whose search found something, before its deadline or not.

    Without `uncertainty` (None) there are no standard deviations.
    """
    model, grid = objective.unknowns.model, objective.grid
    final, states, residuals = _explained(objective, found, uncertainty)
    x0, p = objective.unknowns.values(final[None])  # no initial state ever jumps
    last = int(np.flatnonzero(grid.measured)[-1])
    squares = found.cost if uncertainty is None else uncertainty.hypothesis.squares
    correlation = 0.0 if uncertainty is None else uncertainty.correlation
    fit = Fit.of(objective, squares, residuals, noise_known=noise_known, correlation=correlation)
    outcome, message = _judge(objective, found, final, fit, in_time)
    trust = _trust(objective, found, uncertainty, fit, states[last], p[:, 0])
    if uncertainty is not None and not uncertainty.finished:
        outcome = Outcome.DEADLINE
        message = 'allow more time, or shorten the window: none was left to look for jumps'
    elif uncertainty is not None and uncertainty.drifting and found.accepted:
        outcome = Outcome.MODEL_MISMATCH
        message = (
            f'shorten the window: {len(uncertainty.jumps)} jumps in it, or a drifting parameter; '
            'standard deviations are withheld'
        )
    elif trust.lost and outcome in (Outcome.CONVERGED, Outcome.AT_BOUND):
        outcome = Outcome.NOT_IDENTIFIABLE
        parts = trust.weak or (f'{", ".join(trust.lost)} not determined',)
        message = '; '.join([trust.advice or UNADVISED, *parts])
    if resting := states_at_bound(model, states):
        outcome = Outcome.AT_BOUND if outcome is Outcome.CONVERGED else outcome
        message = f'{resting}: check the bounds, or the model; {message}'
    jumps = () if uncertainty is None else uncertainty.jumps
    residuals = residuals * grid.scale
    return Estimate(
        parameters=_named(model.parameters, p[:, 0]),
        initial_state=_named(model.states, x0[:, 0]),
        state=_named(model.states, states[last]),
        stddev={
            **_named(model.states, trust.deviations.state),
            **_named(model.parameters, trust.deviations.parameters),
        },
        initial_stddev=_named(model.states, trust.deviations.initial),
        outcome=outcome,
        message='; '.join([message, *map(str, jumps)]),
        t0=float(grid.t[0]),
        t1=float(grid.t[last]),
        cost=0.5 * squares if objective.fitness == 'least_squares' else squares,
        residual_rms=_rms(residuals),
        output_rms=_named(model.outputs, output_rms(residuals)),
        weak=trust.weak,
        advice=trust.advice,
        jumps=jumps,
        evaluations=objective.evaluations,
        solve_time=solve_time,
        times=grid.t,
        states=states,
        stamp=record.stamp,
    )


@dataclass(frozen=True)
class Fit:
    """What a fit leaves: squares in units of the noise, and how it compares with noise.

    `freedom` counts as many independent squares as would vary as much; `inflation` tells by how
    much the correlation that is left raises variances.
    """

    squares: float
    freedom: float
    colour: Whiteness
    inflation: float
    noise_known: bool
    negligible: bool

    @classmethod
    def of(
        cls,
        objective: Objective,
        squares: float,
        residuals: Array,
        *,
        noise_known: bool,
        correlation: float = 0.0,
    ) -> 'Fit':
        """Judge scaled residuals (K, r); NaN = not measured.

        Their scale is that of noise of this lag-1 correlation, enlarged to what white noise must
        have to disturb as much.
        """
        freedom = max(1, objective.count(objective.nodes) - objective.dimension)
        negligible = squares <= NEGLIGIBLE**2 * objective.signal * freedom
        share = independent_share(correlation)
        return cls(
            squares * inflation(correlation) * share,
            freedom * share,
            whiteness(residuals),
            inflation_by(residuals, correlation),
            noise_known,
            negligible,
        )

    @property
    def ratio(self) -> float:
        """Root mean square of the residual, in units of the noise."""
        return float(np.sqrt(self.squares / self.freedom))

    @property
    def too_large(self) -> bool:
        """Whether noise of the known size would hardly leave so much."""
        return self.noise_known and not like_noise(self.squares, self.freedom)

    @property
    def too_small(self) -> bool:
        """Whether noise of the known size would hardly leave so little."""
        return self.noise_known and too_small(self.squares, self.freedom)


@dataclass(frozen=True)
class Trust:
    """Standard deviations, and in words what is not determined and what would determine it.

    `lost` names the states and parameters without a standard deviation.
    """

    deviations: Deviations
    weak: tuple[str, ...] = ()
    advice: str = ''
    lost: tuple[str, ...] = ()


def _trust(
    objective: Objective,
    found: Found,
    uncertainty: Uncertainty | None,
    fit: Fit,
    state: Array,
    p: Array,
) -> Trust:
    """Say how far an estimate with end state (n,) and parameters (q,) can be trusted."""
    unknowns = objective.unknowns
    model = unknowns.model
    if (
        uncertainty is None
        or uncertainty.drifting
        or not (uncertainty.finished and found.accepted)
        or fit.too_large
    ):
        return Trust(Deviations.withheld(model))
    best, n = uncertainty.hypothesis, unknowns.n_states
    deviations = Deviations.of(best, uncertainty.covariance, fit.inflation)
    final = best.layout.final(best.point)[n:]
    posterior = uncertainty.covariance[np.ix_(final, final)]
    if uncertainty.told is not None:
        places = unknowns.index[n:][~uncertainty.told] - len(model.states)
        deviations.parameters[places] = np.nan
        posterior = posterior + np.diag(np.where(uncertainty.told, 0.0, BOX_VARIANCE))
    weak = weak_directions(objective, best.point[final], uncertainty.information, posterior)
    values = np.concatenate([deviations.state, deviations.parameters])
    estimated = [i for i in unknowns.index[n:] if np.isnan(values[i])]
    chosen = np.flatnonzero(np.isin(unknowns.index, estimated))
    return Trust(
        deviations,
        weak,
        advice(objective, state, p, chosen) if chosen.size else '',
        tuple(name for name, v in zip(names(model.variables), values, strict=True) if np.isnan(v)),
    )


def _explained(
    objective: Objective, found: Found, uncertainty: Uncertainty | None
) -> tuple[Array, Array, Array]:
    """Return unknowns at the end (d,), states (K, n) and scaled residuals (K, r)."""
    if uncertainty is None:
        return found.z, *objective.trajectory(found.z)
    best = uncertainty.hypothesis
    return best.point[best.layout.final(best.point)], *best.trajectory


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
    objective: Objective, found: Found, z: Array, fit: Fit, in_time: bool
) -> tuple[Outcome, str]:
    if not found.accepted:
        effort = 'time' if not in_time else found.effort.units
        return Outcome.DEADLINE, (
            f'allow more {effort}, or shorten the window: '
            f'best of {objective.evaluations} candidates in {found.effort}, not confirmed'
        )
    if fit.too_large:
        return Outcome.MODEL_MISMATCH, (
            'check the noise, the model and its fixed values, or shorten the window: '
            f'the residual is {fit.ratio:.3g} times the noise, given or learned'
        )
    if fit.too_small:
        return Outcome.MODEL_MISMATCH, (
            f'check the noise if it is given: the residual is only {fit.ratio:.3g} times the '
            'noise, given or learned; standard deviations are too large'
        )
    if not fit.colour.white and not fit.negligible and objective.fitness == 'least_squares':
        return Outcome.MODEL_MISMATCH, (
            'look for what the model leaves out, a parameter that moved inside the window, or '
            'coarse rounding: the residual is not white, its lag-1 correlation is '
            f'{fit.colour.correlation:.2g}'
        )
    at_bound = _at_bound(objective, z)
    if at_bound:
        return Outcome.AT_BOUND, f'check the bounds, or the model: {at_bound}; {found.accepted}'
    return Outcome.CONVERGED, found.accepted


def states_at_bound(model: Model, states: Array) -> str:
    """Say which states (K, n) lie at a bound, or beyond it, for more than a moment."""
    found = []
    for variable, path in zip(model.states, states.T, strict=True):
        unit = '' if variable.unit == '1' else f' {variable.unit}'
        reach = AT_BOUND * (variable.upper - variable.lower)
        margin = reach if np.isfinite(reach) else 0.0
        for side, bound, beyond in (
            ('lower', variable.lower, path <= variable.lower + margin),
            ('upper', variable.upper, path >= variable.upper - margin),
        ):
            if np.isfinite(bound) and np.mean(beyond) > MOMENT:
                found.append(f'{variable.name} lies at its {side} bound {bound:g}{unit}')
    return ', '.join(found)


def _at_bound(objective: Objective, z: Array) -> str:
    """Say which unknowns lie at a bound of their box, and at which."""
    unknowns = objective.unknowns
    variables = [unknowns.model.variables[i] for i in unknowns.index]
    found = []
    where = zip(unknowns.lower, unknowns.upper, z, unknowns.limits.T, strict=True)
    for variable, (low, high, zi, limit) in zip(variables, where, strict=True):
        unit = '' if variable.unit == '1' else f' {variable.unit}'
        if zi <= limit[0] + AT_BOUND:
            found.append(f'{variable.name} is at its lower bound {low:g}{unit}')
        elif zi >= limit[1] - AT_BOUND:
            found.append(f'{variable.name} is at its upper bound {high:g}{unit}')
    return ', '.join(found)


def _rms(residuals: Array) -> float:
    """Return the root mean square of residuals (K, r) that are finite; NaN where none is."""
    known = residuals[np.isfinite(residuals)]
    return float(np.sqrt(np.mean(known**2))) if known.size else np.nan


def _named(variables: Sequence[Variable], values: Array) -> Mapping[str, float]:
    return {name: float(value) for name, value in zip(names(variables), values, strict=False)}
