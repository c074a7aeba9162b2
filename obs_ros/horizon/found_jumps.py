"""The jumps of a hypothesis about a window, in the parameters' units."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from obs_ros.core.typing import Array
from obs_ros.inference.jumps.hypothesis import Hypothesis
from obs_ros.inference.jumps.layout import Layout
from obs_ros.inference.jumps.moment import time_variance
from obs_ros.inference.jumps.piecewise import interval_of
from obs_ros.inference.parameterisation import Unknowns


@dataclass(frozen=True)
class Size:
    """Size of one parameter's jump and its standard deviation, in the parameter's unit.

    `change` is the size as searches see the parameter, and `spread` its standard deviation, in
    boxes: on a log scale a ratio may be sure though both values are not.
    """

    value: float
    stddev: float
    change: float
    spread: float

    def clear(self, deviations: float) -> bool:
        """Whether it differs from no jump at all by more than so many standard deviations."""
        return abs(self.change) > deviations * self.spread

    @classmethod
    def of(cls, unknowns: Unknowns, place: int, ends: Array, covariance: Array) -> 'Size':
        """Return the size of a jump between `ends` (2,), in boxes, of this covariance (2, 2)."""
        slopes = unknowns.scale.slopes(ends, place) * (-1.0, 1.0)
        return cls(
            value=float(np.diff(unknowns.scale.values(ends, place))[0]),
            stddev=_root(slopes @ covariance @ slopes),
            change=float(ends[1] - ends[0]),
            spread=_root(covariance[0, 0] + covariance[1, 1] - 2.0 * covariance[0, 1]),
        )


@dataclass(frozen=True)
class JumpFound:
    """Jumps at one time (s), of this standard deviation (s), by parameters' names."""

    time: float
    deviation: float
    sizes: Mapping[str, Size]

    @property
    def names(self) -> frozenset[str]:
        """The parameters that jumped."""
        return frozenset(self.sizes)

    def clear(self, deviations: float) -> bool:
        """Whether any size differs from none by more than so many standard deviations."""
        return any(size.clear(deviations) for size in self.sizes.values())


@dataclass(frozen=True)
class Explained:
    """A window from `start` to `end` (s) that its hypothesis explains, at a point (D,).

    `pushed`: beside process noise.
    """

    start: float
    end: float
    layout: Layout
    point: Array
    pushed: bool

    @classmethod
    def by(cls, hypothesis: Hypothesis) -> 'Explained':
        """Return what later windows need of a window's hypothesis."""
        grid = hypothesis.problem.objective.grid
        pushed = grid.injection is not None
        start, end = float(grid.t[0]), float(grid.t[-1])
        return cls(start, end, hypothesis.layout, hypothesis.point, pushed)


def jumps_of(best: Hypothesis, covariance: Array) -> Iterator[JumpFound]:
    """Yield the jumps of a hypothesis: inside the window by time, then those before it.

    `covariance` (D, D) is that of its point.
    """
    prior, unknowns = best.problem.prior, best.problem.objective.unknowns
    t, point = best.problem.objective.grid.t, best.point
    start, duration = float(t[0]), float(t[-1] - t[0])
    for event, jumps in groupby(best.layout.jumped(point), lambda jump: jump.event):
        place = best.layout.times[event]
        time = start + duration * float(point[place])
        # The model determines where in its interval a jump lies only as a mean.
        interval = np.diff(t)[interval_of(t, np.array(time))]
        own = time_variance(best, place, float(covariance[place, place]))
        variance = duration**2 * own + interval**2 / 12.0
        sizes = {}
        for jump in jumps:
            ends = [jump.before, jump.after]
            size = Size.of(unknowns, jump.parameter, point[ends], covariance[np.ix_(ends, ends)])
            sizes[unknowns.names[jump.parameter]] = size
        yield JumpFound(time, _root(variance), sizes)
    if best.earlier:
        # Some time since a window would have shown it; the size is against the mean handed on.
        unseen = best.unseen * duration
        sizes = {
            unknowns.names[i]: Size.of(
                unknowns, i, np.array([prior.mean[i], point[i]]), np.diag([0.0, covariance[i, i]])
            )
            for i in best.earlier
        }
        yield JumpFound(start - 0.5 * unseen, unseen / np.sqrt(12.0), sizes)


def together(names: Iterable[str]) -> str:
    """Return the words for parameters that jump at once."""
    return ' and '.join(sorted(names))


def _root(variance: Array | np.float64) -> float:
    return float(np.sqrt(max(float(variance), 0.0)))
