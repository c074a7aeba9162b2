"""Outputs as an observer that goes sample by sample may take them from saturated sensors."""

from collections.abc import Callable

import numpy as np

from obs_ros.core.model import Model
from obs_ros.core.saturation import contradicting, ends_of, has_range
from obs_ros.core.typing import Array


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

    def told(self, y: Array, expected: Callable[[], Array]) -> Array:
        """Return measured outputs y (r,) as far as they say something; NaN elsewhere.

        `expected` returns the outputs (r,) by a rollout.
        """
        ends = ends_of(self._model.outputs, y)
        self.silent = False
        if ends is None or not ends.saturated.any():
            return y
        outputs = expected()
        told = contradicting(self._model.outputs, y, outputs)
        silent = ends.saturated & np.isnan(told)
        self.silent = bool(silent.any())
        return np.where(silent, outputs, told) if self._stand_in else told
