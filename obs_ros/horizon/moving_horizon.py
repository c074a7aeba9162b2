"""One window after the other: prior, fit, jumps, gate, and what is learned from it.

The prior is the information of windows that ended before this one began; the jump search looks for
jumps inside the window; the gate holds what the window does not tell.
"""

import time
from dataclasses import replace

import numpy as np

from obs_ros.core.deadline import Deadline
from obs_ros.core.estimate import Estimate, Jump, Outcome
from obs_ros.core.linear_algebra import scaled_inverse
from obs_ros.core.model import names
from obs_ros.core.record import Record
from obs_ros.core.residual_tests import independent_share, inflation
from obs_ros.core.typing import Array, BoolArray
from obs_ros.horizon.announcements import Announcements
from obs_ros.horizon.arrival_cost import ArrivalCost, KnownJump, WindowPosterior
from obs_ros.horizon.probation import Probation, without_stuck
from obs_ros.horizon.solve import Solver, rescaled_to_residuals
from obs_ros.inference.assessment.assemble import Uncertainty, empty, report, states_at_bound
from obs_ros.inference.assessment.identifiability import undetermined
from obs_ros.inference.assessment.informed_subspace import InformedSubspace
from obs_ros.inference.assessment.profile import widened_by_profile
from obs_ros.inference.jumps.hypothesis import Hypothesis, hypothesis_at
from obs_ros.inference.jumps.jump_search import JumpSearch
from obs_ros.inference.jumps.piecewise import PiecewiseProblem, may_jump
from obs_ros.inference.noise import Noise, variances_left
from obs_ros.inference.objective import Objective
from obs_ros.inference.prior import Posterior, Prior
from obs_ros.optimization.levenberg_marquardt import levenberg_marquardt
from obs_ros.optimization.memetic import FULL_ITERATIONS
from obs_ros.optimization.result import Acceptance, Effort, Found
from obs_ros.samples.range_check import without_absurd

MOST_FOR_HOLDING = 20.0  # squares that a fit may lose for what its window does not tell
NOTHING_NEW = 0.95  # of a variance before; a window that leaves more has told nothing
POLISH = 40  # iterations from a start that is near
EXCESS = 5.0  # standard deviations of the squares above which a warm start is not trusted


class MovingHorizon:
    """Solves windows in order of time, each with what the earlier ones have taught.

    `learn_noise` takes the noise that is given only for where to begin.
    """

    def __init__(self, solver: Solver, *, learn_noise: bool = False) -> None:
        self._solver = solver
        self._arrival_cost = ArrivalCost(solver.unknowns)
        self._noise = Noise(solver.noise, names(solver.model.outputs), learn_noise)
        self._previous: Estimate | None = None
        self._announcements = Announcements()
        # Parameters that some window has told by itself.
        self._told = np.zeros(solver.unknowns.dimension - solver.unknowns.n_states, dtype=np.bool_)
        self._explained: Hypothesis | None = None  # the previous window's
        self._probation = Probation()
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
        if not sound.repeated:
            return estimate
        outcome = Outcome.STALE_OUTPUT if estimate.usable else estimate.outcome
        return replace(estimate, outcome=outcome, message=f'{sound.said}; {estimate.message}')

    def _solve_measured(
        self, record: Record, rng: np.random.Generator, deadline: Deadline
    ) -> Estimate:
        if not self._solver.method.needs_squares:
            estimate = self._solver.solve(record, rng, deadline, self._previous)
        else:
            estimate = self._solve(record, rng, deadline)
        if estimate.usable:
            self._previous = estimate
        return estimate

    def _solve(self, record: Record, rng: np.random.Generator, deadline: Deadline) -> Estimate:
        begin = time.perf_counter()
        solver, scale = self._solver, self._noise.scale()
        known = scale is not None
        correlation = self._noise.correlation
        if scale is not None:  # of white noise that would disturb as much
            scale = scale * np.sqrt(inflation(correlation))
        objective = solver.pose(record, scale, noise_known=known)
        if isinstance(objective, Estimate):
            return objective
        start, duration = float(record.t[0]), float(record.t[-1] - record.t[0])
        earlier = self._arrival_cost.prior(start, duration)
        prior = Prior.box(solver.unknowns) if earlier is None else earlier
        warm = solver.warm_start(record, self._previous)
        continued = self._continued(objective, prior, warm, deadline)
        found = None
        if known and warm is not None:
            posterior = Posterior(objective, prior)
            found = _from_warm(posterior, warm, deadline, continued, correlation)
        if found is None:
            found = solver.search(objective, rng, deadline, warm, noise_known=known, prior=prior)
        if not np.isfinite(found.cost):
            return solver.diverged(record, objective)
        if not known:
            found = rescaled_to_residuals(objective, found)
            polished = levenberg_marquardt(
                Posterior(objective, prior), found.z[None], objective.nodes, POLISH, deadline
            )
            found = replace(found, z=polished.z[0], cost=float(polished.squares[0]))
        still = hypothesis_at(PiecewiseProblem(objective, prior), found.z)
        search = JumpSearch(still, deadline, known=continued, correlation=correlation)
        best = search.run() if found.accepted else still
        if best.jumps and not known:
            best = _with_own_noise(best, deadline)
        uncertainty = _gated(best, deadline)
        if not best.jumps and tells_nothing(uncertainty):
            surest = self._arrival_cost.most_informative_prior(start, duration)
            uncertainty = (
                uncertainty if surest is None else _recalled(uncertainty, surest, deadline)
            )
        uncertainty = replace(uncertainty, finished=search.finished, correlation=correlation)
        jumps = self._announcements.of(uncertainty, search.alternatives(), record)
        if not best.layout.events:
            self._told |= told_alone(uncertainty)
        uncertainty = replace(uncertainty, jumps=jumps, told=self._told.copy())
        estimate = report(
            record,
            objective,
            found,
            uncertainty,
            noise_known=known,
            in_time=not deadline.passed,
            solve_time=time.perf_counter() - begin,
        )
        if found.accepted and search.finished:
            fits = self._learn(uncertainty, jumps)
            estimate = self._probation.weigh(estimate, fits) if known else estimate
        return estimate

    def _continued(
        self, objective: Objective, prior: Prior, warm: Array | None, deadline: Deadline
    ) -> Hypothesis | None:
        """Return the hypothesis that what jumped in the previous window jumped as it says there."""
        if self._explained is None or warm is None:
            return None
        events, point = _moved(self._explained, objective, warm)
        if not events:
            return None
        problem = PiecewiseProblem(objective, prior, events)
        start = np.clip(point, *problem.limits)[None]
        solved = levenberg_marquardt(problem, start, objective.nodes, POLISH, deadline)
        return hypothesis_at(problem, solved.z[0]) if np.isfinite(solved.squares[0]) else None

    def _learn(self, uncertainty: Uncertainty, jumps: tuple[Jump, ...]) -> bool:
        """Remember what an accepted window says; one that nothing explains teaches nothing.

        Returns whether it was explained.
        """
        best, history = uncertainty.hypothesis, self._arrival_cost
        objective, z = best.problem.objective, best.point
        grid, n = objective.grid, objective.unknowns.n_states
        left = variances_left(best.trajectory[1], grid, z.size)
        fit = uncertainty.fit
        odd = fit.too_large or fit.too_small
        # What a state at its bound leaves is no noise: there the model may not hold.
        if not states_at_bound(objective.unknowns.model, best.trajectory[0]):
            (self._noise.doubt if odd else self._noise.accept)(left, fit.colour)
        self._explained = None
        if fit.too_large:
            return False
        self._explained = best
        places = {name: i for i, name in enumerate(objective.unknowns.names)}
        start = float(grid.t[0])
        duration = float(grid.t[-1]) - start
        near = self._announcements.settings.same_time * duration
        earlier = history.jumps
        history.jumps = [known for known in earlier if known.time < start]
        for jump in jumps:
            known = KnownJump(jump.time, frozenset(places[name] for name in jump.sizes))
            if not any(
                other.parameters == known.parameters and abs(other.time - known.time) <= near
                for other in earlier
            ):
                history.jumped(known)
            history.jumps.append(known)
        history.prune(start, duration)
        if uncertainty.drifting or not np.isfinite(uncertainty.covariance).all():
            return True
        final = best.layout.final(z)[n:]
        covariance = uncertainty.covariance[np.ix_(final, final)]
        if uncertainty.bent:  # the valley is not where correlations say that it is
            covariance = np.diag(np.diagonal(covariance))
        history.add(WindowPosterior(float(grid.t[-1]), z[final], covariance))
        return True


def told_alone(uncertainty: Uncertainty) -> BoolArray:
    """Return which parameters (q,) a window without a jump tells without any that came before."""
    unknowns = uncertainty.hypothesis.problem.objective.unknowns
    n = unknowns.n_states
    box = Prior.box(unknowns).precision[n:, n:]
    variances = np.diagonal(scaled_inverse(uncertainty.information + box))
    return np.asarray(np.sqrt(variances) < undetermined(unknowns)[n:])


def tells_nothing(uncertainty: Uncertainty) -> bool:
    """Whether a window without a jump has made no parameter much surer than it was before."""
    best = uncertainty.hypothesis
    steady = may_jump(best.problem.objective.unknowns)
    before = np.diagonal(scaled_inverse(best.problem.prior.precision))[steady]
    return bool((np.diagonal(uncertainty.covariance)[steady] > NOTHING_NEW * before).all())


def _recalled(uncertainty: Uncertainty, prior: Prior, deadline: Deadline) -> Uncertainty:
    """Return what a surer prior makes of a window that tells nothing, if that fits the window."""
    best = uncertainty.hypothesis
    problem = replace(best.problem, prior=prior)
    nodes = best.problem.objective.nodes
    solved = levenberg_marquardt(problem, best.point[None], nodes, POLISH, deadline)
    other = hypothesis_at(problem, solved.z[0])
    return _gated(other, deadline) if other.cost < best.cost + MOST_FOR_HOLDING else uncertainty


def _from_warm(
    posterior: Posterior,
    warm: Array,
    deadline: Deadline,
    continued: Hypothesis | None,
    correlation: float,
) -> Found | None:
    """Return the fit from a warm start alone, where it or the known jumps explain the window."""
    nodes = posterior.nodes
    solved = levenberg_marquardt(posterior, warm[None], nodes, FULL_ITERATIONS, deadline)
    count = posterior.count(nodes)
    spread = np.sqrt(2.0 * count / independent_share(correlation))
    limit = (count + EXCESS * spread) / inflation(correlation)
    rule = Acceptance.LIKE_NOISE
    if not solved.squares[0] <= limit:
        if continued is None or continued.squares > limit:
            return None
        rule = Acceptance.KNOWN_JUMP
    return Found(
        z=solved.z[0],
        cost=float(solved.squares[0]),
        converged=bool(solved.converged[0]),
        accepted=rule,
        white=None,
        effort=Effort(1, 'round'),
    )


def _moved(
    explained: Hypothesis, objective: Objective, warm: Array
) -> tuple[tuple[tuple[int, ...], ...], Array]:
    """Return the events and the point of an earlier window's jumps that lie in this one too.

    `warm` (d,) is where this window is expected to begin, but for what has not jumped yet.
    """
    old, new = explained.problem.objective.grid.t, objective.grid.t
    z, events, tail = warm.copy(), [], []
    layout, point = explained.layout, explained.point
    n = objective.unknowns.n_states
    z[n:] = point[n : layout.dimension]
    jumped = layout.jumped(point)
    for event in dict.fromkeys(event for event, *_ in jumped):
        moment = old[0] + point[layout.times[event]] * (old[-1] - old[0])
        values = [(i, point[after]) for e, i, _, after in jumped if e == event]
        if moment <= new[0]:
            for i, value in values:
                z[i] = value
        elif moment < new[-1]:
            events.append(tuple(i for i, _ in values))
            tail += [(moment - new[0]) / (new[-1] - new[0]), *(value for _, value in values)]
    return tuple(events), np.concatenate([z, tail])


def _with_own_noise(best: Hypothesis, deadline: Deadline) -> Hypothesis:
    """Return a hypothesis in units of the noise that it leaves, of a window that had none given."""
    problem, objective = best.problem, best.problem.objective
    left = variances_left(best.trajectory[1], objective.grid, best.point.size)
    objective.grid = objective.grid.rescaled(np.sqrt(left) / objective.grid.scale)
    problem = replace(problem, objective=objective)
    solved = levenberg_marquardt(problem, best.point[None], objective.nodes, POLISH, deadline)
    return hypothesis_at(problem, solved.z[0], best.earlier)


def _gated(best: Hypothesis, deadline: Deadline) -> Uncertainty:
    """Hold what a window without a jump inside does not tell."""
    objective, prior = best.problem.objective, best.problem.prior
    n = objective.unknowns.n_states
    if best.layout.events:
        final = best.layout.final(best.point)[n:]
        return Uncertainty(
            best, best.covariance, scaled_inverse(best.covariance[np.ix_(final, final)])
        )
    gate = InformedSubspace.of(best)
    if not len(gate.held):
        covariance, bent = widened_by_profile(best)
        return Uncertainty(best, covariance, gate.information, bent=bent)
    holding = Posterior(objective, gate.holding(prior))
    solved = levenberg_marquardt(holding, best.point[None], objective.nodes, POLISH, deadline)
    held = hypothesis_at(best.problem, solved.z[0], best.earlier)
    if not held.squares < best.squares + MOST_FOR_HOLDING:
        held = best  # far from linear: there is no such fit where the prior has it
    return Uncertainty(held, gate.covariance(held), gate.information)
