"""The cost that a search minimises: how far a candidate's outputs are from the measured ones."""

import functools
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal, Protocol, get_args

import numpy as np

from obs_ros.core.changes import replace
from obs_ros.core.jit import unhurried
from obs_ros.core.periods import shortest
from obs_ros.core.typing import Array, IntArray
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.integration.backends import Kernels
from obs_ros.integration.grid import Grid

Fitness = Literal['least_squares', 'euclidean', 'correlation']
FITNESSES: tuple[str, ...] = get_args(Fitness)
Loss = Literal['robust', 'squares']
LOSSES: tuple[str, ...] = get_args(Loss)

NOWHERE = np.empty((0, 0))  # precision of what is not known
ROUNDING = 1e-9  # relative residual that counts as none


class Normal(Protocol):
    """A normal distribution of the unknowns, in boxes."""

    @property
    def mean(self) -> Array:
        """Its mean (d,)."""

    @property
    def precision(self) -> Array:
        """The inverse (d, d) of its covariance."""


@dataclass
class Counter:
    """Candidates rolled out so far, over whatever part of a window."""

    candidates: int = 0


@dataclass
class Latest:
    """The rollout of a point over the whole window that was asked for last.

    An optimum is looked at from several sides, and in several scales of the outputs.
    """

    asked: tuple[Kernels, Grid, Unknowns, Array] | None = None  # with the point (d,)
    found: tuple[Array, Array] | None = None  # states (K, n) and outputs (K, r)

    def rollout(
        self, kernels: Kernels, grid: Grid, unknowns: Unknowns, z: Array
    ) -> tuple[Array, Array] | None:
        """Return states and outputs if they are those of what is asked now."""
        if self.asked is None:
            return None
        own_kernels, own_grid, own_unknowns, point = self.asked
        alike = kernels is own_kernels and unknowns is own_unknowns and grid.rolls_like(own_grid)
        return self.found if alike and np.array_equal(z, point) else None


@dataclass(frozen=True, eq=False)
class Objective:
    """Costs J(z) of points z (B, d) of the unit box, on one window.

    With residuals e_ki = (h_i(t_k, x_k, u_k, p) - y_ki) / s_i, s_i the scale of output i:

    - `least_squares`: J = sum_ki e_ki^2, -2 log likelihood of white Gaussian noise of deviation s_i
      but for a constant;
    - `euclidean` (Yang 2020, f_t1): J = sum_i sqrt(sum_k e_ki^2);
    - `correlation` (Yang 2020, f_t2, eq. 14): J = sum_i (1 - Pearson correlation of output i with
      its measurements), over the outputs that vary.

    A candidate that diverges costs +inf. Copies share their `counter` and the `latest` rollout.
    Raises ValueError for another fitness.
    """

    kernels: Kernels
    grid: Grid
    unknowns: Unknowns
    fitness: Fitness = 'least_squares'
    counter: Counter = field(default_factory=Counter)
    latest: Latest = field(default_factory=Latest)

    def __post_init__(self) -> None:
        if self.fitness not in FITNESSES:
            raise ValueError(f'fitness {self.fitness!r} is none of {", ".join(FITNESSES)}')

    def rescaled(self, factors: Array) -> 'Objective':
        """Return the same objective with the outputs' scales (r,) multiplied by `factors` (r,)."""
        return replace(self, grid=self.grid.rescaled(factors))

    @property
    def wraps(self) -> bool:
        """Whether residuals of some output go by the shortest way round its period."""
        return bool(self.grid.period.any())

    @property
    def straight(self) -> 'Objective':
        """The same objective with residuals as they are: for outputs free of wraps."""
        return replace(self, grid=self.grid.straight)

    @property
    def evaluations(self) -> int:
        """Number of candidates rolled out so far, by this objective and its copies."""
        return self.counter.candidates

    @property
    def dimension(self) -> int:
        """Number of unknowns, d."""
        return self.unknowns.dimension

    @property
    def is_least_squares(self) -> bool:
        """Whether the costs are sums of squared residuals."""
        return self.fitness == 'least_squares'

    @property
    def limits(self) -> Array:
        """Least and largest values of z (2, d): 0 and 1, or infinite where there is no bound."""
        return self.unknowns.limits

    @property
    def nodes(self) -> int:
        """Number of nodes of the window, K."""
        return self.grid.t.size

    def count(self, nodes: int) -> int:
        """Number of measured values at the first `nodes` nodes."""
        return self.grid.measured_values(nodes)

    @cached_property
    def signal(self) -> float:
        """Mean square of the measured outputs about their means, in units of their scales."""
        total = 0.0
        columns = zip(self.grid.weight.T, self.grid.y.T, self.grid.period, strict=True)
        for weight, y, period in columns:
            known = weight > 0.0
            if known.any():
                off = shortest(_centred(y[known]), period)
                total += float(np.sum((weight[known] * off) ** 2))
        return total / max(1, self.count(self.nodes))

    def floor(self, nodes: int) -> float:
        """Return the sum of squares that rounding leaves at a perfect fit."""
        scaled = self.grid.weight[:nodes] * self.grid.y[:nodes]
        return ROUNDING**2 * float(np.sum(scaled**2))

    def costs(self, z: Array, nodes: int | None = None) -> Array:
        """Return the cost (B,) of every point over the first `nodes` nodes (default: all)."""
        if self.fitness == 'correlation':
            return self._correlation_costs(z, nodes or self.nodes)
        squares = self._squares(z, np.array([nodes or self.nodes]))[0]
        if self.fitness == 'euclidean':
            squares = np.sqrt(squares)
        return _finite(squares.sum(axis=0))

    def block_squares(self, z: Array, prefixes: IntArray) -> Array:
        """Return squared residuals (G, B), summed between rising numbers of nodes (G,)."""
        return _finite(self._squares(z, prefixes).sum(axis=1))

    def linearise(
        self, z: Array, h: Array, nodes: int, prior: 'Normal | None' = None
    ) -> tuple[Array, Array, Array]:
        """Return squares (P,), gradients J'r (P, d) and J'J (P, d, d) at points z (P, d).

        The Jacobians J of the residuals r are forward differences with steps h (P, d), taken
        towards the middle of the box. The residuals of a `prior` are added to them.
        """
        starts, d = z.shape
        self.counter.candidates += starts * (d + 1)
        x0, p, steps = self.unknowns.perturbed(z, np.where(z > 0.5, -h, h))
        gram = self.kernels.grams(self.grid, nodes, x0, p, d + 1)
        known = (z[0], NOWHERE) if prior is None else (prior.mean, prior.precision)
        return _normal_equations(gram, steps, z, *known)

    def residuals(self, z: Array) -> Array:
        """Return scaled residuals (K, r) of one point (d,); NaN where nothing contradicts it."""
        return self.trajectory(z)[1]

    def trajectory(self, z: Array) -> tuple[Array, Array]:
        """Return states (K, n) and scaled residuals (K, r) of one point (d,); see `residuals`."""
        asked = self.kernels, self.grid, self.unknowns
        found = self.latest.rollout(*asked, z)
        if found is None:
            states, outputs = self._trajectories(z[None])
            # Copies: they may be kept for long, and no more than they.
            found = states[:, :, 0].copy(), outputs[:, :, 0].copy()
            self.latest.asked, self.latest.found = (*asked, z.copy()), found
        return found[0], self.grid.residuals(found[1])

    def _squares(self, z: Array, prefixes: IntArray) -> Array:
        self.counter.candidates += len(z)
        return self.kernels.squares(self.grid, prefixes, *self.unknowns.values(z))

    def _trajectories(self, z: Array) -> tuple[Array, Array]:
        self.counter.candidates += len(z)
        states, outputs = self.kernels.trajectories(self.grid, *self.unknowns.values(z))
        return states, self.grid.nearest(outputs)

    def _correlation_costs(self, z: Array, nodes: int) -> Array:
        outputs = self.grid.shown(self._trajectories(z)[1])[:nodes]
        cost = np.zeros(len(z))
        compared = 0
        with np.errstate(all='ignore'):
            for i in range(self.grid.y.shape[1]):
                known = self.grid.weight[:nodes, i] > 0
                measured = self.grid.y[:nodes][known, i]
                if measured.size < 2 or np.ptp(measured) == 0.0:
                    continue  # correlates with nothing
                measured = _centred(measured)
                candidate = _centred(outputs[known, i])
                norm = np.sqrt((candidate**2).sum(axis=0) * (measured**2).sum())
                cost += 1.0 - measured @ candidate / norm
                compared += 1
        return _finite(cost) if compared else np.full(len(z), np.inf)


@unhurried
def _normal_equations(
    gram: Array, steps: Array, z: Array, mean: Array, precision: Array
) -> tuple[Array, Array, Array]:
    """Return squares (P,), gradients (P, d) and Hessians (P, d, d) of Gram matrices.

    Of the precision (d, d), if not empty, and its mean the squares are added.
    """
    starts, d = z.shape
    squares, gradient = np.empty(starts), np.empty((starts, d))
    hessian = np.empty((starts, d, d))
    for s in range(starts):
        squares[s] = gram[s, 0, 0]
        for i in range(d):
            gradient[s, i] = gram[s, 0, 1 + i] / steps[s, i]
            for j in range(d):
                hessian[s, i, j] = gram[s, 1 + i, 1 + j] / (steps[s, i] * steps[s, j])
        if precision.size > 0:
            for i in range(d):
                pull = 0.0
                for j in range(d):
                    pull += precision[i, j] * (z[s, j] - mean[j])
                    hessian[s, i, j] += precision[i, j]
                gradient[s, i] += pull
                squares[s] += (z[s, i] - mean[i]) * pull
    return squares, gradient, hessian


@functools.cache
def prepare() -> None:
    """Compile what is above, or load it compiled."""
    one = np.ones((1, 1))
    _normal_equations(np.ones((1, 2, 2)), one, one, np.ones(1), one)


def _centred(values: Array) -> Array:
    return np.asarray(values - values.mean(axis=0))


def _finite(cost: Array) -> Array:
    return np.where(np.isfinite(cost), cost, np.inf)
