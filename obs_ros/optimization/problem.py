"""The problem that a search method solves: costs of points of the unit box."""

from typing import Protocol

from obs_ros.core.typing import Array, IntArray


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


class Problem(Linearised, Protocol):
    """All that a search method may ask; the costs are the squares if `is_least_squares`.

    Every method gets one of these, its own costs or those with a prior's squares added.
    """

    @property
    def dimension(self) -> int:
        """Number of unknowns, d."""

    @property
    def is_least_squares(self) -> bool:
        """Whether the costs are sums of squared residuals along the nodes."""

    @property
    def nodes(self) -> int:
        """Number of nodes, K."""

    @property
    def signal(self) -> float:
        """Mean square of the measured values about their means, in units of the residuals."""

    def costs(self, z: Array, nodes: int | None = None) -> Array:
        """Return the costs (B,) of points z (B, d) over a prefix of the window; +inf: none."""

    def block_squares(self, z: Array, prefixes: IntArray) -> Array:
        """Return squares (G, B), summed between rising numbers of nodes (G,)."""

    def residuals(self, z: Array) -> Array:
        """Return the residuals (K, r) of one point (d,); NaN where nothing was measured."""
