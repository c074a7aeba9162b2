"""Window and sample interval that suit a model."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from obs_ros.cli.model_motion import Motion, motion_of, rounded
from obs_ros.cli.model_trial import Trial, simulated
from obs_ros.core.linear_algebra import scaled_inverse
from obs_ros.core.model import Model, Variable, inside
from obs_ros.core.typing import Array
from obs_ros.inference.assessment.identifiability import undetermined
from obs_ros.inference.jumps.hypothesis import hypothesis_at
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.objective import Objective
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.inference.prior import Prior


@dataclass(frozen=True)
class ProposalSettings:
    """A window that moves, from whose samples some are left out.

    - `samples`: in it, the densest that is looked at;
    - `looks`: nodes of a rollout at which time constants are looked at;
    - `lengths`: of that rollout that are tried;
    - `steps`: of the model's `max_step` in it, at most;
    - `fewest`: samples that a window must have;
    - `lost`: ratio of deviations, for the same number of samples, up to which nothing is lost;
    - `start`, `moved`: shares of their boxes by which states are off at the start, and by which
      inputs move; of their nominal value where they have none.
    """

    samples: int = 384
    looks: int = 40
    lengths: int = 4
    steps: int = 2000
    fewest: int = 48
    lost: float = 1.15
    start: float = 0.2
    moved: float = 0.2


PROPOSAL = ProposalSettings()


def motion_along(trial: Trial) -> Motion:
    """Return the time constants along a trial, its start apart."""
    x = trial.states[1:].T
    p = np.repeat(trial.p[:, None], x.shape[1], axis=1)
    return motion_of(trial.model, x, p, float(trial.record.t[-1]))


def settled_motion(
    model: Model,
    over: Motion,
    values: Mapping[str, float],
    amplitudes: Mapping[str, float],
    noise: Mapping[str, float],
    settings: ProposalSettings = PROPOSAL,
) -> Motion:
    """Return the time constants along a rollout that is as long as the slowest of them.

    `over` are those over the box, most of them off the slow manifolds of a stiff plant: the rollout
    gets longer until it is long enough, or shorter where it does not stay finite.
    """
    longest = settings.steps * model.max_step
    length, found = min(over.longest, longest), over
    for _ in range(settings.lengths):
        if not math.isfinite(length):
            break
        try:
            trial = simulated(model, length, length / settings.looks, values, amplitudes, noise)
        except ValueError:
            length *= 0.25
            continue
        found = motion_along(trial)
        if not length < min(found.wanted, longest):
            break
        length = min(found.wanted, longest)
    return found


def proposed(
    model: Model,
    motion: Motion,
    values: Mapping[str, float],
    noise: Mapping[str, float],
    settings: ProposalSettings = PROPOSAL,
) -> list[str]:
    """Return a line that proposes the window's length and the sample interval."""
    length = motion.wanted
    if not math.isfinite(length):
        return ['proposed: a window in which all inputs and states move; its length is up to them']
    try:
        interval = _interval(_moving(model, length, values, noise, settings), settings)
    except ValueError:  # it does not stay finite
        interval = math.nan
    said = f'proposed: window.duration {length:g} s, for the slowest time constant'
    if math.isfinite(interval):
        said += f'; a sample every {interval:g} s or less, as sparser ones miss motion that tells'
    return [said]


def _moving(
    model: Model,
    length: float,
    values: Mapping[str, float],
    noise: Mapping[str, float],
    settings: ProposalSettings,
) -> Trial:
    """Return a trial whose states start off their nominal values, and whose inputs move."""
    off = {v.name: _off(v, settings.start) for v in model.states}
    amplitudes = {v.name: settings.moved * _size(v) for v in model.inputs}
    period = length / settings.samples
    return simulated(model, length, period, {**off, **values}, amplitudes, noise)


def _interval(trial: Trial, settings: ProposalSettings) -> float:
    """Return the longest sample interval (s) by which no unknown gets less certain.

    That is for the same number of samples: more of them always tell more.
    """
    model = trial.model
    unknowns = Unknowns.of(model)
    objective = Objective(trial.kernels, trial.grid, unknowns)
    named = dict(zip(unknowns.names, (*trial.x0, *trial.p), strict=True))
    prior = Prior.known(unknowns, start=True)
    best = hypothesis_at(PiecewiseProblem(objective, prior), unknowns.point(named))
    nodes = np.broadcast_to(np.arange(trial.record.t.size)[:, None], trial.grid.weight.shape)
    nodes = nodes[trial.grid.weight > 0.0]
    J = best.linearisation.jacobian
    deviations = _deviations(J, np.ones(len(J), dtype=bool), prior)
    known = deviations < undetermined(unknowns)
    if not known.any():
        return math.nan
    stride = 1
    while trial.record.t.size // (2 * stride) >= settings.fewest:
        coarser = _deviations(J, nodes % (2 * stride) == 0, prior)
        if not (coarser[known] <= settings.lost * deviations[known]).all():
            break
        stride *= 2
    return rounded(stride * float(trial.record.t[1]), down=True)


def _deviations(J: Array, kept: np.ndarray, prior: Prior) -> Array:
    """Return standard deviations (d,) by some rows of J (M, d), counted as if they were all."""
    rows = J[kept] * math.sqrt(len(J) / max(1, int(kept.sum())))
    variances = np.diagonal(scaled_inverse(rows.T @ rows + prior.precision))
    return np.asarray(np.sqrt(np.maximum(variances, 0.0)))


def _off(variable: Variable, share: float) -> float:
    """Return a value off the nominal one by a share of the box, towards its farther end."""
    value, width = inside(variable), variable.upper - variable.lower
    if not math.isfinite(width):
        return value
    away = share * width
    return value + away if variable.upper - value >= value - variable.lower else value - away


def _size(variable: Variable) -> float:
    """Return the width of an input's bounds or range, or the size of its nominal value."""
    low, high = variable.range or (variable.lower, variable.upper)
    if math.isfinite(high - low):
        return high - low
    return abs(inside(variable)) or 1.0
