"""Moving-horizon estimation: one window after the other, each with the arrival cost of the earlier.

Window k minimises, over its initial state and parameters z = (x_0, p),

    sum_i e_i(z)^2 + (p - m_k)' P_k (p - m_k),

e_i the residuals in units of the noise, m_k and P_k mean and precision of the parameters by the
newest window that ended before it begins, widened by their walk since then: the arrival cost (Rao,
Rawlings & Lee 2001; Rawlings, Mayne & Diehl 2017, section 4.3). Parameters may jump inside the
window.
"""

import numpy as np

from obs_ros.core.changes import replace
from obs_ros.core.deadline import Deadline
from obs_ros.core.estimate import Estimate, Outcome
from obs_ros.core.record import Record
from obs_ros.core.residual_tests import inflation
from obs_ros.horizon.arrival_cost import WindowPosterior
from obs_ros.horizon.beliefs import Beliefs, believed, jumps_shown
from obs_ros.horizon.comparison import by_forecasts, compared, figures_of
from obs_ros.horizon.disturbance import assessed
from obs_ros.horizon.earlier import Earlier
from obs_ros.horizon.found_jumps import Explained
from obs_ros.horizon.gaussian_sum import SUM, Component, moments, reduced
from obs_ros.horizon.intervals import with_intervals
from obs_ros.horizon.knowledge import Knowledge
from obs_ros.horizon.probation import withheld_by_push, without_stuck
from obs_ros.horizon.ramps import drift_ahead
from obs_ros.horizon.solution import SOLUTION, Solution, level_of
from obs_ros.horizon.stages import determined_alone, is_uninformative, recall, uncertainty_of
from obs_ros.horizon.unsolvable import Unsolvable
from obs_ros.inference.assessment.assemble import empty, report
from obs_ros.inference.assessment.contradiction import contradictions
from obs_ros.inference.assessment.deviations import parameters_at_end
from obs_ros.inference.assessment.informed_subspace import marginal_information
from obs_ros.inference.assessment.outcome import is_confirmed, states_at_bound
from obs_ros.inference.assessment.uncertainty import Uncertainty
from obs_ros.inference.jumps.mixture import excess
from obs_ros.inference.noise import variances_left
from obs_ros.inference.window_state import WindowState
from obs_ros.samples.range_check import without_absurd


class MovingHorizon(Knowledge):
    """Solves windows in order of time, each with the knowledge of the earlier ones."""

    @np.errstate(all='ignore')  # data or model may overflow: what is not finite says so itself
    def solve(self, record: Record, rng: np.random.Generator, deadline: Deadline) -> Estimate:
        """Estimate the next window; see `solve_window`."""
        model = self._solver.model
        record, absurd = without_absurd(record)
        self.huge += absurd
        scale = self._noise.scale()
        sound = without_stuck(model, record, self._solver.noise, scale, self._resolutions)
        self.stuck += sound.repeated
        if sound.record is None:
            return empty(model, record, Outcome.STALE_OUTPUT, sound.said)
        estimate = self._solve_measured(sound.record, rng, deadline)
        self._first = False
        if estimate.usable:
            self._previous = estimate
        return sound.told(estimate)

    def _solve_measured(
        self, record: Record, rng: np.random.Generator, deadline: Deadline
    ) -> Estimate:
        if not self._solver.method.needs_squares:
            return self._solver.solve(record, rng, deadline, self._previous, first=self._first)
        try:
            return self._estimate(record, rng, deadline)
        except Unsolvable as error:
            return empty(self._solver.model, record, error.outcome, str(error))

    def _estimate(self, record: Record, rng: np.random.Generator, deadline: Deadline) -> Estimate:
        """Take a window through its stages: prior, explanation, uncertainty, report."""
        begun = Deadline()
        solver = self._solver
        posed = self._posed(record)
        warm = solver.warm_start(record, self._previous, self._stepped.kernels)
        level = self._level if self._unsearched < SOLUTION.unsearched else None
        known = self._arrival_cost.given_prior(posed.start, first=self._first)
        usual = self._process_noise.usual
        earlier = Earlier(
            warm, self._explained, self._process_noise.pooled if usual else None,
            self._process_noise.settled, level, known, self._plain, self._process_noise.latest,
        )  # fmt: skip
        solution, answer = self._stepped.solved(posed, earlier, self._given, rng, deadline)
        if solution is None or answer is None:
            return solver.diverged(posed)
        plain = solution.plain
        self._plain = plain.point[plain.final]
        posed, record = solution.posed, solution.posed.record  # without outliers
        self.outliers.note(solution.window.outliers, posed.start)
        self._note_search(posed, solution)
        self.forecasts.advance(self._stepped.kernels, record)
        if solver.settings.process_noise != 'off':
            solution = by_forecasts(self.forecasts, posed, solution)
        solution, beliefs = self._believed(posed, solution, deadline)
        uncertainty = self._uncertainty(solution, beliefs, record, deadline)
        estimate = report(
            solution.window, solution.found, uncertainty, in_time=not deadline.passed,
            solve_time=begun.elapsed,
        )  # fmt: skip
        estimate = answer.told(replace(estimate, figures=figures_of(uncertainty)))
        explained = alone = False
        if solution.found.accepted and solution.finished and answer.fine:
            pushed = solution.disturbed is not None and not uncertainty.walking
            self._process_noise.note(pushed)
            # A parameter that walks is a ramp, unless it was elsewhere when the window began.
            odd = not usual and (pushed or (solution.disturbed is not None and solution.dropped))
            explained = self._learn(uncertainty, solution, beliefs, odd=odd)
            alone = solution.disturbed is None and uncertainty.skill is None
            alone = explained and (alone or bool(uncertainty.walking))
            if solution.window.noise_known:
                # Whatever its colour, a residual of the given size contradicts nothing given.
                larger = pushed or uncertainty.fit.too_large
                given = solution.window.noise_given and larger
                estimate = self._probation.judge(estimate, alone, uncertainty.skill, given=given)
            if odd:
                estimate = withheld_by_push(estimate)
        moving = (*uncertainty.moving, *uncertainty.walking)
        estimate = self._announcements.announced(
            estimate, beliefs, explained=explained, alone=alone, moving=moving
        )
        self._follow(estimate)
        return self._lateness.told(estimate, solution.plain)

    def _believed(
        self, posed: WindowState, solution: Solution, deadline: Deadline
    ) -> tuple[Solution, Beliefs]:
        """Return the solution by the most probable lineage, and all that is believed.

        With process noise the moments of all lineages are the prior of one.
        """
        lineages = self._arrival_cost.lineages(posed.start, posed.duration)
        if solution.disturbed is not None:
            lineages = lineages[:1]
        beliefs = believed(solution.mixture, lineages, posed.start, posed.duration, deadline)
        return replace(solution, mixture=beliefs.mixture), beliefs

    def _follow(self, estimate: Estimate) -> None:
        """Draw from news of jumps what the windows to come must know."""
        if taken_back := [jump.time for jump in estimate.jumps if jump.retracted]:
            self._arrival_cost.forget_wrong(min(taken_back), estimate.t1)
        if any(jump.new for jump in estimate.jumps):
            self._scatter.forget()
        self._arrival_cost.note_drifts(self._announcements.rates)

    def _note_search(self, posed: WindowState, solution: Solution) -> None:
        """Note how well a search explained its window by process noise, and how long ago it was."""
        self._unsearched += 1
        if solution.searched:
            own = solution.disturbed
            self._level = None if own is None else level_of(posed, own)
            self._unsearched = 0

    def _uncertainty(
        self, solution: Solution, beliefs: Beliefs, record: Record, deadline: Deadline
    ) -> Uncertainty:
        """Return what is known of a solution's point: covariance, jumps, skill of its forecasts."""
        window, other = solution.window, solution.disturbed
        best = solution.hypothesis
        if other is not None and other.covariance is not None:
            # The optimum of output error, where no prior may pull it to that of the likelihood.
            states = self._solver.unknowns.n_states
            uncertainty = Uncertainty(best, best.covariance, marginal_information(best, states))
        else:
            uncertainty = uncertainty_of(best)
            if is_uninformative(uncertainty):
                prior = self._arrival_cost.most_informative_prior(window.start, window.duration)
                uncertainty = recall(uncertainty, prior, deadline)
        uncertainty = replace(
            uncertainty, finished=solution.finished, correlation=window.correlation,
            noise_given=window.noise_given,
        )  # fmt: skip
        uncertainty = uncertainty if other is None else other.added_to(uncertainty)
        uncertainty = assessed(uncertainty, self._solver.settings.process_noise)
        uncertainty = with_intervals(uncertainty, other, solution.found, deadline)
        if uncertainty.skill is not None:
            uncertainty = compared(uncertainty, self.forecasts, self._scatter, solution.said)
        self._alone |= determined_alone(uncertainty, self._alone, deadline)
        return replace(
            uncertainty,
            jumps=jumps_shown(uncertainty, beliefs, solution.mixture.alternatives, record),
            excess=excess(solution.mixture.about(uncertainty.hypothesis), uncertainty.straight),
            determined_alone=self._alone.copy(),
        )

    def _posed(self, record: Record) -> WindowState:
        """Return the window with the arrival cost of the earlier ones; raises Unsolvable."""
        scale, correlation = self._noise.scale(), self._noise.correlation
        if scale is not None:  # of white noise that would disturb as much
            scale = scale * np.sqrt(inflation(correlation))
        start = float(record.t[0])
        prior = self._arrival_cost.prior(start, float(record.t[-1]) - start)
        prior = prior or self._arrival_cost.given_prior(start, first=self._first)
        known = scale is not None
        posed = self._solver.pose(record, scale, prior, noise_known=known, correlation=correlation)
        return replace(posed, told_by=self._noise.told_by)

    def _learn(
        self, uncertainty: Uncertainty, solution: Solution, beliefs: Beliefs, *, odd: bool
    ) -> bool:
        """Remember what an accepted window says; one that nothing explains teaches nothing.

        An `odd` one has process noise that earlier ones had not: it hands nothing on. Returns
        whether it was explained.
        """
        best, fits, other = uncertainty.hypothesis, uncertainty.fit, solution.disturbed
        objective = best.problem.objective
        grid, unknowns = objective.grid, objective.unknowns
        wrong = contradictions(best, fits.inflation)
        self._contradicted |= {each.place for each in wrong}
        explained = is_confirmed(fits, uncertainty.skill)
        if other is not None:
            if not (best.jumps or uncertainty.walking):
                noise = solution.learned or other.noise
                self._process_noise.add(noise, sound=not uncertainty.flaws)
        # What a state at its bound leaves is no noise: there the model may not hold.
        elif not states_at_bound(unknowns.model, best.trajectory[0]):
            left = variances_left(best.trajectory[1], grid, best.point.size)
            wrong_size = fits.too_large or fits.too_small
            (self._noise.doubt if wrong_size else self._noise.accept)(left, fits.colour)
        self._explained = Explained.by(best) if explained and not fits.too_large else None
        if not explained or odd:
            return explained
        start, end = float(grid.t[0]), float(grid.t[-1])
        near = SUM.same_time * (end - start)
        self._arrival_cost.update_jumps(beliefs.known_jumps(unknowns), start, end, near)
        # What is not white narrows the prior only by as much as windows agree.
        sound = (uncertainty.skill is None and not fits.too_large) or fits.is_noise
        known = uncertainty.scatter is not None
        # A contradicted prior is no knowledge to hand on: later windows would seem to agree.
        doubtful = best.problem.prior.gives(self._contradicted)
        if (sound or known) and not (uncertainty.drifting or doubtful):
            self._hand_on(uncertainty, beliefs, end, 1.0 if sound else fits.enlargement)
        return True

    def _hand_on(
        self, uncertainty: Uncertainty, beliefs: Beliefs, end: float, inflation: float
    ) -> None:
        """Hand the parameters at the end (s) of a window on to later ones."""
        if not np.isfinite(uncertainty.covariance).all():
            return
        mean, covariance, walked = parameters_at_end(uncertainty)
        first = beliefs.every[0]
        covariance = inflation * covariance + drift_ahead(uncertainty)
        components = reduced(
            [
                Component(first.weight, mean, covariance, first.jumps),
                *beliefs.components(inflation),
            ],
            end,
            beliefs.duration,
        )
        self._arrival_cost.add(WindowPosterior(end, *moments(components), walked, components))
