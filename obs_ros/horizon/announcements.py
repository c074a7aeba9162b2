"""Which jumps a window tells of, and which of them are news.

Windows that overlap show the same jump again and again: it is announced once, by the first window
that shows it clearly.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from obs_ros.core.estimate import Jump
from obs_ros.core.record import Record
from obs_ros.core.typing import Array
from obs_ros.inference.assessment.uncertainty import Uncertainty
from obs_ros.inference.jumps.hypothesis import Hypothesis
from obs_ros.inference.jumps.piecewise import interval_of
from obs_ros.inference.parameterisation import Unknowns

CLEAR = 2.0  # standard deviations from no jump
SAME_TIME = 0.05  # window; jumps found nearer to each other than that, or
SAME_DEVIATIONS = 5.0  # than so many standard deviations, are one and the same


@dataclass
class Sizes:
    """What jumped at one time (s): by how much and how surely, in the parameters' units.

    `clear` tells whether any of it is told from no jump at all, as searches see the parameters: on
    a log scale a ratio may be sure though both values are not.
    """

    time: float
    deviation: float
    sizes: dict[str, float] = field(default_factory=dict)
    stddev: dict[str, float] = field(default_factory=dict)
    clear: bool = False

    def add(self, unknowns: Unknowns, place: int, ends: Array, covariance: Array) -> None:
        """Add a parameter that jumped between two `ends` (2,), in boxes, of this covariance."""
        name = unknowns.names[place]
        slopes = unknowns.scale.slopes(ends, place) * (-1.0, 1.0)
        self.sizes[name] = float(np.diff(unknowns.scale.values(ends, place))[0])
        self.stddev[name] = _root(slopes @ covariance @ slopes)
        spread = _root(covariance[0, 0] + covariance[1, 1] - 2.0 * covariance[0, 1])
        self.clear |= bool(abs(ends[1] - ends[0]) > CLEAR * spread)


class Announcements:
    """Remembers what has been announced."""

    def __init__(self) -> None:
        self._announced: list[Jump] = []

    def of(
        self, uncertainty: Uncertainty, alternatives: Sequence[Hypothesis], record: Record
    ) -> tuple[Jump, ...]:
        """Return what jumped, with its time and size, and whether that is news."""
        grid = uncertainty.hypothesis.problem.objective.grid
        names = uncertainty.hypothesis.problem.objective.unknowns.names
        start, duration = float(grid.t[0]), float(grid.t[-1] - grid.t[0])
        newest = float(grid.t[np.flatnonzero(grid.measured)[-1]])
        others = tuple(
            together(names[i] for i in other.parameters) or 'no jump' for other in alternatives
        )
        explained = not uncertainty.fit.too_large
        self._announced = [jump for jump in self._announced if jump.time > start - duration]
        jumps = []
        for found in _jumped(uncertainty):
            jump = Jump(
                time=found.time,
                time_stddev=found.deviation,
                sizes=found.sizes,
                stddev=found.stddev,
                new=False,
                alternatives=others,
                stamp=None if record.stamp is None
                else record.stamp - round((newest - found.time) * 1e9),
            )  # fmt: skip
            new = explained and found.clear and not self._known(jump, SAME_TIME * duration)
            jumps.append(replace(jump, new=new))
        self._announced += [jump for jump in jumps if jump.new]
        return tuple(jumps)

    def _known(self, jump: Jump, near: float) -> bool:
        """Whether this jump has been announced, by this name or by one that explains as much."""
        name = together(jump.sizes)
        for known in self._announced:
            same = name in (together(known.sizes), *known.alternatives)
            within = SAME_DEVIATIONS * max(jump.time_stddev, known.time_stddev)
            if (same or together(known.sizes) in jump.alternatives) and (
                abs(known.time - jump.time) <= max(near, within)
            ):
                return True
        return False


def together(names: Iterable[str]) -> str:
    """Return the words for parameters that jump at once."""
    return ' and '.join(sorted(names))


def _jumped(uncertainty: Uncertainty) -> list[Sizes]:
    """Return what a hypothesis says to have jumped: inside the window by time, then before it."""
    best, covariance = uncertainty.hypothesis, uncertainty.covariance
    unknowns, t = best.problem.objective.unknowns, best.problem.objective.grid.t
    start, duration = float(t[0]), float(t[-1] - t[0])
    found: dict[int, Sizes] = {}
    for event, parameter, before, after in best.layout.jumped(best.point):
        place = best.layout.times[event]
        if event not in found:
            time = start + duration * float(best.point[place])
            # Where in its interval a jump lies, the model tells only as a mean.
            interval = np.diff(t)[interval_of(t, np.array(time))]
            variance = duration**2 * covariance[place, place] + interval**2 / 12.0
            found[event] = Sizes(time, _root(variance))
        ends = [before, after]
        found[event].add(unknowns, parameter, best.point[ends], covariance[np.ix_(ends, ends)])
    jumps = list(found.values())
    if best.earlier:
        # Some time since the last window known; the size is against what that said.
        gap = best.problem.prior.gap * duration
        earlier = Sizes(start - 0.5 * gap, gap / np.sqrt(12.0))
        for place in best.earlier:
            ends_of = np.array([best.problem.prior.mean[place], best.point[place]])
            earlier.add(unknowns, place, ends_of, np.diag([0.0, covariance[place, place]]))
        jumps.append(earlier)
    return jumps


def _root(variance: Array | np.float64) -> float:
    return float(np.sqrt(max(float(variance), 0.0)))
