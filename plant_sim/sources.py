"""Inputs that are no function of time alone: controllers, which answer the outputs, and noise."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from plant_sim.signals import Signal

# The inputs from time t (s) on, given the outputs y measured then. Asked once per sample, in order:
# it may remember the earlier ones.
Drive = Callable[[float, tuple[float, ...]], tuple[float, ...]]


@runtime_checkable
class Source(Protocol):
    """Maker of the inputs of a run; no two runs share any memory."""

    def start(self, period: float, seed: int) -> Drive:
        """Return the inputs of a new run with a sample every `period` s."""
        ...


def start(inputs: Signal | Source, period: float, seed: int) -> Drive:
    """Return the inputs of a new run, open loop where they are a plain signal."""
    if isinstance(inputs, Source):
        return inputs.start(period, seed)
    return lambda t, y: inputs(t)


@dataclass(frozen=True)
class PIController:
    """A discrete proportional-integral controller of one output by one input.

    e(k) = y(k) - r(k) and u(k) = kp e(k) + ki T (e(0) + ... + e(k)): the input rises with the
    output, as a throttle that is opened to let a pressure fall.
    """

    kp: float
    ki: float
    reference: Signal

    def start(self, period: float, seed: int) -> Drive:
        """Return the controller, its integral at 0; it refuses several outputs by ValueError."""
        integral = 0.0

        def control(t: float, y: tuple[float, ...]) -> tuple[float, ...]:
            nonlocal integral
            if len(y) != 1:
                raise ValueError(f'a PI controller answers one output, not {len(y)}')
            error = y[0] - self.reference(t)[0]
            integral += error * period
            return (self.kp * error + self.ki * integral,)

        return control


@dataclass(frozen=True)
class WhiteGaussian:
    """One input drawn anew at every sample; other seeds give other inputs."""

    mean: float
    deviation: float

    def start(self, period: float, seed: int) -> Drive:
        """Return the draws of that seed, which are not those of the measurement noise."""
        random = np.random.default_rng((seed, 1))
        return lambda t, y: (float(random.normal(self.mean, self.deviation)),)
