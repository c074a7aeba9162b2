"""Estimates, which every observer returns: values by name, with their outcome and its reason."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np

from obs_ros.core.typing import Array


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
    other sets of parameters that explain the window nearly as well. A `new` jump has been shown by
    no earlier window; `stamp` is its time in ns where samples had stamps.
    """

    time: float
    time_stddev: float
    sizes: Mapping[str, float]
    stddev: Mapping[str, float]
    new: bool
    alternatives: tuple[str, ...] = ()
    stamp: int | None = None

    def __str__(self) -> str:
        """Say what jumped."""
        sizes = ', '.join(
            f'{name} {size:+.3g} +- {2.0 * self.stddev[name]:.2g}'
            for name, size in self.sizes.items()
        )
        return f'jump at {self.time:.2f} s +- {2.0 * self.time_stddev:.2g} s: {sizes}'


@dataclass(frozen=True, eq=False)
class Estimate:
    """States and parameters of one window, with their standard deviations and an outcome.

    `t0` and `t1` (s) are the window's first and last sample; `initial_state` belongs to t0, `state`
    and `parameters` to t1. `times` (K,) and `states` (K, n) are the estimated states at every
    sample, beside process noise smoothed by all of the window. `stddev` (of state and parameters)
    and `initial_stddev` are NaN where a standard deviation would mean nothing, and 0 for given
    values. `weak` names the combinations that the window does not determine, `advice` the remedy;
    `jumps` lists the jumps inside the window, `drifting` the parameters that move too often
    to have jumped.
    `covariance` (n + q, n + q) is the joint one of `state` and `parameters` in their units, and
    empty where none is known; where `stddev` calls a value not determined, it still has the
    linearised one. `noise` are the outputs' standard deviations. `walks` are the process noise that
    explains the window, by state and parameter, in their units per root of a second; empty where
    none does. `cost` is the minimum of the search. `output_rms` is the residual's root mean square
    by output, in its unit; `residual_rms` that over all measured values, meaningful where the
    outputs share a unit. `innovation` is the newest output, as measured less as predicted one step
    ahead, with its standard deviation `innovation_stddev`, of observers that go sample by sample.
    `stamp` is the newest output's stamp in ns where samples had one. `figures` are further ones of
    the observer: gains, a generation, a best fitness. Without a usable solution (`usable` is False)
    the values are NaN.
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
    covariance: Array = field(default_factory=lambda: np.empty((0, 0)), repr=False)
    noise: Mapping[str, float] = field(default_factory=dict)
    walks: Mapping[str, float] = field(default_factory=dict)
    weak: tuple[str, ...] = ()
    advice: str = ''
    jumps: tuple[Jump, ...] = ()
    drifting: tuple[str, ...] = ()
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
