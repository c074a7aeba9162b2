"""How far off the time of a jump may be, where its derivatives do not tell.

A parameter that acts in the outputs only, such as a series resistance, shows which samples are
before the jump and which are after it, and nothing of where between two of them it lies: the
derivatives by its time are 0. From interval to interval the squares tell.
"""

from dataclasses import dataclass

import numpy as np

from obs_ros.inference.jumps.hypothesis import Hypothesis
from obs_ros.inference.jumps.piecewise import interval_of
from obs_ros.inference.parameterisation import BOX_VARIANCE


@dataclass(frozen=True)
class MomentSettings:
    """Limits in telling the time of a jump by the squares of other times.

    - `told`: share of a uniform time's variance, above which derivatives do not tell the time;
    - `reach`: intervals on both sides of it that are looked at;
    - `lost`: share of the greatest probability, below which the last of them must fall.
    """

    told: float = 0.5
    reach: int = 48
    lost: float = 1e-3


MOMENT = MomentSettings()


def time_variance(best: Hypothesis, place: int, linear: float) -> float:
    """Return the variance (windows^2) of the event's time at `place`, `linear` by derivatives.

    Where these do not tell it, that of the squares; `linear` still where they do not either.
    """
    if not linear > MOMENT.told * BOX_VARIANCE:
        return linear
    key = 'moment', place
    if key not in best.judged:  # a window asks for it several times
        best.judged[key] = _by_squares(best, place)
    found: float | None = best.judged[key]
    return linear if found is None else found


def _by_squares(best: Hypothesis, place: int) -> float | None:
    """Return the variance of a time by its posterior over the middles of the intervals nearby.

    All else is as it is. None where it does not end within reach.
    """
    problem = best.problem
    t = problem.objective.grid.t
    shares = (t - t[0]) / (t[-1] - t[0])
    own = int(interval_of(shares, best.point[[place]])[0])
    near = np.arange(max(0, own - MOMENT.reach), min(t.size - 1, own + MOMENT.reach + 1))
    middles = 0.5 * (shares[near] + shares[near + 1])
    points = np.tile(best.point, (near.size, 1))
    points[:, place] = middles
    costs = np.nan_to_num(problem.costs(points), nan=np.inf)
    likely = np.exp(-0.5 * (costs - costs.min())) * np.diff(shares)[near]
    cut = [likely[i] for i, end in ((0, 0), (-1, t.size - 2)) if near[i] != end]
    if not max(cut, default=0.0) < MOMENT.lost * likely.max():
        return None
    return float(likely @ (middles - best.point[place]) ** 2 / likely.sum())
