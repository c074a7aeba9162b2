"""The past of a run: what the plant did between samples, integrated again where it is asked for."""

import bisect
from collections.abc import Sequence
from typing import NamedTuple

from obs_ros.core.model import Model
from plant_sim.plant import Plant, State
from plant_sim.signals import Signal

SAME_TIME = 1e-9  # s; times that differ by less are one


class Stretch(NamedTuple):
    """A part of a run from time t (s) and state x on, under one signal u and parameters p.

    `following` is the next state of a discrete model, where that is settled.
    """

    t: float
    x: State
    u: Signal
    p: Sequence[float]
    following: State | None = None
    stiff: bool = False


class Past:
    """Stretches of a run that follow each other; each lasts until the next one begins."""

    def __init__(self, model: Model) -> None:
        self._model = model
        self._stretches: list[Stretch] = []

    def add(self, stretch: Stretch) -> None:
        """Take the newest stretch."""
        self._stretches.append(stretch)

    def forget(self, before: float) -> None:
        """Drop stretches that have ended before a time (s)."""
        del self._stretches[: max(self._index(before), 0)]

    def clear(self) -> None:
        """Forget everything."""
        self._stretches.clear()

    def outputs(self, t: float) -> State | None:
        """Return the noise-free outputs at time `t` (s), None where nothing is known.

        Before the first stretch they are those at its start.
        """
        if not self._stretches:
            return None
        stretch = self._stretches[max(self._index(t), 0)]
        plant = Plant(
            self._model, stretch.x, start=stretch.t, following=stretch.following,
            stiff=stretch.stiff,
        )  # fmt: skip
        plant.advance(max(t, stretch.t), stretch.u, stretch.p)
        return plant.output(stretch.u(plant.t), stretch.p)

    def _index(self, t: float) -> int:
        """Return the place of the stretch that `t` lies in, -1 before all of them."""
        return bisect.bisect_right(self._stretches, t + SAME_TIME, key=lambda s: s.t) - 1
