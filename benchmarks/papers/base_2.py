"""The standard binary coding of Goldberg 1989, which both genetic papers name beside base 10."""

from dataclasses import dataclass

import numpy as np

from obs_ros.core.typing import Array
from obs_ros.optimization.decimal_coding import Genes


@dataclass(frozen=True)
class Base2:
    """So many bits for each trait, from the lower to the upper end of its range.

    lower, upper (T,). Genes are (N, T, bits) of 0 and 1, the most significant first; no string is
    out of its range.
    """

    lower: Array
    upper: Array
    bits: int

    def first_population(self, draws: Array) -> Genes:
        """Return chromosomes uniform in their ranges from draws (N, T) uniform on [0, 1)."""
        whole = (draws * 2.0**self.bits).astype(np.int64)
        return ((whole[:, :, None] >> np.arange(self.bits)[::-1]) & 1).astype(np.int8)

    def decode(self, genes: Genes) -> Array:
        """Read values (N, T)."""
        whole = genes.astype(np.int64) @ (1 << np.arange(self.bits)[::-1])
        return self.lower + (self.upper - self.lower) * (whole / (2.0**self.bits - 1.0))
