"""What a search sees of its problem: points of the unit box and their costs."""

from typing import Protocol

from obs_ros.core.typing import Array, IntArray


class Problem(Protocol):
    """Costs over the unit box; +inf for a point that has none."""

    @property
    def dimension(self) -> int:
        """Number of unknowns, d."""

    @property
    def is_least_squares(self) -> bool:
        """Whether the costs are sums of squares, as of a `LeastSquares`."""

    def costs(self, z: Array, nodes: int | None = None) -> Array:
        """Return the costs (B,) of points z (B, d), over a prefix of the window."""


class Linearised(Protocol):
    """Squared residuals along the nodes of a window, with their derivatives."""

    @property
    def limits(self) -> Array:
        """Least and largest values of z (2, d): 0 and 1, or infinite where there is no bound."""

    def count(self, nodes: int) -> int:
        """Return the number of residuals at the first `nodes` nodes."""

    def floor(self, nodes: int) -> float:
        """Return the sum of squares that rounding leaves at a perfect fit."""

    def linearise(self, z: Array, h: Array, nodes: int) -> tuple[Array, Array, Array]:
        """Return squares (P,), J'r (P, d) and J'J (P, d, d) at points z (P, d), steps h (P, d)."""


class LeastSquares(Problem, Linearised, Protocol):
    """A problem whose cost is a sum of squared residuals along the nodes of a window."""

    @property
    def nodes(self) -> int:
        """Number of nodes, K."""

    @property
    def signal(self) -> float:
        """Mean square of the measured values about their means, in units of the residuals."""

    def block_squares(self, z: Array, prefixes: IntArray) -> Array:
        """Return squares (G, B) summed between rising numbers of nodes (G,)."""

    def residuals(self, z: Array) -> Array:
        """Return the residuals (K, r) of one point (d,); NaN where nothing was measured."""
