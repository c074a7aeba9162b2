"""Estimates, which every observer returns: values by name, with their outcome and its reason."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum

import numpy as np

from obs_ros.core.typing import Array

QUANTILE = 1.96  # standard deviations on either side that hold 95 % of a normal distribution
SAME_TIME = 1e-6  # s: stamps since 1970 as floats are no finer
UNKNOWN = (np.nan, np.nan)  # the interval of what is not determined


class Outcome(StrEnum):
    """Outcome of an estimate, whose message says what to do about it."""

    CONVERGED = 'converged'
    APPROXIMATE = 'approximate'
    DEADLINE = 'deadline'
    NOT_IDENTIFIABLE = 'not_identifiable'
    AT_BOUND = 'at_bound'
    MODEL_MISMATCH = 'model_mismatch'
    TOO_FEW_SAMPLES = 'too_few_samples'
    STALE_OUTPUT = 'stale_output'
    STALE_INPUT = 'stale_input'
    DIVERGED = 'diverged'


@dataclass(frozen=True)
class Jump:
    """Parameters that jumped at one time (s), by their sizes, with standard deviations.

    `sizes` and `stddev` are in the parameters' units, `time_stddev` in s. `alternatives` names the
    other sets of parameters that explain the window nearly as well; `probability` is that of this
    set, NaN where it is not known. A `new` jump has been shown by no earlier window; `stamp` is its
    time in ns where samples had stamps. A `retracted` one was announced before, and later windows
    speak against it: its sizes are 0, and it is `new` in the window that takes it back.
    """

    time: float
    time_stddev: float
    sizes: Mapping[str, float]
    stddev: Mapping[str, float]
    new: bool
    alternatives: tuple[str, ...] = ()
    stamp: int | None = None
    probability: float = np.nan
    retracted: bool = False

    def taken_back(self, probability: float) -> 'Jump':
        """Return the retraction of this one, which is as probable as that by now."""
        nothing = dict.fromkeys(self.sizes, 0.0)
        return Jump(
            self.time, self.time_stddev, nothing, nothing, new=True, stamp=self.stamp,
            probability=probability, retracted=True,
        )  # fmt: skip

    def takes_back(self, other: 'Jump') -> bool:
        """Whether this one retracts all of another that was announced: names, at its time."""
        same = abs(self.time - other.time) <= SAME_TIME
        return self.retracted and same and set(other.sizes) <= set(self.sizes)

    def __str__(self) -> str:
        """Say what jumped, by how much, and how probably; or that it is taken back."""
        if self.retracted:
            return f'jump at {self.time:.2f} s taken back: {", ".join(self.sizes)}'
        sizes = ', '.join(
            f'{name} {size:+.3g} +- {2.0 * self.stddev[name]:.2g}'
            for name, size in self.sizes.items()
        )
        said = f'jump at {self.time:.2f} s +- {2.0 * self.time_stddev:.2g} s: {sizes}'
        return f'{said}, {probable}' if (probable := probability_words(self.probability)) else said


@dataclass(frozen=True, eq=False)
class Estimate:
    """States and parameters of one window, with their standard deviations and an outcome.

    `t0` and `t1` (s) are the window's first and last sample; `initial_state` belongs to t0, `state`
    and `parameters` to t1. `times` (K,) and `states` (K, n) are the estimated states at every
    sample, beside process noise smoothed by all of the window. `stddev` (of state and parameters)
    and `initial_stddev` are NaN where a standard deviation would mean nothing, and 0 for given
    values. `interval` are the two-sided 95 % intervals of state and parameters in their units, as
    (lower, upper): both NaN where not determined, and both the value where it is given. `weak`
    names the combinations that the window does not determine, `advice` the remedy; `jumps` lists
    the jumps inside the window, `drifting` the parameters that move too often to have jumped.
    `covariance` (n + q, n + q) is the joint one of `state` and `parameters` in their units, and
    empty where none is known; where `stddev` calls a value not determined, it still has the
    linearised one. `noise` are the outputs' standard deviations. `walks` are the process noise that
    explains the window, by state and parameter, in their units per root of a second; empty where
    none does. `cost` is the minimum of the search. `output_rms` is the residual's root mean square
    by output, in its unit; `residual_rms` that over all measured values, meaningful where the
    outputs share a unit. `innovation` is the newest output, as measured less as predicted one step
    ahead, with its standard deviation `innovation_stddev`, of observers that go sample by sample.
    `stamp` is the newest output's stamp in ns where samples had one. `figures` are further ones of
    the observer: gains, a generation, a best fitness. `last_outlier` tells which sample was left
    out last: output, time and size. Without a usable solution (`usable` is False) the values are
    NaN.
    """

    parameters: Mapping[str, float]
    initial_state: Mapping[str, float]
    state: Mapping[str, float]
    stddev: Mapping[str, float]
    outcome: Outcome
    message: str
    t0: float
    t1: float
    cost: float = np.nan
    residual_rms: float = np.nan
    output_rms: Mapping[str, float] = field(default_factory=dict)
    initial_stddev: Mapping[str, float] = field(default_factory=dict)
    interval: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    covariance: Array = field(default_factory=lambda: np.empty((0, 0)), repr=False)
    noise: Mapping[str, float] = field(default_factory=dict)
    walks: Mapping[str, float] = field(default_factory=dict)
    weak: tuple[str, ...] = ()
    advice: str = ''
    jumps: tuple[Jump, ...] = ()
    drifting: tuple[str, ...] = ()
    last_outlier: str = ''
    evaluations: int = 0
    solve_time: float = 0.0
    times: Array = field(default_factory=lambda: np.empty(0), repr=False)
    states: Array = field(default_factory=lambda: np.empty((0, 0)), repr=False)
    stamp: int | None = None
    innovation: Mapping[str, float] = field(default_factory=dict)
    innovation_stddev: Mapping[str, float] = field(default_factory=dict)
    figures: Mapping[str, float] = field(default_factory=dict)

    @property
    def usable(self) -> bool:
        """Whether every state and parameter is a finite number."""
        values = (*self.parameters.values(), *self.initial_state.values(), *self.state.values())
        return bool(np.isfinite(values).all())

    def without_deviations(self) -> 'Estimate':
        """Return the same values with nothing said of how far they hold."""
        return replace(
            self,
            stddev=dict.fromkeys(self.stddev, np.nan),
            initial_stddev=dict.fromkeys(self.initial_stddev, np.nan),
            interval=dict.fromkeys(self.interval, UNKNOWN),
            covariance=np.empty((0, 0)),
        )


def probability_words(probability: float) -> str:
    """Return a probability in words, '' where it is not known (NaN)."""
    if np.isnan(probability):
        return ''
    # Rounded up to 1 it would be certain.
    return f'probability {"> 0.99" if probability > 0.99 else f"{probability:.2f}"}'


def normal_intervals(
    values: Mapping[str, float], stddev: Mapping[str, float]
) -> dict[str, tuple[float, float]]:
    """Return 95 % intervals of normal distributions with these means and standard deviations.

    They are by the names of `stddev`; what has none, NaN, has no interval.
    """
    found = {}
    for name, deviation in stddev.items():
        value, half = values[name], QUANTILE * deviation
        found[name] = (value - half, value + half)
    return found
