"""Angles, and whatever else begins again after one period: differences by the shortest way round.

A value with a period stands for itself and all values whole periods away. A period of 0 stands for
a variable that has none: it passes unchanged, bit by bit.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median

import numpy as np

from obs_ros.core.jit import unhurried
from obs_ros.core.model import Model, Variable, inside
from obs_ros.core.typing import Array

SAME = 1e-6  # of 1 and of a value: sines of large angles differ by rounding


def periods(variables: Sequence[Variable]) -> Array:
    """Return the periods (n,) of the variables in their units, 0 for those that have none."""
    return np.array([variable.period or 0.0 for variable in variables])


def lasting_bounds(variable: Variable) -> tuple[float, float]:
    """Return the bounds that hold all along: those of a variable with a period hold at first."""
    return (variable.lower, variable.upper) if variable.period is None else (-math.inf, math.inf)


def has_period(model: Model, state: int, period: float, draws: int = 16) -> bool:
    """Whether a model is the same one period of a state on, as far as random points tell.

    Its dynamics do not change then, and outputs with periods at most by whole ones.
    """
    rng = np.random.default_rng(0)
    groups = (model.states, model.inputs, model.parameters)
    x, u, p = (np.array([_drawn(v, rng, draws) for v in group]) for group in groups)
    further = x.copy()
    further[state] += period
    turns = periods(model.outputs)
    with np.errstate(all='ignore'):
        # The next state is as many periods on as the state.
        on = np.zeros(len(x)) if model.kind == 'continuous' else periods(model.states)
        for function, wraps in ((model.dynamics, on), (model.output, turns)):
            now, then = (
                np.column_stack([np.broadcast_to(y, draws)
                                 for y in function(0.0, tuple(at), tuple(u), tuple(p))])
                for at in (x, further)
            )  # fmt: skip
            off = np.abs(shortest(then - now, wraps))
            if (off > SAME * (1.0 + np.abs(now))).any():
                return False
    return True


def _drawn(variable: Variable, rng: np.random.Generator, draws: int) -> Array:
    """Return random values (draws,) between the bounds, or about a value inside them."""
    width = variable.upper - variable.lower
    share = rng.uniform(0.1, 0.9, draws)
    if math.isfinite(width):
        return np.asarray(variable.lower + share * width)
    return np.asarray(inside(variable) + share - 0.5)


def shortest(differences: Array, period: Array) -> Array:
    """Return differences (..., n), less whole periods (n,): within [-period/2, period/2)."""
    if not np.any(period):  # a number, too
        return differences
    known = period > 0.0
    turns = np.floor(np.divide(differences, period, out=np.zeros_like(differences), where=known)
                     + 0.5)  # fmt: skip
    return np.asarray(differences - period * turns)


@unhurried
def shortest_way(difference: float, period: float) -> float:
    """Return one difference by the shortest way round; see `shortest`."""
    if period > 0.0:
        difference -= period * np.floor(difference / period + 0.5)
    return difference


def nearest(values: Array, to: Array, period: Array) -> Array:
    """Return values (..., n), whole periods (n,) away, that lie nearest `to` (..., n).

    NaN and infinite values stay, and so do values where `to` is NaN.
    """
    if not np.any(period):
        return values
    known = (period > 0.0) & np.isfinite(values) & np.isfinite(to)
    off = np.divide(values - to, period, out=np.zeros(known.shape), where=known)
    return np.asarray(values - period * np.floor(off + 0.5))


def within(values: Array, period: Array) -> Array:
    """Return values (..., n) as they are published: those with a period in [-period/2, period/2).

    A value that lies there already keeps its bits.
    """
    if not np.any(period):
        return values
    half = np.where(period > 0.0, 0.5 * period, np.inf)
    inside = nearest(values, np.zeros_like(values), period)
    # Rounding may lead out by a bit on either side.
    inside = np.where(inside < -half, inside + period, inside)
    return np.asarray(np.where(inside >= half, inside - period, inside))


@dataclass(frozen=True)
class UnwrapSettings:
    """Limits in making measured angles continuous.

    - `sure`: share of a period; where no step is longer, nor what the usual pace makes of the
      longest gap, the shortest way is believed as it is;
    - `behind`: values before each, of which most must be right;
    - `around`: steps on either side whose median is the pace.
    """

    sure: float = 0.25
    behind: int = 5
    around: int = 10


UNWRAP = UnwrapSettings()


def continuous(t: Array, y: Array, period: Array) -> Array:
    """Return values (K, n) at times (K,) without wraps, the first ones in [-period/2, period/2).

    NaN = not measured. From value to value they go the shortest way; where steps are long, nearest
    to the median of what the values before make of the pace: an outlier leads no other astray, and
    in a gap the plant turns on.
    """
    y = y.copy()
    for i in np.flatnonzero(period):
        known = np.flatnonzero(np.isfinite(y[:, i]))
        if known.size:
            y[known, i] = _unwrapped(t[known], y[known, i], period[i : i + 1])
    return y


def _unwrapped(t: Array, y: Array, period: Array, settings: UnwrapSettings = UNWRAP) -> Array:
    """Return values (M,) of one output; see `continuous`."""
    steps, first = shortest(np.diff(y), period), within(y[:1], period)
    turned = np.concatenate([first, first + np.cumsum(steps)])
    gaps = np.diff(t)
    usual = np.median(np.abs(steps / gaps)) * gaps.max() if y.size > 1 else 0.0
    if max(usual, np.abs(steps).max(initial=0.0)) > settings.sure * period[0]:
        reach = settings.around
        rates = np.pad(steps / gaps, reach, constant_values=np.nan)
        around = np.lib.stride_tricks.sliding_window_view(rates, 2 * reach + 1)
        paces, times = np.nanmedian(around, axis=1).tolist(), t.tolist()
        values, turn = [float(first[0])], float(period[0])
        for k, measured in enumerate(y[1:].tolist(), 1):
            before = range(max(0, k - settings.behind), k)
            expected = median(values[j] + paces[k - 1] * (times[k] - times[j]) for j in before)
            values.append(measured - turn * math.floor((measured - expected) / turn + 0.5))
        turned = np.array(values)
    # What was measured, so many periods on: sums of steps would gather rounding errors.
    return nearest(y, turned, period)


def together(values: Array, period: float) -> Array:
    """Return values (K,), whole periods away, about their mean direction; NaN stays.

    Medians and quantiles of angles about pi mean something then.
    """
    known = values[np.isfinite(values)]
    if not period or not known.size:
        return values
    turn = 2.0 * np.pi / period
    middle = np.arctan2(np.sin(turn * known).mean(), np.cos(turn * known).mean()) / turn
    return nearest(values, np.full_like(values, middle), np.asarray(period))
