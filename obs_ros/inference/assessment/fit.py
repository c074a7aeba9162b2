"""The residual of a fit beside noise: its size, and its colour."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from obs_ros.core.residual_tests import (
    Whiteness,
    independent_share,
    inflation,
    inflation_by,
    like_noise,
    squares_of,
    too_small,
    whiteness,
)
from obs_ros.core.typing import Array
from obs_ros.inference.jumps.hypothesis import Hypothesis
from obs_ros.inference.objective import Objective
from obs_ros.optimization.memetic import MemeticSettings

ROUNDED = 0.5  # of an output's deviation: errors of rounding above it are no independent noise


@dataclass(frozen=True)
class Fit:
    """Squares of a residual in units of the noise, compared with what noise would leave.

    `freedom`: as many independent squares would vary as much; `inflation`: how much the
    correlation of the residual raises variances beyond those of the known noise; `trimmed`:
    outliers were left out, which a noise that was given may include; `rounded`: a sensor rounds by
    as much as its noise or more, and a slow signal is fitted to the errors that this leaves;
    `as_known`: the colour is that of the known noise.
    """

    squares: float
    freedom: float
    colour: Whiteness
    inflation: float
    noise_known: bool
    negligible: bool
    trimmed: bool = False
    rounded: bool = False
    as_known: bool = False

    @classmethod
    def of(
        cls,
        objective: Objective,
        squares: float,
        residuals: Array,
        *,
        noise_known: bool,
        correlation: float = 0.0,
        noise_given: bool = False,
    ) -> 'Fit':
        """Judge scaled residuals (K, r); NaN = not measured.

        Their scale is that of noise of this lag-1 correlation, enlarged to what white noise must
        have to disturb as much. A model that is wrong may have taught both, and a noise that was
        `noise_given` the correlation only.
        """
        freedom = max(1, objective.count(objective.nodes) - objective.dimension)
        share = independent_share(correlation)
        inflated = inflation_by(residuals, correlation)
        return cls(
            squares=squares * inflation(correlation) * share,
            freedom=freedom * share,
            colour=whiteness(residuals),
            inflation=inflated,
            noise_known=noise_known,
            rounded=bool((objective.grid.rounding > ROUNDED * objective.grid.scale).any()),
            negligible=squares <= MemeticSettings.negligible**2 * objective.signal * freedom,
            as_known=noise_given and correlation > 0.0 and inflated == 1.0,
        )

    @property
    def ratio(self) -> float:
        """Root mean square of the residual, in units of the noise."""
        return float(np.sqrt(self.squares / self.freedom))

    @property
    def enlargement(self) -> float:
        """Factor by which the residual enlarges variances: by its colour, and by its size.

        A residual larger than the noise means that there is more noise than was given.
        """
        return self.inflation * (self.ratio**2 if self.too_large else 1.0)

    @property
    def is_noise(self) -> bool:
        """Whether noise would leave no less, of no other colour; rounding may have any."""
        return not self.too_large and (self.white or self.negligible)

    @property
    def white(self) -> bool:
        """Whether the residual is white, or coloured as noise of the given size is known to be."""
        return self.colour.white or self.as_known

    @cached_property
    def too_large(self) -> bool:
        """Whether noise of the known size would hardly leave so much."""
        return self.noise_known and not like_noise(self.squares, self.freedom)

    @property
    def too_small(self) -> bool:
        """Whether noise of the known size would hardly leave so little."""
        known = self.noise_known and not (self.trimmed or self.rounded)
        return known and too_small(self.squares, self.freedom)


def fit_at(
    best: Hypothesis, *, noise_known: bool, correlation: float, noise_given: bool = False
) -> Fit:
    """Return the residual of a hypothesis beside noise of this lag-1 correlation, judged once."""
    key = noise_known, correlation, noise_given
    if key not in best.judged:
        best.judged[key] = Fit.of(
            best.problem.objective,
            best.squares,
            best.trajectory[1],
            noise_known=noise_known,
            correlation=correlation,
            noise_given=noise_given,
        )
    found: Fit = best.judged[key]
    return found


def root_mean_square(residuals: Array) -> Array:
    """Return the root mean square (r,) of residuals (K, r); NaN = not measured, 0 if all are."""
    counts, squares = squares_of(residuals)
    return np.asarray(np.sqrt(squares / np.maximum(1, counts)))
