"""Standard deviations that a Kalman filter begins with: of the start, the walks and the outputs."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from obs_ros.core.model import inside
from obs_ros.core.typing import Array, IntArray
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.observers import settings as table
from obs_ros.observers.settings import setting


@dataclass(frozen=True)
class KalmanSettings(table.Settings):
    """Standard deviations where no prior and no walk is given, as shares of the box."""

    initial_state: float = setting(
        0.3, "sd of the states at the start, as a share of their bounds' distance", lower=0.0,
        upper=1e3,
    )  # fmt: skip
    initial_parameter: float = setting(
        0.3, "sd of the parameters at the start, as a share of their bounds' distance", lower=0.0,
        upper=1e3,
    )  # fmt: skip
    state_walk: float = setting(
        1e-4, "sd that the model may err by within 1 s, as a share of the states' bounds' distance",
        '1/sqrt(s)', lower=0.0, upper=1e3,
    )  # fmt: skip
    parameter_walk: float = setting(
        1e-3, "sd that the parameters drift by within 1 s, as a share of their bounds' distance",
        '1/sqrt(s)', lower=0.0, upper=1e3,
    )  # fmt: skip
    output_noise: float = setting(
        1e-3, 'sd of outputs whose noise is not given, as a share of the range that they have',
        positive=True, upper=1e3,
    )  # fmt: skip


class Deviations(NamedTuple):
    """Standard deviations of D joint states, in their units.

    `width` (D,) is that of their boxes, `start` (D,) their deviation at the start, `walk` (D,) in
    one second. The walks of those at the places `relative` are shares of their values.
    """

    width: Array
    start: Array
    walk: Array
    relative: IntArray


def begun(unknowns: Unknowns, joint: IntArray, settings: KalmanSettings) -> Deviations:
    """Return the deviations of the model's variables `joint` (D,): given ones, else the settings'.

    Priors and finite walks are given. An infinite walk, new in every window, means nothing where
    there are no windows.
    """
    variables = [unknowns.model.variables[i] for i in joint]
    width = np.array([_width(unknowns, i) for i in joint])
    states = joint < len(unknowns.model.states)
    start = np.where(states, settings.initial_state, settings.initial_parameter) * width
    start = _given([v.prior and v.prior[1] for v in variables], start)
    walk = np.where(states, settings.state_walk, settings.parameter_walk) * width
    relative = [v.scale == 'log' and math.isfinite(v.walk or math.inf) for v in variables]
    return Deviations(
        width,
        start * np.isin(joint, unknowns.index),
        _given([v.walk for v in variables], walk),
        np.flatnonzero(relative),
    )


def output_noise(
    unknowns: Unknowns, noise: dict[str, float], share: float, points: int = 64
) -> Array:
    """Return standard deviations (r,): those given, else a share of each output's range.

    That is the distance of its bounds where they are finite, else the one over so many random
    points of the box.
    """
    model = unknowns.model
    x, p = unknowns.values(np.random.default_rng(0).random((points, unknowns.dimension)))
    u = tuple(inside(variable) for variable in model.inputs)
    with np.errstate(all='ignore'):
        outputs = model.output(0.0, tuple(x), u, tuple(p))
    deviations = []
    for variable, y in zip(model.outputs, outputs, strict=True):
        span = variable.upper - variable.lower
        if not math.isfinite(span):
            with np.errstate(all='ignore'):
                span = float(np.ptp(y))
        known = math.isfinite(span) and span > 0.0
        deviations.append(noise.get(variable.name, share * span if known else share))
    return np.array(deviations)


def _given(values: Sequence[float | None], otherwise: Array) -> Array:
    """Return the values (D,) that are given and finite, and the others' place in `otherwise`."""
    given = np.array([math.nan if value is None else value for value in values])
    return np.where(np.isfinite(given), given, otherwise)


def _width(unknowns: Unknowns, i: int) -> float:
    """Return the width of the box of the model's unknown i, for one not estimated its bounds'."""
    at = np.flatnonzero(unknowns.index == i)
    if at.size:
        return float(unknowns.scale.width[at[0]])
    variable = unknowns.model.variables[i]
    width = variable.upper - variable.lower
    return width if math.isfinite(width) else max(1.0, abs(variable.nominal or 0.0))
