"""Knowledge of earlier windows, and a window explained by jumps with it."""

from dataclasses import dataclass

import numpy as np

from obs_ros.core.changes import replace
from obs_ros.core.chi_square import exceeds
from obs_ros.core.deadline import Deadline
from obs_ros.core.linear_algebra import scaled_inverse
from obs_ros.core.typing import Array
from obs_ros.horizon.cleaning import refitted
from obs_ros.horizon.disturbance import fit_of
from obs_ros.horizon.found_jumps import Explained
from obs_ros.horizon.stages import Explanation, continued_jumps, explain
from obs_ros.inference.assessment.informed_subspace import marginal_information
from obs_ros.inference.jumps.hypothesis import Hypothesis
from obs_ros.inference.jumps.outlying import beside
from obs_ros.inference.outliers import left_out, outliers_in
from obs_ros.inference.prior import Prior
from obs_ros.inference.process_noise import ProcessNoise
from obs_ros.inference.window_state import WindowState
from obs_ros.optimization.result import Found


@dataclass(frozen=True)
class ContradictionSettings:
    """Limits of what earlier windows say.

    - `contradiction`: probability of a prior as far off as this one, were it right, below which it
      is dropped.
    """

    contradiction: float = 1e-4


CONTRADICTION = ContradictionSettings()


@dataclass(frozen=True)
class Earlier:
    """Knowledge of earlier windows: a start (d,), the jumps, the process noise; None where none.

    `settled`: enough windows tell the process noise to set a jump apart from it; `level` is the
    criterion per value of the window searched last, None if that is too long ago; `known` is what
    is known without any window, None: the boxes; `plain` (d,) is the last optimum without process
    noise.
    """

    warm: Array | None
    explained: Explained | None
    noise: ProcessNoise | None
    settled: bool = False
    level: float | None = None
    known: Prior | None = None
    plain: Array | None = None
    pushed: bool = False

    def starts_without(self, z: Array, n: int) -> Array:
        """Return starts (P, d) of a fit without process noise: that with it, z (d,), and the last.

        Of the last one only the parameters, from place n on, are those of this window.
        """
        if self.plain is None or self.warm is None:
            return z[None]
        return np.array([z, np.concatenate([self.warm[:n], self.plain[n:]])])

    @property
    def alone(self) -> 'Earlier':
        """Return this without jumps found beside process noise, which alone mean nothing."""
        if self.explained is None or not self.explained.pushed:
            return self
        return replace(self, explained=None)


def earlier_jumps(window: WindowState, earlier: Earlier, deadline: Deadline) -> Hypothesis | None:
    """Return the hypothesis that the previous window's jumps are as it explained them."""
    if earlier.explained is None or earlier.warm is None:
        return None
    return continued_jumps(window, earlier.explained, earlier.warm, deadline)


def beside_known_jumps(
    window: WindowState, earlier: Earlier, deadline: Deadline
) -> tuple[WindowState, Hypothesis | None]:
    """Return the window without outliers beside the jumps that are known, and their hypothesis."""
    known = earlier_jumps(window, earlier, deadline)
    far = None if known is None else outliers_in(window, known.residuals, noise_known=True)
    if known is None or far is None or not far.any():
        return window, known
    clean = left_out(window, far, known.residuals)
    other = earlier_jumps(clean, earlier, deadline)
    if other is None or not fit_of(clean, other).is_noise:
        return window, known
    return clean, other


def explained(
    window: WindowState,
    found: Found,
    continued: Hypothesis | None,
    earlier: Earlier,
    deadline: Deadline,
    still: Hypothesis | None = None,
) -> tuple[WindowState, Found, Explanation]:
    """Return the window explained by jumps, or by outliers beside less of them, and its fit.

    `still` is the hypothesis without jumps, if it has been made.
    """
    own, explanation = explain(window, found, continued, deadline, still)
    far = beside(window, explanation.tried)
    if far is None or deadline.passed:
        return own, found, explanation
    window, found = refitted(left_out(window, *far), found, deadline)
    known = None if continued is None else earlier_jumps(window, earlier, deadline)
    own, explanation = explain(window, found, known, deadline)
    return own, found, explanation


def contradicts_prior(
    best: Hypothesis, known: Prior | None = None, settings: ContradictionSettings = CONTRADICTION
) -> bool:
    """Whether a window's own optimum is better than a right prior would let it be.

    Without the prior of the parameters, of mean m and precision P, -2 log p falls by o' P o +
    o' P (I + B)^-1 P o with o = p - m, I the window's information and B that of the boxes: for a
    right prior a chi-square of as many degrees of freedom as there are parameters. A prior that is
    `known` without any window is the user's, and stays.
    """
    problem = best.problem
    n, q = problem.objective.unknowns.n_states, best.layout.dimension
    given = problem.prior
    B = (known or Prior.box(problem.objective.unknowns)).precision[n:, n:]
    P = given.precision[n:, n:]
    if problem.events or q == n or np.allclose(P, B):
        return False
    off = best.point[n:q] - given.mean[n:]
    own = scaled_inverse(marginal_information(best, n) - given.information(q - n) + B)
    gain = off @ P @ off + off @ P @ own @ P @ off
    return exceeds(float(gain), q - n, settings.contradiction)
