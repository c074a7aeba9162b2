"""The prior of a window's unknowns, as squares beside those of its residuals.

A normal prior of mean m and precision P adds (z - m)' P (z - m), -2 log of its density but for a
constant: with the residuals' squares they make -2 log posterior.
"""

from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from obs_ros.core.changes import replace
from obs_ros.core.linear_algebra import eigen, log_determinant
from obs_ros.core.typing import Array, IntArray
from obs_ros.inference.objective import Objective
from obs_ros.inference.parameterisation import STATE_SD, Unknowns

LEAST_VARIANCE = 1e-12  # against that of the box: below is rounding
NOWHERE = np.zeros(0, dtype=np.int64)


@dataclass(frozen=True)
class Prior:
    """A normal distribution of the unknowns: mean (d,) and precision (d, d), in boxes.

    - `gap`: its age in windows; None where no window handed it on: then no jump before this
      window is considered;
    - `given` (d,): precision beyond that of the boxes by priors that the user gives, 0 where there
      is none; the precision has nothing else in such a row. None: there is none at all;
    - `boxes` (d, d): part of the precision that says no more than that parameters lie in their
      boxes. It steadies a search, but is no knowledge. None: there is none.
    """

    mean: Array
    precision: Array
    gap: float | None = None
    given: Array | None = None
    boxes: Array | None = None

    @classmethod
    def of(
        cls, unknowns: Unknowns, mean: Array, covariance: Array, gap: float | None = None
    ) -> 'Prior':
        """Return the prior for parameters of this mean (q,) and covariance (q, q), in boxes.

        No direction is known less than that it lies in its box.
        """
        n = unknowns.n_states
        width = np.sqrt(unknowns.box_variances)
        values, vectors = eigen(covariance / np.outer(width, width))
        if not np.isfinite(values).all():  # nothing is known
            return replace(cls.box(unknowns), gap=gap)
        vectors /= width[:, None]
        precision = np.zeros((unknowns.dimension, unknowns.dimension))
        precision[:n, :n] = np.eye(n) / STATE_SD**2
        precision[n:, n:] = (vectors / np.clip(values, LEAST_VARIANCE, 1.0)) @ vectors.T
        boxes = np.zeros_like(precision)
        boxes[n:, n:] = (vectors * (values >= 1.0)) @ vectors.T
        return cls(np.concatenate([np.full(n, 0.5), mean]), precision, gap, boxes=boxes)

    @classmethod
    def box(cls, unknowns: Unknowns) -> 'Prior':
        """Return the prior of parameters that may lie anywhere in their boxes."""
        precision, boxes = unknowns.box_precisions
        return cls(np.full(unknowns.dimension, 0.5), precision.copy(), boxes=boxes.copy())

    @classmethod
    def known(cls, unknowns: Unknowns, *, start: bool, jumped: IntArray = NOWHERE) -> 'Prior':
        """Return the prior before any window: the given ones, and boxes for what has none.

        Those of initial states count with `start`, in the window that the plant starts with; those
        of parameters whose places have `jumped` since do not count.
        """
        places = np.arange(0 if start else unknowns.n_states, unknowns.dimension)
        return cls.box(unknowns).with_given(unknowns, np.setdiff1d(places, jumped))

    def with_given(self, unknowns: Unknowns, places: IntArray) -> 'Prior':
        """Return this with the given priors of the unknowns at `places`, where there are any.

        No direction is known less than that it lies in its box.
        """
        means, deviations = unknowns.priors
        places = places[np.isfinite(means[places])]
        if not places.size:
            return self
        boxes = np.append(np.full(unknowns.n_states, STATE_SD**2), unknowns.box_variances)
        variances = np.clip(deviations**2, LEAST_VARIANCE * boxes, boxes)
        mean, precision = self.mean.copy(), self.precision.copy()
        given = np.zeros_like(mean) if self.given is None else self.given.copy()
        mean[places] = means[places]
        precision[places] = precision[:, places] = 0.0
        precision[places, places] = 1.0 / variances[places]
        given[places] = 1.0 / variances[places] - 1.0 / boxes[places]
        kept = np.zeros_like(precision) if self.boxes is None else self.boxes.copy()
        kept[places] = kept[:, places] = 0.0
        return replace(self, mean=mean, precision=precision, given=given, boxes=kept)

    def without_given(self, places: IntArray) -> 'Prior':
        """Return this with boxes in place of the given priors at `places`."""
        assert self.given is not None
        mean, precision, given = self.mean.copy(), self.precision.copy(), self.given.copy()
        mean[places] = 0.5
        precision[places, places] -= given[places]
        given[places] = 0.0
        boxes = np.zeros_like(precision) if self.boxes is None else self.boxes.copy()
        boxes[places, places] = precision[places, places]
        return replace(self, mean=mean, precision=precision, given=given, boxes=boxes)

    def gives(self, places: Collection[int]) -> bool:
        """Whether a prior is given of any of the unknowns at `places`."""
        given = self.given
        return given is not None and any(given[place] > 0.0 for place in places)

    def information(self, parameters: int) -> Array:
        """Return the information (q, q) of given priors about so many parameters, the last ones."""
        given = np.zeros(self.mean.size) if self.given is None else self.given
        return np.diag(given[given.size - parameters :])

    @cached_property
    def log_determinant(self) -> float:
        """The logarithm of the precision's determinant."""
        return log_determinant(self.precision)

    @cached_property
    def knowledge(self) -> 'Prior':
        """The prior without what says only that parameters lie in their boxes.

        Nothing is known of a parameter then, but for a precision that keeps matrices regular.
        """
        if self.boxes is None:
            return self
        nothing = np.diag((np.diagonal(self.boxes) > 0.0) / STATE_SD**2)
        return replace(self, precision=self.precision - self.boxes + nothing, boxes=None)

    @property
    def without_boxes(self) -> 'Prior':
        """The given priors alone: of all other unknowns nothing is known, not even their boxes."""
        assert self.given is not None
        precision = np.diag(np.diagonal(self.precision) * (self.given > 0.0))
        return replace(self, precision=precision, boxes=None)

    def squares(self, z: Array) -> Array:
        """Return (z - mean)' precision (z - mean) of points z (B, d)."""
        off = z - self.mean
        return np.asarray(((off @ self.precision) * off).sum(axis=1))

    def gradient(self, z: Array) -> Array:
        """Return half the gradient (B, d) of the squares at points z (B, d)."""
        return np.asarray((z - self.mean) @ self.precision)


class Posterior:
    """The least squares of a window with those of a prior added to its last node.

    A `Problem` of least squares like the `Objective` that it stands for.
    """

    def __init__(self, objective: Objective, prior: Prior) -> None:
        self.objective = objective
        self.prior = prior

    @property
    def dimension(self) -> int:
        """Number of unknowns, d."""
        return self.objective.dimension

    @property
    def is_least_squares(self) -> bool:
        """See `Objective.is_least_squares`."""
        return self.objective.is_least_squares

    @property
    def limits(self) -> Array:
        """See `Objective.limits`."""
        return self.objective.limits

    @property
    def nodes(self) -> int:
        """Number of nodes of the window, K."""
        return self.objective.nodes

    @property
    def signal(self) -> float:
        """See `Objective.signal`."""
        return self.objective.signal

    @property
    def wraps(self) -> bool:
        """See `Objective.wraps`."""
        return self.objective.wraps

    @property
    def straight(self) -> 'Posterior':
        """See `Objective.straight`."""
        return Posterior(self.objective.straight, self.prior)

    def count(self, nodes: int) -> int:
        """See `Objective.count`."""
        return self.objective.count(nodes)

    def floor(self, nodes: int) -> float:
        """See `Objective.floor`."""
        return self.objective.floor(nodes)

    def costs(self, z: Array, nodes: int | None = None) -> Array:
        """Return the cost (B,) of every point over the first `nodes` nodes (default: all)."""
        return self.objective.costs(z, nodes) + self.prior.squares(z)

    def block_squares(self, z: Array, prefixes: IntArray) -> Array:
        """Return squares (G, B) summed between rising numbers of nodes (G,)."""
        squares = self.objective.block_squares(z, prefixes)
        squares[-1] += self.prior.squares(z)
        return squares

    def linearise(self, z: Array, h: Array, nodes: int) -> tuple[Array, Array, Array]:
        """See `Objective.linearise`."""
        return self.objective.linearise(z, h, nodes, self.prior)

    def residuals(self, z: Array) -> Array:
        """See `Objective.residuals`."""
        return self.objective.residuals(z)
