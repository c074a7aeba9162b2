"""Actuators between the inputs that are told and those that act: dead times and saturation."""

import bisect
import math
from collections.abc import Sequence
from dataclasses import dataclass

from obs_ros.core.model import Variable
from plant_sim.sensors import clipped, known_delay, limits
from plant_sim.signals import Signal

SAME_TIME = 1e-9  # s; times that differ by less are one


@dataclass(frozen=True)
class Actuator:
    """Faults of one input's actuator; the defaults are none.

    - `delay`: dead time in s: an input told at s acts from s + delay on. What is told first acted
      before the run as well.
    - `range`: lower and upper limit of the input that acts; (0, 0): none.
    """

    delay: float = 0.0
    range: tuple[float, float] = (0.0, 0.0)

    @classmethod
    def of(cls, input: Variable) -> 'Actuator':
        """Return the actuator that a model declares.

        One whose dead time is to be estimated has none; nor does any act before it is told.
        """
        return cls(delay=max(known_delay(input), 0.0), range=limits(input))

    @property
    def perfect(self) -> bool:
        """Whether the input acts as it is told."""
        return not self.delay and self.range[0] >= self.range[1]


IDEAL = Actuator()


class Inputs:
    """The inputs that were told, and those that act, through one actuator each.

    `running` is the signal that inputs follow between samples, or None where they are held.
    """

    def __init__(self, count: int, running: Signal | None) -> None:
        self._running = running
        self._times: list[float] = []
        self._told: list[tuple[float, ...]] = []
        self._nothing = (0.0,) * count

    def tell(self, t: float, u: tuple[float, ...], actuators: Sequence[Actuator]) -> None:
        """Take the inputs told at time `t` (s), and forget those that can act no more."""
        self._times.append(t)
        self._told.append(u)
        oldest = t - max((a.delay for a in actuators), default=0.0)
        past = bisect.bisect_right(self._times, oldest + SAME_TIME) - 1
        if past > 0:
            del self._times[:past], self._told[:past]

    def acting(self, t: float, actuators: Sequence[Actuator]) -> tuple[float, ...]:
        """Return the inputs that act at time `t`, that of the newest told or later."""
        if not self._told:
            return self._nothing
        if all(actuator.perfect for actuator in actuators):
            return self._told[-1]
        if self._running is not None:
            return self.signal(t, actuators)(t)
        return tuple(
            clipped(self._told[max(self._after(t, actuator) - 1, 0)][i], actuator.range)
            for i, actuator in enumerate(actuators)
        )

    def signal(self, t: float, actuators: Sequence[Actuator]) -> Signal:
        """Return the inputs that act from time `t` to the next change."""
        running = self._running
        if running is None:
            held = self.acting(t, actuators)
            return lambda t: held
        if all(actuator.perfect for actuator in actuators):
            return running
        actuators = tuple(actuators)
        return lambda t: tuple(
            clipped(running(max(t - actuator.delay, 0.0))[i], actuator.range)
            for i, actuator in enumerate(actuators)
        )

    def next_change(self, t: float, actuators: Sequence[Actuator]) -> float:
        """Return the first time after `t` at which a late input begins to act, or infinity."""
        times = [math.inf]
        for actuator in actuators:
            after = self._after(t, actuator)
            if self._running is None and actuator.delay and after < len(self._times):
                times.append(self._times[after] + actuator.delay)
        return min(times)

    def _after(self, t: float, actuator: Actuator) -> int:
        """Return the number of inputs told that act at `t` or have acted before."""
        return bisect.bisect_right(self._times, t - actuator.delay + SAME_TIME)
