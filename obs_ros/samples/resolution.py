"""Sensors that round: steps learned from the values, and how often a value then repeats.

Values that a sensor rounds lie on a grid, in its own unit or in the one that they were converted
from. Its step is the slope of the distinct values, in order, over the numbers of their grid lines.
"""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from obs_ros.core.model import Variable
from obs_ros.core.typing import Array
from obs_ros.samples.range_check import LARGEST


@dataclass(frozen=True)
class ResolutionSettings:
    """Evidence that values lie on a grid, and limits of what repeats by rounding.

    - `distinct`: least number of different values: a switch, a mode or a valve has fewer;
    - `twice`: least share of them that were measured more than once: numbers with noise never are;
    - `off`: farthest from its grid line that a value may lie, in steps: degrees Fahrenheit, rounded
      to 0.1 degrees Celsius, lie within 0.09; twelve random values pass in one case of 3000;
    - `same`: share of the largest value within which two are one, as 0.3 and 0.1 + 0.2;
    - `most`: distinct values that are remembered; a sensor with more is not coarse;
    - `waiting`: windows or samples after which steps are sought, unless `learn` is called before;
    - `chance`: probability, that noise alone repeats a value so often, at which nobody believes it;
    - `enough`: values outside long runs that tell the noise; with fewer, the last known one holds;
    - `share`: of the second differences, by whose size noise is told from rounding: a quarter is 0
      where the noise is below half a step, however the signal moves.
    """

    distinct: int = 12
    twice: float = 0.5
    off: float = 0.12
    same: float = 1e-9
    most: int = 1000
    waiting: int = 200
    chance: float = 1e-6
    enough: int = 30
    share: float = 0.25


DEFAULT = ResolutionSettings()
QUARTER = 0.31864  # of the sizes of unit normal noise a quarter is below this


def step_of(values: Array, settings: ResolutionSettings = DEFAULT) -> float | None:
    """Return the step of the grid on which distinct values (M,) lie; None if there is none."""
    ordered = np.unique(values)
    near = settings.same * np.abs(ordered).max(initial=0.0)
    ordered = ordered[np.diff(ordered, prepend=-np.inf) > near]
    # Sums of larger numbers may overflow.
    if ordered.size < settings.distinct or np.abs(ordered).max() > LARGEST:
        return None
    gaps = np.diff(ordered).tolist()
    line, lines, step, rise = 0, [0], min(gaps), 0.0
    for gap in gaps:
        line += max(1, round(gap / step))
        rise += gap
        lines.append(line)
        # The more steps there are, the less the rounding after a conversion hides the true one.
        step = rise / line
    found, at = np.polyfit(lines, ordered, 1)
    off = np.abs(ordered - (at + found * np.array(lines))).max()
    return float(f'{found:.6g}') if off <= settings.off * found else None


@dataclass(frozen=True)
class ResolutionMemory:
    """Values of each output with their counts, steps, noises; which outputs are still looked at.

    `newest` is the time (s) of the newest sample that was looked at, -inf: of none.
    """

    seen: tuple[Mapping[float, int], ...]
    steps: tuple[float | None, ...]
    unknown: tuple[int, ...]
    noises: tuple[float, ...]
    newest: float


class Resolutions:
    """Steps of the sensors of some outputs: those that are declared, and else those learned."""

    def __init__(self, outputs: Sequence[Variable], settings: ResolutionSettings = DEFAULT) -> None:
        self._outputs, self._settings = tuple(outputs), settings
        self.clear()

    def clear(self) -> None:
        """Forget what was learned."""
        self._seen: list[Counter[float]] = [Counter() for _ in self._outputs]
        self._steps: list[float | None] = [None] * len(self._outputs)
        self._unknown = [i for i, v in enumerate(self._outputs) if v.resolution is None]
        self._noises = [0.0] * len(self._outputs)  # as last told from enough values
        self._waiting: list[Array] = []  # what no step was sought in yet
        self._newest = -math.inf  # time (s) of the newest sample of a window noted

    @property
    def memory(self) -> ResolutionMemory:
        """All that was learned."""
        self.learn()
        seen = tuple(dict(each) for each in self._seen)
        steps, noises = tuple(self._steps), tuple(self._noises)
        return ResolutionMemory(seen, steps, tuple(self._unknown), noises, self._newest)

    def recall(self, memory: ResolutionMemory) -> None:
        """Know what another one learned, of the same outputs."""
        self._seen = [Counter(each) for each in memory.seen]
        self._steps, self._noises = list(memory.steps), list(memory.noises)
        self._unknown, self._newest = list(memory.unknown), memory.newest
        self._waiting = []

    def note(self, y: Array) -> None:
        """Take measured outputs (K, r) or (r,), NaN = not measured, to learn from."""
        if self._unknown:
            self._waiting.append(y)
            if len(self._waiting) >= self._settings.waiting:
                self.learn()

    def note_window(self, t: Array, y: Array) -> None:
        """Take outputs (K, r) at t (K,) s, but for those that an overlapping window had already."""
        if t[-1] < self._newest:  # another recording
            self._newest = -math.inf
        if (fresh := t > self._newest).any():
            self.note(y[fresh])
        self._newest = float(t[-1])

    def learn(self) -> None:
        """Seek steps in all values so far; a sensor with very many values is given up."""
        if not self._waiting:
            return
        s, y = self._settings, np.vstack(self._waiting)
        self._waiting.clear()
        for i in self._unknown.copy():
            seen, column = self._seen[i], y[:, i]
            before = len(seen)
            seen.update(column[np.isfinite(column)].tolist())
            if len(seen) > s.most:
                self._unknown.remove(i)
                self._steps[i] = None
                seen.clear()
            elif len(seen) > before or self._steps[i] is None:
                twice = sum(count > 1 for count in seen.values()) >= s.twice * len(seen)
                self._steps[i] = step_of(np.array(list(seen)), s) if twice else None

    @property
    def learned(self) -> Mapping[str, float]:
        """The steps that were learned, by output, in its unit."""
        found = zip(self._outputs, self._steps, strict=True)
        return {variable.name: step for variable, step in found if step is not None}

    @property
    def figures(self) -> dict[str, float]:
        """The steps that were learned, as the diagnostics show them."""
        return {f'resolution.{name}': step for name, step in self.learned.items()}

    def natural_repeats(self, i: int, moving: Array, noise: float) -> float:
        """Return how many equal values in a row the sensor of output i shows by itself.

        `moving` (M,) are values of it in order, without long runs of equal ones; `noise` is the
        deviation that is given for it, NaN if none is, of the rounded values. 0 where the sensor is
        not known to round; infinity where its noise hardly reaches the next grid line or was never
        told, or where the step is declared and the noise not given.
        """
        self.learn()
        declared = self._outputs[i].resolution
        step = declared or self._steps[i]
        if step is None:
            return 0.0
        if not math.isnan(noise):
            variance = noise**2 - self._outputs[i].rounding ** 2
        elif declared is not None:
            return math.inf
        else:
            if moving.size >= self._settings.enough:
                self._noises[i] = noise_beside(step, moving, self._settings)
            variance = self._noises[i] ** 2
        return repeats_by_chance(step, math.sqrt(max(variance, 0.0)), self._settings)


def noise_beside(step: float, values: Array, settings: ResolutionSettings = DEFAULT) -> float:
    """Return the noise of a sensor by the second differences of its values (M,), less rounding."""
    bends = np.abs(np.diff(values, 2))
    size = float(np.quantile(bends, settings.share)) if bends.size else 0.0
    return math.sqrt(max((size / QUARTER) ** 2 / 6.0 - step**2 / 12.0, 0.0))


def repeats_by_chance(step: float, noise: float, settings: ResolutionSettings = DEFAULT) -> float:
    """Return how many equal values in a row rounding to `step` leaves of noise at the most."""
    inside = math.erf(step / (2.0 * math.sqrt(2.0) * noise)) if noise > 0.0 else 1.0
    return math.log(settings.chance) / math.log(inside) if inside < 1.0 else math.inf
