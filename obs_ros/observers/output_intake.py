"""The way of outputs into an observer that goes sample by sample."""

from collections.abc import Callable, Mapping
from functools import cache
from typing import NamedTuple

import numpy as np

from obs_ros.core.model import Model
from obs_ros.core.typing import Array
from obs_ros.inference.innovation_gate import Gate
from obs_ros.observers.continuous_outputs import ContinuousOutputs
from obs_ros.observers.innovation_gate import Admission
from obs_ros.observers.saturated_outputs import SaturatedOutputs


class Instant(NamedTuple):
    """An output as an observer meets it: y (r,), NaN = not measured, and the inputs u (m,) then.

    u are the inputs known when the output comes: one with the same stamp that comes after it is in
    force from there on, but not in this u.
    """

    stamp: int  # ns
    t: float  # s
    y: Array
    u: Array


class OutputIntake:
    """Takes outputs without wraps, as far as saturated sensors tell, and through the gate.

    `filled`: the observer cannot do without a value, so that the model stands in for one that is
    missing. The outputs that the model expects cost a rollout: they are asked for once at most.
    """

    def __init__(self, model: Model, admission: Admission, *, filled: bool) -> None:
        self._admission, self._filled = admission, filled
        self._saturated = SaturatedOutputs(model, stand_in=filled)
        self._continuous = ContinuousOutputs(model)

    @property
    def gate(self) -> Gate:
        """The gate, for an observer that judges by the covariance that it has."""
        return self._admission.gate

    @property
    def silent(self) -> bool:
        """Whether the last outputs had a saturated sensor that left something open."""
        return self._saturated.silent

    @property
    def last_outlier(self) -> str:
        """The last output that was rejected, in words."""
        return self._admission.last

    @property
    def counts(self) -> Mapping[str, int]:
        """Outputs rejected so far, by reason."""
        return self._admission.counts

    def begin(self, expected: Array) -> None:
        """Start from the outputs (r,) that the observer expects first."""
        self._continuous.begin(expected)

    def taken(self, y: Array, expected: Callable[[], Array], *, first: bool) -> Array:
        """Return outputs (r,) as they may be taken; NaN = not measured. The first ones pass."""
        y = self._continuous.taken(y)
        judged = self._admission.judges and not first
        if self._saturated.needed:
            expected = cache(expected)
            y = self._saturated.told(y, expected)
        if judged:
            self._admission.admit(y, expected(), filled=self._filled)
        return y

    def note(self, t: float, y: Array, innovation: Array, *, first: bool) -> None:
        """Take note of the outputs (r,) taken at time t (s), and of their innovations (r,).

        These become those that were judged where some were rejected.
        """
        if not first and self._admission.note(t) and self._admission.judges:
            innovation[:] = self._admission.innovation
        self._continuous.note(y, innovation)

    def clear(self) -> None:
        """Forget all outputs, but not the counts."""
        self._admission.clear()


def outputs_at(model: Model, t: float, u: Array, x: Array, p: Array) -> Array:
    """Return the outputs (r,) of a model at time t (s), inputs u (m,), states x (n,), p (q,)."""
    return np.array(model.output(t, tuple(x), tuple(u), tuple(p)))
