"""Inputs that act late: their paths shifted, as the straight line in every step that does the same.

Held inputs jump, so that what they do within a step depends on how late they are without any
derivative where a jump meets a node. Over a step from a to b the path u is therefore replaced by
the line of the same integral and first moment,

    m0 = int u ds,    m1 = int (s - (a + b) / 2) u ds,
    u(a + s) = m0 / h + 12 m1 (s - h / 2) / h^3,

its projection on straight lines, which moves a linear plant as far but for terms of third order in
h = b - a, and is continuous in the shift.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from obs_ros.core.typing import Array


@dataclass(frozen=True, eq=False)
class InputPath:
    """The inputs of a window and before it, as they were sent.

    From t[k] s on, of t (L,), they are u[k] + s slope[k] after s seconds, with u and slope (L, m),
    and before the first as at it.
    """

    t: Array
    u: Array
    slope: Array

    @cached_property
    def _integrals(self) -> tuple[Array, Array, Array, Array]:
        """Values less their means (L, m), the means (m,), first and second integrals (L, m)."""
        mean = self.u.mean(axis=0)
        off, slope = self.u - mean, self.slope
        h = np.diff(self.t)[:, None]
        first, second = np.zeros_like(off), np.zeros_like(off)
        np.cumsum(h * (off[:-1] + 0.5 * h * slope[:-1]), axis=0, out=first[1:])
        parts = h * (first[:-1] + h * (0.5 * off[:-1] + h / 6.0 * slope[:-1]))
        np.cumsum(parts, axis=0, out=second[1:])
        return off, mean, first, second

    def shifted(self, column: int, t: Array, delays: Array) -> tuple[Array, Array]:
        """Return value and slope (F, B) of one input from each of the times t (F,) to the next.

        The input acts `delays` (B,) s late. The last time stands for a step as long as the one
        before.
        """
        ends = np.append(t, 2.0 * t[-1] - t[-2])
        first, second = self._integrated(column, ends[:, None] - delays)
        h = np.diff(ends)[:, None]
        whole, mean = np.diff(first, axis=0), self._integrals[1][column]
        moment = 0.5 * h * (first[1:] + first[:-1]) - np.diff(second, axis=0)
        slope = 12.0 * moment / h**3
        return mean + whole / h - 0.5 * h * slope, slope

    def _integrated(self, column: int, at: Array) -> tuple[Array, Array]:
        """Return first and second integral of an input, less its mean, at any times."""
        off, _, first, second = (part[..., column] for part in self._integrals)
        k = np.maximum(np.searchsorted(self.t, at, side='right') - 1, 0)
        s = at - self.t[k]
        slope = np.where(s < 0.0, 0.0, self.slope[k, column])
        value, before = off[k], first[k]
        once = before + s * (value + 0.5 * s * slope)
        return once, second[k] + s * (before + s * (0.5 * value + s / 6.0 * slope))
