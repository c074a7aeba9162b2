"""Time constants of a model, and the window that they suggest.

The poles of df/dx tell how fast a plant moves: one that decays has the time constant 1 / |pole|, an
oscillation the period 2 pi / |imaginary part|. The ratio of the slowest to the fastest is the
stiffness (Hairer & Wanner 1996, section IV.1). A pole of a discrete model counts as its logarithm
over the period.
"""

import math
from dataclasses import dataclass

import numpy as np

from obs_ros.core.linear_algebra import poles
from obs_ros.core.model import Model, inside
from obs_ros.core.typing import Array
from obs_ros.integration.time_scales import jacobians

SCALES = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)  # to which proposals are rounded


@dataclass(frozen=True)
class MotionSettings:
    """Limits in reading poles, and lengths of windows.

    - `still`: rate, of the fastest, below which a pole is rounding, or an integrator's;
    - `longest`: time constant, in lengths of a rollout, beyond which a pole stands still in it;
    - `settling`: time constants of the slowest decay in a window: 5 % is left at its end;
    - `swings`: periods of the slowest oscillation in a window.
    """

    still: float = 1e-8
    longest: float = 1000.0
    settling: float = 3.0
    swings: float = 2.0


MOTION = MotionSettings()


@dataclass(frozen=True)
class Motion:
    """Time constants at some points of a model, in s; NaN where all stands still.

    `fastest` (B,) and `slowest` (B,) at each of them, and how long a window they ask for (B,).
    """

    fastest: Array
    slowest: Array
    duration: Array

    @property
    def wanted(self) -> float:
        """Length (s) of a window for most of the points; NaN where none asks for any."""
        known = self.duration[np.isfinite(self.duration)]
        return rounded(float(np.median(known))) if known.size else math.nan

    @property
    def longest(self) -> float:
        """Length (s) of a window for all of the points; NaN where none asks for any."""
        return float(self.duration[np.isfinite(self.duration)].max(initial=0.0)) or math.nan

    def __str__(self) -> str:
        """Say how fast and how slow the model moves, and the ratio of both."""
        known = np.isfinite(self.fastest)
        if not known.any():
            return 'none: all states only add up what they get'
        fastest, slowest = self.fastest[known].min(), self.slowest[known].max()
        if slowest < 1.005 * fastest:
            return f'{_seconds(fastest)} s'
        ratio = f'stiffness {_seconds(slowest / fastest)}'
        return f'{_seconds(fastest)} s to {_seconds(slowest)} s ({ratio})'


def motion_of(
    model: Model,
    x: Array,
    p: Array,
    length: float = math.inf,
    settings: MotionSettings = MOTION,
) -> Motion:
    """Return the time constants at states x (n, B) with p (q, B), inputs at nominal values.

    `length` (s) is that of the rollout that the states are from.
    """
    found = np.full((3, x.shape[1]), np.nan)
    u = np.array([inside(v) for v in model.inputs])
    for k, A in enumerate(jacobians(model, 0.0, x, u, p)):
        own = poles(A)
        if model.period is not None:  # those of the continuous plant with the same nodes
            own = np.log(own[np.abs(own) > settings.still].astype(complex)) / model.period
        rates = np.abs(own)
        least = max(settings.still * rates.max(initial=0.0), 1.0 / (settings.longest * length))
        moving = rates > least
        if not (moving.any() and np.isfinite(rates).all()):
            continue
        own, rates = own[moving], rates[moving]
        swinging = np.abs(own.imag) > np.abs(own.real)
        lasting = np.where(
            swinging, settings.swings * 2.0 * np.pi / np.maximum(np.abs(own.imag), 1e-300),
            settings.settling / rates,
        )  # fmt: skip
        found[:, k] = 1.0 / rates.max(), 1.0 / rates.min(), lasting.max()
    return Motion(*found)


def rounded(seconds: float, *, down: bool = False) -> float:
    """Return a round number of s near this one, or below it."""
    power = 10.0 ** math.floor(math.log10(seconds))
    fitting = [scale for scale in SCALES if not down or scale * power <= seconds * 1.001]
    nearest = min(fitting, key=lambda scale: abs(math.log(scale * power / seconds)))
    return float(f'{nearest * power:.6g}')


def _seconds(value: float) -> str:
    """Return a number of two digits, without an exponent where that is short."""
    return f'{float(f"{value:.2g}"):.6g}'
