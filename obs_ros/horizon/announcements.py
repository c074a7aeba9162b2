"""The jumps that a window shows, in the parameters' units, and which of them are news.

Windows that overlap show the same jump again and again: it is announced once, by the first window
that shows it clearly.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby

import numpy as np

from obs_ros.core.estimate import Jump
from obs_ros.core.record import Record
from obs_ros.core.typing import Array
from obs_ros.inference.assessment.uncertainty import Uncertainty
from obs_ros.inference.jumps.hypothesis import Hypothesis
from obs_ros.inference.jumps.piecewise import interval_of
from obs_ros.inference.parameterisation import Unknowns


@dataclass(frozen=True)
class AnnouncementSettings:
    """Limits of clear jumps and of like ones; see benchmarks/results/interconnected.md."""

    clear: float = 2.0  # standard deviations of a size, from none: 95 % two-sided
    same_time: float = 0.05  # window; jumps nearer to each other than that are one and the same,
    same_deviations: float = 5.0  # and those nearer than so many standard deviations of their times


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


class Announcements:
    """The jumps that have been announced, as long as a window may show them again."""

    def __init__(self, settings: AnnouncementSettings = AnnouncementSettings()) -> None:
        self.settings = settings
        self._announced: list[Jump] = []

    def of(
        self, uncertainty: Uncertainty, alternatives: Sequence[Hypothesis], record: Record
    ) -> tuple[Jump, ...]:
        """Return the jumps of a window, in order of time and earlier ones last; mark the news.

        A jump is news if it is clear, the window is explained, and none that was announced is the
        same.
        """
        objective = uncertainty.hypothesis.problem.objective
        grid, names = objective.grid, objective.unknowns.names
        start, duration = float(grid.t[0]), float(grid.t[-1] - grid.t[0])
        newest = float(grid.t[np.flatnonzero(grid.measured)[-1]])
        others = tuple(
            together(names[i] for i in other.parameters) or 'no jump' for other in alternatives
        )
        explained = not uncertainty.fit.too_large
        self._announced = [jump for jump in self._announced if jump.time > start - duration]
        jumps = []
        for found in jumps_of(uncertainty):
            jump = Jump(
                time=found.time,
                time_stddev=found.deviation,
                sizes={name: size.value for name, size in found.sizes.items()},
                stddev={name: size.stddev for name, size in found.sizes.items()},
                new=False,
                alternatives=others,
                stamp=None if record.stamp is None
                else record.stamp - round((newest - found.time) * 1e9),
            )  # fmt: skip
            clear = any(s.clear(self.settings.clear) for s in found.sizes.values())
            new = explained and clear and not self._known(jump, duration)
            jumps.append(replace(jump, new=new))
        self._announced += [jump for jump in jumps if jump.new]
        return tuple(jumps)

    def _known(self, jump: Jump, duration: float) -> bool:
        """Whether this jump has been announced, by this name or by one that explains as much."""
        name = together(jump.sizes)
        for known in self._announced:
            same = name in (together(known.sizes), *known.alternatives)
            within = self.settings.same_deviations * max(jump.time_stddev, known.time_stddev)
            if (same or together(known.sizes) in jump.alternatives) and (
                abs(known.time - jump.time) <= max(self.settings.same_time * duration, within)
            ):
                return True
        return False


def jumps_of(uncertainty: Uncertainty) -> Iterator[JumpFound]:
    """Yield the jumps of a hypothesis: inside the window by time, then those before it."""
    best, covariance = uncertainty.hypothesis, uncertainty.covariance
    prior, unknowns = best.problem.prior, best.problem.objective.unknowns
    t, point = best.problem.objective.grid.t, best.point
    start, duration = float(t[0]), float(t[-1] - t[0])
    for event, jumps in groupby(best.layout.jumped(point), lambda jump: jump.event):
        place = best.layout.times[event]
        time = start + duration * float(point[place])
        # The model determines where in its interval a jump lies only as a mean.
        interval = np.diff(t)[interval_of(t, np.array(time))]
        variance = duration**2 * covariance[place, place] + interval**2 / 12.0
        sizes = {}
        for jump in jumps:
            ends = [jump.before, jump.after]
            size = Size.of(unknowns, jump.parameter, point[ends], covariance[np.ix_(ends, ends)])
            sizes[unknowns.names[jump.parameter]] = size
        yield JumpFound(time, _root(variance), sizes)
    if best.earlier:
        # Some time since the last window known; the size is against the mean that it handed on.
        gap = prior.gap * duration
        sizes = {
            unknowns.names[i]: Size.of(
                unknowns, i, np.array([prior.mean[i], point[i]]), np.diag([0.0, covariance[i, i]])
            )
            for i in best.earlier
        }
        yield JumpFound(start - 0.5 * gap, gap / np.sqrt(12.0), sizes)


def together(names: Iterable[str]) -> str:
    """Return the words for parameters that jump at once."""
    return ' and '.join(sorted(names))


def _root(variance: Array | np.float64) -> float:
    return float(np.sqrt(max(float(variance), 0.0)))
