"""The gate through which innovations pass: outputs far from what was expected correct nothing.

An innovation e with standard deviation s passes if |e| / s is at most the limit, times the typical
size of this ratio where that is above 1: noise that was given too small, or a model that is only
roughly right, must not shut the gate. After a run of rejections the gate opens: then it is not the
output that is wrong.
"""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from obs_ros.core.jit import accelerated
from obs_ros.core.model import Variable, names
from obs_ros.core.periods import periods, shortest
from obs_ros.core.typing import Array, IntArray
from obs_ros.inference.outlier_count import OutlierCount
from obs_ros.inference.outliers import NORMAL_MEDIAN, OUTLIERS
from obs_ros.integration.path import LANES, Path
from obs_ros.integration.stepper import Stepper
from obs_ros.observers.settings import Settings

REJECTED, PASSED, REOPENED = 0, 1, 2
RATE = 0.02  # by which a sample moves the typical size: it takes 35 to double


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


class Admission:
    """Admits the outputs of an observer through a gate, and counts those that it rejects.

    `noise` are the standard deviations (r,) that sizes are in, NaN for outputs that always pass. An
    observer that judges by its covariance gives none, and uses the gate itself. Without one, errors
    of the state are not known: then the size is that of the change since the innovation that passed
    last, if this is less, as such errors change slowly.
    """

    def __init__(self, gate: Gate, outputs: Sequence[Variable], noise: Array) -> None:
        self.gate = gate
        self.last = ''  # the last one rejected, in words
        self.counts = OutlierCount(names(outputs)).counts
        self.judges = gate.limit > 0.0 and not np.isnan(noise).all()
        self.innovation = np.full(len(noise), math.nan)  # (r,) the newest ones
        self._outputs, self._noise, self._period = names(outputs), noise, periods(outputs)
        self._passed = self.innovation.copy()  # those that passed last

    def clear(self) -> None:
        """Forget all outputs, but not the counts."""
        self.gate.clear()
        self._passed[:] = math.nan

    @classmethod
    def of(
        cls, outputs: Sequence[Variable], settings: Settings, noise: Mapping[str, float]
    ) -> 'Admission':
        """Return that of an observer with some settings, by the noise of outputs by name.

        At the start, errors of the state pass.
        """
        limit, patience = settings.innovation_gate, settings.gate_patience
        gate = Gate.of(len(outputs), limit, patience, first=patience if noise else 0)
        return cls(gate, outputs, np.array([noise.get(v.name, math.nan) for v in outputs]))

    def admit(self, y: Array, expected: Array, *, filled: bool) -> None:
        """Turn outputs y (r,) too far from those expected (r,) to NaN, or to these if `filled`."""
        self.innovation[:] = shortest(y - expected, self._period)
        change = np.abs(shortest(self.innovation - self._passed, self._period))
        sizes = np.fmin(np.abs(self.innovation), change) / self._noise
        for i, size in enumerate(sizes.tolist()):
            if judged(self.gate, i, size) == REJECTED:
                y[i] = expected[i] if filled else math.nan
            elif not math.isnan(size):
                self._passed[i] = self.innovation[i]

    def note(self, t: float) -> bool:
        """Count the outputs at time t (s) that were rejected; return whether there is one."""
        sizes = self.gate.rejected.tolist()
        for i, size in enumerate(sizes):
            if size:
                name, run = self._outputs[i], int(self.gate.run[i])
                self.counts[f'outlier.{name}'] += 1
                self.counts[f'burst.{name}'] += run == OUTLIERS.few + 1
                self.last = f'{name} at {t:.2f} s ({size:.3g} sigma)'
        return any(sizes)


def expected_outputs(stepper: Stepper, path: Path, t: float, u: Array, x: Array, p: Array) -> Array:
    """Return the model's outputs (r,) at the end of a path, time t (s), from x (n,) and p (q,).

    u (m,) are the inputs there.
    """
    states, parameters = (np.repeat(values[:, None], LANES, axis=1) for values in (x, p))
    y = np.empty((len(stepper.model.outputs), LANES))
    stepper.propagate(path, states, parameters)
    stepper.measure(t, u, states, parameters, y)
    return y[:, 0]


def root_mean_square(innovations: Sequence[float]) -> float:
    """Return the root mean square of innovations that are numbers; NaN if none is."""
    squares = [value * value for value in innovations if not math.isnan(value)]
    return math.sqrt(sum(squares) / len(squares)) if squares else math.nan
