"""Moving-horizon estimation: one window after the other, each with the arrival cost of the earlier.

Window k minimises, over its initial state and parameters z = (x_0, p),

    sum_i e_i(z)^2 + (p - m_k)' P_k (p - m_k),

e_i the residuals in units of the noise, m_k and P_k mean and precision of the parameters by the
newest window that ended before it begins, widened by their walk since then: the arrival cost (Rao,
Rawlings & Lee 2001; Rawlings, Mayne & Diehl 2017, section 4.3). Parameters may jump inside the
window; directions that it does not inform are held where the prior has them.
"""

import time
from dataclasses import replace

import numpy as np

from obs_ros.core.deadline import Deadline
from obs_ros.core.estimate import Estimate, Outcome
from obs_ros.core.model import names
from obs_ros.core.record import Record
from obs_ros.core.residual_tests import inflation
from obs_ros.core.typing import Array
from obs_ros.horizon.announcements import Announcements
from obs_ros.horizon.arrival_cost import ArrivalCost, WindowPosterior
from obs_ros.horizon.disturbance import explain_by_process_noise
from obs_ros.horizon.probation import Probation, without_stuck
from obs_ros.horizon.solver import Solver, TooFewSamples
from obs_ros.horizon.stages import (
    Explanation,
    continued_jumps,
    determined_alone,
    explain,
    fit,
    hold_uninformed,
    is_uninformative,
    recall,
)
from obs_ros.inference.assessment.assemble import empty, report
from obs_ros.inference.assessment.outcome import states_at_bound
from obs_ros.inference.assessment.uncertainty import Uncertainty
from obs_ros.inference.jumps.hypothesis import Hypothesis
from obs_ros.inference.noise import Noise, variances_left
from obs_ros.inference.process_noise import ProcessNoise
from obs_ros.inference.window_state import WindowState
from obs_ros.samples.range_check import without_absurd


class MovingHorizon:
    """Solves windows in order of time, each with the knowledge of the earlier ones.

    With `learn_noise` the noise that is given is only a starting value.
    """

    def __init__(self, solver: Solver, *, learn_noise: bool = False) -> None:
        self._solver = solver
        self._arrival_cost = ArrivalCost(solver.unknowns)
        self._noise = Noise(solver.noise, names(solver.model.outputs), learn_noise)
        self._given = (
            np.full(len(solver.model.outputs), np.nan) if learn_noise else solver.given_noise
        )
        self._process_noise: ProcessNoise | None = None  # the latest window's that had any
        self._announcements = Announcements()
        self._probation = Probation()
        self._previous: Estimate | None = None
        self._explained: Hypothesis | None = None  # the previous window's
        # Parameters that some window has determined by itself.
        self._alone = np.zeros(solver.unknowns.dimension - solver.unknowns.n_states, dtype=np.bool_)
        self.stuck = 0  # values that stuck sensors repeated
        self.huge = 0  # values that no signal of their window can have

    @np.errstate(all='ignore')  # data or model may overflow: what is not finite says so itself
    def solve(self, record: Record, rng: np.random.Generator, deadline: Deadline) -> Estimate:
        """Estimate the next window; see `solve_window`."""
        model = self._solver.model
        record, absurd = without_absurd(record)
        self.huge += absurd
        sound = without_stuck(model, record, self._solver.noise, self._noise.scale())
        self.stuck += sound.repeated
        if sound.record is None:
            return empty(model, record, Outcome.STALE_OUTPUT, sound.said)
        estimate = self._solve_measured(sound.record, rng, deadline)
        if estimate.usable:
            self._previous = estimate
        if not sound.repeated:
            return estimate
        outcome = Outcome.STALE_OUTPUT if estimate.usable else estimate.outcome
        return replace(estimate, outcome=outcome, message=f'{sound.said}; {estimate.message}')

    def _solve_measured(
        self, record: Record, rng: np.random.Generator, deadline: Deadline
    ) -> Estimate:
        if not self._solver.method.needs_squares:
            return self._solver.solve(record, rng, deadline, self._previous)
        try:
            return self._estimate(record, rng, deadline)
        except TooFewSamples as error:
            return empty(self._solver.model, record, Outcome.TOO_FEW_SAMPLES, str(error))

    def _estimate(self, record: Record, rng: np.random.Generator, deadline: Deadline) -> Estimate:
        """Take a window through its stages: prior, fit, jumps, informed subspace, report."""
        begun = time.perf_counter()
        solver = self._solver
        window = self._posed(record)
        warm = solver.warm_start(record, self._previous)
        continued = self._continued(window, warm, deadline) if window.noise_known else None
        window, found = fit(window, solver, warm, continued, rng, deadline)
        if not np.isfinite(found.cost):
            return solver.diverged(window)
        if not window.noise_known:  # only now the squares are in units of the noise
            continued = self._continued(window, warm, deadline)
        window, explanation = explain(window, found, continued, deadline)
        best = explanation.hypothesis
        other = explain_by_process_noise(
            window, found, best, self._given, deadline,
            mode=solver.settings.process_noise, previous=self._process_noise,
        )  # fmt: skip
        if other is not None:
            window, found, best = other.window, other.found, other.hypothesis
            explanation = Explanation(best, (), explanation.finished)
        uncertainty = hold_uninformed(best, deadline)
        if is_uninformative(uncertainty):
            prior = self._arrival_cost.most_informative_prior(window.start, window.duration)
            uncertainty = recall(uncertainty, prior, deadline)
        uncertainty = replace(
            uncertainty, finished=explanation.finished, correlation=window.correlation
        )
        uncertainty = uncertainty if other is None else other.added_to(uncertainty)
        jumps = self._announcements.of(uncertainty, explanation.alternatives, record)
        self._alone |= determined_alone(uncertainty)
        uncertainty = replace(uncertainty, jumps=jumps, determined_alone=self._alone.copy())
        estimate = report(
            window,
            found,
            uncertainty,
            in_time=not deadline.passed,
            solve_time=time.perf_counter() - begun,
        )
        if found.accepted and explanation.finished:
            fits = self._learn(uncertainty, None if other is None else other.noise)
            return self._probation.judge(estimate, fits) if window.noise_known else estimate
        return estimate

    def _posed(self, record: Record) -> WindowState:
        """Return the window with the arrival cost of the earlier ones; raises TooFewSamples."""
        scale, correlation = self._noise.scale(), self._noise.correlation
        if scale is not None:  # of white noise that would disturb as much
            scale = scale * np.sqrt(inflation(correlation))
        start = float(record.t[0])
        return self._solver.pose(
            record,
            scale,
            self._arrival_cost.prior(start, float(record.t[-1]) - start),
            noise_known=scale is not None,
            correlation=correlation,
        )

    def _continued(
        self, window: WindowState, warm: Array | None, deadline: Deadline
    ) -> Hypothesis | None:
        """Return the hypothesis that the previous window's jumps are as it explained them."""
        if self._explained is None or warm is None:
            return None
        return continued_jumps(window, self._explained, warm, deadline)

    def _learn(self, uncertainty: Uncertainty, process_noise: ProcessNoise | None) -> bool:
        """Remember what an accepted window says; one that nothing explains teaches nothing.

        Returns whether it was explained.
        """
        best, fits = uncertainty.hypothesis, uncertainty.fit
        objective = best.problem.objective
        grid, unknowns = objective.grid, objective.unknowns
        if process_noise is not None:
            self._process_noise = process_noise
        # What a state at its bound leaves is no noise: there the model may not hold.
        elif not states_at_bound(unknowns.model, best.trajectory[0]):
            left = variances_left(best.trajectory[1], grid, best.point.size)
            odd = fits.too_large or fits.too_small
            (self._noise.doubt if odd else self._noise.accept)(left, fits.colour)
        self._explained = None if fits.too_large or process_noise is not None else best
        if fits.too_large:
            return False
        start, end = float(grid.t[0]), float(grid.t[-1])
        near = self._announcements.settings.same_time * (end - start)
        self._arrival_cost.update_jumps(uncertainty.jumps, start, end, near)
        white = process_noise is None or fits.colour.white
        if white and not uncertainty.drifting and np.isfinite(uncertainty.covariance).all():
            final = best.layout.final(best.point)[unknowns.n_states :]
            covariance = uncertainty.covariance[np.ix_(final, final)]
            if uncertainty.bent:  # the valley is not where correlations say that it is
                covariance = np.diag(np.diagonal(covariance))
            mean = best.point[final]
            self._arrival_cost.add(WindowPosterior(end, mean, covariance))
        return True
