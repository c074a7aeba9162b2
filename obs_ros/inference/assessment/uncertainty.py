"""Uncertainty of an estimate: the covariance of its unknowns, and what else is known of them.

The covariance is the inverse of the information J' J + P: J the Jacobian of the scaled residuals,
which makes J' J the Fisher information of white Gaussian noise, and P the precision of the prior
(Gauss-Newton approximation; Ljung 1999, section 9.4). At a bound it stays that of the free
unknowns, as freezing them makes intervals far too short; clip an interval to the box instead.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from obs_ros.core.estimate import Jump
from obs_ros.core.residual_tests import inflation
from obs_ros.core.typing import Array, BoolArray
from obs_ros.inference.assessment.fit import Fit, fit_at
from obs_ros.inference.assessment.interval import Interval
from obs_ros.inference.assessment.structure import Structure
from obs_ros.inference.jumps.hypothesis import Hypothesis
from obs_ros.inference.process_noise import ProcessNoise


@dataclass(frozen=True)
class AtEnd:
    """State and parameters at the newest output, beside what the unknowns say of them.

    covariance (n + q, n + q) is theirs with the unknowns given, in the variables' units. Where
    parameters walk, parameters (q,) are their values there and jacobian (q, d) the derivatives of
    these by the unknowns, in boxes; else None. path (K, n) are the smoothed states that lead there,
    None where the hypothesis has them.
    """

    covariance: Array
    parameters: Array | None = None
    jacobian: Array | None = None
    path: Array | None = None


@dataclass(frozen=True)
class Uncertainty:
    """A window's hypothesis with the joint covariance (D, D) of its point.

    - `information` (q, q): that about the estimated parameters, the initial state unknown;
    - `interval`: of the parameters, from profiles, where the covariance does not tell it;
    - `finished`: there was time to look for jumps;
    - `correlation`: the noise's at lag 1, which the covariance accounts for already;
      `noise_given`: its size was given, not learned;
    - `process_noise`: what explains the window beside its unknowns, and what that makes of the
      `end`;
    - `skill`: of the forecasts inside a window that noise alone does not explain, see `skill.py`;
      None where none was needed; `scatter` (q,) is that of disjoint windows over what they
      published, with which the covariance is raised already; `said` tells in words what else was
      decided; `structure`: what speaks against the model beside process noise;
    - `excess` (n + q, n + q): second moment of the end about the published one by hypotheses that
      explain the window nearly as well, in excess of the covariance, states in their units and
      estimated parameters in boxes; None where there are none. See `jumps/mixture.py`;
    - `determined_alone` (q,): parameters that some window has determined by itself. Of the others
      nothing is known, whatever many windows seem to add up to along a bent valley.
    """

    hypothesis: Hypothesis
    covariance: Array
    information: Array
    jumps: tuple[Jump, ...] = ()
    interval: Interval | None = None
    finished: bool = True
    correlation: float = 0.0
    noise_given: bool = False
    excess: Array | None = None
    determined_alone: BoolArray | None = None
    process_noise: ProcessNoise | None = None
    end: AtEnd | None = None
    skill: float | None = None
    scatter: Array | None = None
    said: str = ''
    structure: Structure | None = None

    @property
    def drifting(self) -> bool:
        """Whether jumps at several times look like the steps of a ramp."""
        return len(self.hypothesis.problem.events) > 1

    @property
    def straight(self) -> Array:
        """Covariance (D, D) beside the profiles, which tell the bent part where there are some."""
        return self.covariance if self.interval is None else self.hypothesis.covariance

    @property
    def walking(self) -> tuple[str, ...]:
        """Names of the parameters that walk through the window though the model does not say so."""
        model = self.hypothesis.problem.objective.unknowns.model
        return () if self.process_noise is None else self.process_noise.drifting(model)

    @property
    def disturbance(self) -> str:
        """The process noise in words, and what else was decided."""
        if self.process_noise is None:
            return self.said
        words = self.process_noise.words(self.hypothesis.problem.objective.unknowns.model)
        return '; '.join(part for part in (words, self.said) if part)

    @property
    def flaws(self) -> str:
        """Words on what speaks against the model's structure, '' if nothing does."""
        unknowns = self.hypothesis.problem.objective.unknowns
        return (
            ''
            if self.structure is None
            else self.structure.words(unknowns.names[unknowns.n_states :])
        )

    @property
    def moving(self) -> tuple[str, ...]:
        """Names of the parameters that are not constant in the window, beside process noise."""
        if self.structure is None:
            return ()
        unknowns = self.hypothesis.problem.objective.unknowns
        places = unknowns.n_states + np.flatnonzero(self.structure.moving)
        return tuple(unknowns.names[i] for i in places)

    @property
    def noise(self) -> Array:
        """Standard deviations (r,) of the outputs' noise."""
        if self.process_noise is not None:
            return self.process_noise.noise
        scale = self.hypothesis.problem.objective.grid.scale
        return np.asarray(scale / np.sqrt(inflation(self.correlation)))

    @cached_property
    def fit(self) -> Fit:
        """The hypothesis's residual beside the noise, given or learned."""
        return fit_at(
            self.hypothesis, noise_known=True, correlation=self.correlation,
            noise_given=self.noise_given,
        )  # fmt: skip
