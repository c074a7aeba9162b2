"""Outputs admitted to observers through the gate of `inference.innovation_gate`."""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from obs_ros.core.model import Variable, names
from obs_ros.core.periods import periods, shortest
from obs_ros.core.typing import Array
from obs_ros.inference.innovation_gate import REJECTED, Gate, judged
from obs_ros.inference.outlier_count import OutlierCount
from obs_ros.inference.outliers import OUTLIERS
from obs_ros.integration.path import LANES, Path
from obs_ros.integration.stepper import Stepper
from obs_ros.observers.settings import Settings


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
