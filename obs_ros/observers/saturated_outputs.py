"""Outputs as an observer that goes sample by sample may take them from saturated sensors."""

import numpy as np

from obs_ros.core.model import Model
from obs_ros.core.saturation import contradicting, ends_of, has_range
from obs_ros.core.typing import Array
from obs_ros.integration.path import LANES, Path
from obs_ros.integration.stepper import Stepper


class SaturatedOutputs:
    """Takes a saturated sensor for silent where the model itself is at that end or beyond.

    Elsewhere the sensor shows the end of its range, and contradicts the model by as much as that is
    inside. The model's outputs are those of a rollout from the estimate at the output before; they
    are `needed` of models with ranges, at saturated sensors only. With `stand_in` they stand for
    what a silent sensor leaves open, for observers that cannot do without: the model is then right
    by itself.
    """

    def __init__(self, model: Model, *, stand_in: bool = False) -> None:
        self._model, self._stand_in = model, stand_in
        self.needed = has_range(model.outputs)
        self.silent = False  # whether the last outputs had a sensor that left something open

    def told(self, y: Array, t: float, path: Path, x: Array, p: Array, stepper: Stepper) -> Array:
        """Return measured outputs y (r,) at t (s) as far as they say something; NaN elsewhere.

        The path leads there from the states x (n,), with parameters p (q,).
        """
        ends = ends_of(self._model.outputs, y)
        self.silent = False
        if ends is None or not ends.saturated.any():
            return y
        states, parameters = (np.repeat(v[:, None], LANES, axis=1) for v in (x, p))
        outputs = np.empty((y.size, LANES))
        stepper.propagate(path, states, parameters)
        stepper.measure(t, path.u[path.pieces], states, parameters, outputs)
        told = contradicting(self._model.outputs, y, outputs[:, 0])
        silent = ends.saturated & np.isnan(told)
        self.silent = bool(silent.any())
        return np.where(silent, outputs[:, 0], told) if self._stand_in else told
