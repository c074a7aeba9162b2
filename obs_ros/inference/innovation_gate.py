"""The gate through which innovations pass: outputs far from what was expected correct nothing.

An innovation e with standard deviation s passes if |e| / s is at most the limit, times the typical
size of this ratio where that is above 1: noise that was given too small, or a model that is only
roughly right, must not shut the gate. After a run of rejections the gate opens: then it is not the
output that is wrong.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from obs_ros.core.jit import accelerated
from obs_ros.core.typing import Array, IntArray
from obs_ros.inference.outliers import NORMAL_MEDIAN

REJECTED, PASSED, REOPENED = 0, 1, 2
RATE = 0.02  # by which a sample moves the typical size: it takes 35 to double


@dataclass(frozen=True)
class InnovationGateSettings:
    """Limits of a gate.

    - `limit`: standard deviations beyond which an innovation corrects nothing, as an outlier of a
      window;
    - `patience`: rejections in a row, after which the next one passes: more are no burst.
    """

    limit: float = 5.0
    patience: int = 10


INNOVATION_GATE = InnovationGateSettings()


class Gate(NamedTuple):
    """A gate for r outputs: its settings, and what it remembers of each."""

    limit: float  # standard deviations; 0: everything passes
    patience: int  # rejections in a row, after which the gate opens
    first: int  # innovations of each output that pass whatever they are
    typical: Array  # (r,) size of innovations, in standard deviations
    seen: IntArray  # (r,) innovations so far
    run: IntArray  # (r,) rejections in a row
    rejected: Array  # (r,) size of the newest innovation, if it was rejected; else 0

    @classmethod
    def of(cls, outputs: int, limit: float, patience: int, first: int = 0) -> 'Gate':
        """Return a gate that has seen nothing yet."""
        gate = cls(
            limit, patience, first, np.empty(outputs), np.empty(outputs, dtype=np.int64),
            np.empty(outputs, dtype=np.int64), np.empty(outputs),
        )  # fmt: skip
        gate.clear()
        return gate

    def clear(self) -> None:
        """Forget all innovations."""
        self.typical[:] = 1.0
        self.seen[:] = self.run[:] = 0
        self.rejected[:] = 0.0


@accelerated
def judged(gate: Gate, i: int, size: float) -> int:
    """Return whether an innovation of output i, in its standard deviations, may correct anything.

    REOPENED stands for one that passes because so many before it did not.
    """
    gate.rejected[i] = 0.0
    if gate.limit == 0.0 or math.isnan(size):
        return PASSED
    gate.seen[i] += 1
    if gate.seen[i] <= gate.first:
        gate.typical[i] = max(gate.typical[i], size)
        return PASSED
    passed = size <= gate.limit * max(gate.typical[i], 1.0)
    grows = size > NORMAL_MEDIAN * gate.typical[i]
    gate.typical[i] *= 1.0 + RATE if grows else 1.0 - RATE
    if passed:
        gate.run[i] = 0
        return PASSED
    gate.run[i] += 1
    if gate.run[i] <= gate.patience:
        gate.rejected[i] = size
        return REJECTED
    gate.run[i] = 0
    return REOPENED
