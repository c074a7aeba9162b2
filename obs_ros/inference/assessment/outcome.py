"""The outcome of a window: an ordered table of findings, each with its outcome and its remedy."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from obs_ros.core.estimate import Outcome
from obs_ros.core.model import Model, Variable
from obs_ros.core.periods import lasting_bounds
from obs_ros.core.typing import Array
from obs_ros.inference.assessment.fit import Fit
from obs_ros.inference.assessment.skill import SKILL
from obs_ros.inference.assessment.uncertainty import Uncertainty
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.optimization.result import Found

AT_BOUND = 1e-9  # of the box: nearer to a bound is rounding
MOMENT = 0.02  # of the samples, which a state may spend at its bound


@dataclass(frozen=True)
class Findings:
    """All that the outcome of a window depends on.

    `undetermined` names the values without a standard deviation, `unidentified` says so in words
    and with advice; `bounds` says which unknowns are at a bound, `resting` which states for long,
    `contradicted` which given priors the window contradicts.
    """

    found: Found
    fit: Fit
    uncertainty: Uncertainty | None
    candidates: int
    in_time: bool
    squares: bool
    undetermined: tuple[str, ...]
    unidentified: str
    bounds: str
    resting: str
    contradicted: str = ''

    @property
    def searched(self) -> bool:
        """Whether there was time to look for jumps."""
        return self.uncertainty is None or self.uncertainty.finished

    @property
    def drifting(self) -> bool:
        """Whether jumps at several times look like a ramp."""
        return self.uncertainty is not None and self.uncertainty.drifting

    @property
    def disturbance(self) -> str:
        """Words on the process noise that explains the window, if any."""
        return '' if self.uncertainty is None else self.uncertainty.disturbance

    @property
    def skill(self) -> float | None:
        """Skill of the model's forecasts, where noise alone does not explain the window."""
        return None if self.uncertainty is None else self.uncertainty.skill

    @property
    def unskilled(self) -> bool:
        """Whether forecasts were compared and did not beat holding the last value."""
        return self.skill is not None and not self.skill > 0.0

    @property
    def useful(self) -> bool:
        """Whether forecasts were compared and show that the model is roughly right."""
        return is_useful(self.fit, self.skill)

    @property
    def misfit(self) -> str:
        """Words on a residual that is no noise, '' if it is."""
        fit = self.fit
        if fit.too_large or fit.too_small:
            only = 'only ' if fit.too_small else ''
            return f'the residual is {only}{fit.ratio:.3g} times the noise, given or learned'
        if self.squares and not fit.white and not fit.negligible:
            return (
                f'the residual is not white, its lag-1 correlation is {fit.colour.correlation:.2g}'
            )
        return ''

    @property
    def flaws(self) -> str:
        """Words on what speaks against the model's structure."""
        return '' if self.uncertainty is None else self.uncertainty.flaws

    @property
    def jumps(self) -> int:
        """Number of jumps."""
        return 0 if self.uncertainty is None else len(self.uncertainty.jumps)


class Rule(NamedTuple):
    """A finding, the outcome that it makes, and its message, remedy first."""

    applies: Callable[[Findings], bool]
    outcome: Outcome
    message: Callable[[Findings], str]


# The first rule that applies decides.
RULES = (
    Rule(
        lambda w: not w.searched,
        Outcome.DEADLINE,
        lambda w: (
            'allow more time, or shorten the window: none was left to look for jumps or '
            'process noise'
        ),
    ),
    Rule(
        lambda w: w.drifting and bool(w.found.accepted),
        Outcome.MODEL_MISMATCH,
        lambda w: (
            f'shorten the window: {w.jumps} jumps in it, or a drifting parameter; '
            'standard deviations are withheld'
        ),
    ),
    Rule(
        lambda w: not w.found.accepted,
        Outcome.DEADLINE,
        lambda w: (
            f'allow more {w.found.effort.units if w.in_time else "time"}, or shorten the '
            f'window: best of {w.candidates} candidates in {w.found.effort}, not confirmed'
        ),
    ),
    Rule(
        lambda w: w.unskilled,
        Outcome.MODEL_MISMATCH,
        lambda w: (
            'check units, inputs, fixed values and bounds: forecasts of the model are no better '
            'than holding the last value'
            + (f'; {w.misfit}' if w.misfit else '')
            + '; standard deviations are withheld'
        ),
    ),
    Rule(
        lambda w: w.useful and bool(w.misfit),
        Outcome.APPROXIMATE,
        lambda w: _roughly(w, w.misfit),
    ),
    Rule(
        lambda w: w.useful and bool(w.flaws),
        Outcome.APPROXIMATE,
        lambda w: _roughly(w, w.flaws),
    ),
    Rule(
        lambda w: w.useful and (w.skill or 0.0) < SKILL.convincing,
        Outcome.APPROXIMATE,
        lambda w: _roughly(w, 'process noise is large'),
    ),
    Rule(
        lambda w: w.fit.too_large,
        Outcome.MODEL_MISMATCH,
        lambda w: (
            f'check the noise, the model and its fixed values, or shorten the window: {w.misfit}'
        ),
    ),
    Rule(
        lambda w: w.fit.too_small,
        Outcome.MODEL_MISMATCH,
        lambda w: f'check the noise if it is given: {w.misfit}; standard deviations are too large',
    ),
    Rule(
        lambda w: bool(w.misfit),
        Outcome.MODEL_MISMATCH,
        lambda w: (
            'look for what the model leaves out, a parameter that moved inside the window, '
            f'or coarse rounding: {w.misfit}'
        ),
    ),
    Rule(
        lambda w: bool(w.undetermined),
        Outcome.NOT_IDENTIFIABLE,
        lambda w: w.unidentified + (f'; {w.bounds}' if w.bounds and w.disturbance else ''),
    ),
    Rule(
        lambda w: bool(w.bounds),
        Outcome.AT_BOUND,
        lambda w: f'check the bounds, or the model: {w.bounds}; {w.found.accepted}',
    ),
    Rule(
        lambda w: bool(w.resting),
        Outcome.AT_BOUND,
        lambda w: f'{w.found.accepted}',
    ),
    Rule(
        lambda w: True,
        Outcome.CONVERGED,
        lambda w: f'{w.found.accepted}',
    ),
)


def _roughly(w: Findings, why: str) -> str:
    """Return the message on a model that is roughly right, with all else that is to be said."""
    parts = ['look for what the model leaves out: it is only roughly right', why]
    parts += [said for said in (w.bounds, w.unidentified if w.undetermined else '') if said]
    return '; '.join(parts)


def is_useful(fit: Fit, skill: float | None) -> bool:
    """Whether a model that noise alone does not confirm is roughly right.

    Its forecasts beat holding the last value, and it leaves no more than some times the noise.
    """
    large = fit.too_large and fit.ratio > SKILL.most_noise
    return skill is not None and skill > 0.0 and not large


def is_confirmed(fit: Fit, skill: float | None) -> bool:
    """Whether noise explains the residual, or forecasts show that the model is roughly right."""
    return not fit.too_large if skill is None else is_useful(fit, skill)


def is_told(uncertainty: Uncertainty, found: Found, fit: Fit) -> bool:
    """Whether deviations mean something: the window is searched, and the model confirmed."""
    searched = uncertainty.finished and bool(found.accepted)
    return searched and not uncertainty.drifting and is_confirmed(fit, uncertainty.skill)


def judged(findings: Findings) -> tuple[Outcome, str]:
    """Return the outcome of the first rule that applies, and its message.

    States that rest at a bound are said first, whatever the outcome, as there the model may not
    hold; and before all, priors that are contradicted.
    """
    rule = next(rule for rule in RULES if rule.applies(findings))
    message = rule.message(findings)
    if findings.skill is not None:
        message = (
            f'{message}; forecasts an eighth of a window ahead have skill {findings.skill:.2f}'
        )
    if findings.disturbance:
        message = f'{message}; {findings.disturbance}'
    if findings.resting:
        message = f'{findings.resting}: check the bounds, or the model; {message}'
    if findings.contradicted:
        message = f'check the prior, or the model: {findings.contradicted}; {message}'
    return rule.outcome, message


def states_at_bound(model: Model, states: Array) -> str:
    """Say which states (K, n) lie at a bound, or beyond it, for more than a moment."""
    found = []
    rows = np.ascontiguousarray(states.T)
    least, most = rows.min(axis=1).tolist(), rows.max(axis=1).tolist()  # NaN is at no bound
    for i, (variable, path) in enumerate(zip(model.states, rows, strict=True)):
        lower, upper = lasting_bounds(variable)
        reach = AT_BOUND * (upper - lower)
        margin = reach if np.isfinite(reach) else 0.0
        if least[i] > lower + margin and most[i] < upper - margin:
            continue
        for side, bound, beyond in (
            ('lower', lower, path <= lower + margin),
            ('upper', upper, path >= upper - margin),
        ):
            if np.isfinite(bound) and np.mean(beyond) > MOMENT:
                found.append(
                    f'{variable.name} lies at its {side} bound {_measured(bound, variable)}'
                )
    return ', '.join(found)


def unknowns_at_bound(unknowns: Unknowns, z: Array) -> str:
    """Say which unknowns z (d,) lie at a bound of their box, and at which."""
    found = []
    for name, side in at_bound(unknowns, z).items():
        variable, i = unknowns.model.variable(name), unknowns.names.index(name)
        bound = unknowns.scale.lower[i] if side == 'lower' else unknowns.scale.upper[i]
        found.append(f'{name} is at its {side} bound {_measured(bound, variable)}')
    return ', '.join(found)


def at_bound(unknowns: Unknowns, z: Array) -> dict[str, str]:
    """Return the names of unknowns z (d,) that lie at a bound, and at which: lower or upper."""
    least, most = unknowns.limits
    sides = {}
    for i, name in enumerate(unknowns.names):
        if z[i] <= least[i] + AT_BOUND:
            sides[name] = 'lower'
        elif z[i] >= most[i] - AT_BOUND:
            sides[name] = 'upper'
    return sides


def _measured(value: float, variable: Variable) -> str:
    """Return a value with its unit."""
    return f'{value:g}' if variable.unit == '1' else f'{value:g} {variable.unit}'
