"""Boxes of unknowns, and how places in them become values: on a linear or a log scale."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from obs_ros.core.typing import Array, IntArray

EVERY = slice(None)
TINY = float(np.finfo(np.float64).tiny)


@dataclass(frozen=True)
class Scale:
    """The boxes of d unknowns, in their units, and how places z in [0, 1] become values.

    On a linear scale the value is lower + z (upper - lower). On a log scale, where growth is
    ln(upper / lower) instead of 0, it is lower exp(z growth): equal steps are equal ratios.
    lower, upper and growth have shape (d,).
    """

    lower: Array
    upper: Array
    growth: Array

    @cached_property
    def width(self) -> Array:
        """Widths (d,) of the boxes."""
        return self.upper - self.lower

    @cached_property
    def logarithmic(self) -> bool:
        """Whether any unknown is on a log scale."""
        return bool((self.growth > 0.0).any())

    @cached_property
    def unit(self) -> Array:
        """Widths (d,) of the boxes, on a log scale those of the logarithms."""
        return np.where(self.growth > 0.0, self.growth, self.width)

    def values(self, z: Array, i: int | slice | IntArray = EVERY) -> Array:
        """Return the values of unknown i at places z of its box, or of all at points z (..., d)."""
        linear = self.lower[i] + z * self.width[i]
        if not self.logarithmic:
            return np.asarray(linear)
        # Rounding must not leave the upper bound behind.
        powers = np.minimum(self.lower[i] * np.exp(z * self.growth[i]), self.upper[i])
        return np.where(self.growth[i] > 0.0, powers, linear)

    def slopes(self, z: Array, i: int | slice | IntArray = EVERY) -> Array:
        """Return d value / d z there, in the unknowns' units per box."""
        if not self.logarithmic:
            return np.broadcast_to(self.width[i], np.shape(z))
        return np.where(self.growth[i] > 0.0, self.growth[i] * self.values(z, i), self.width[i])

    def places(self, values: Array) -> Array:
        """Return the points (..., d) of the unit box at which the unknowns have these values."""
        return self.places_of(values, 0)

    def places_of(self, values: Array, first: int) -> Array:
        """Return the places (..., m) of the unknowns from the `first` on with these values."""
        some = slice(first, first + values.shape[-1])
        lower, growth = self.lower[some], self.growth[some]
        if not self.logarithmic:
            return np.asarray((values - lower) / self.width[some])
        log = growth > 0.0
        ratio = np.where(log, np.maximum(values, TINY) / np.where(log, lower, 1.0), 1.0)
        logarithmic = np.log(ratio) / np.where(log, growth, 1.0)
        return np.where(log, logarithmic, (values - lower) / self.width[some])
