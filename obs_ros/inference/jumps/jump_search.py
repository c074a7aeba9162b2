"""The search for the jumps of a window: which parameters jumped in it, when, and by how much.

It is greedy, one jump at a time: moves are screened to first order, the most promising are solved
exactly, and the hypothesis of least -2 log evidence is kept if it beats the best so far. Jumps that
a later one makes needless go again. Where those leave more than noise, the search begins anew with
a jump dated by the samples before it; see `dating`. At the end each is exchanged for that of every
other parameter, left out, and joined by another, so that those that explain the window as well are
weighed.
"""

import math
from collections.abc import Iterable

import numpy as np

from obs_ros.core.deadline import Deadline
from obs_ros.core.residual_tests import independent_share, inflation, like_noise
from obs_ros.core.typing import Array
from obs_ros.inference.jumps.dating import dated
from obs_ros.inference.jumps.hypothesis import Hypothesis, beats, hypothesis_at
from obs_ros.inference.jumps.mixture import Mixture
from obs_ros.inference.jumps.moves import (
    Start,
    promising_moves,
    with_one_exchanged,
    with_one_more,
    without_one,
)
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.jumps.screening import sees_every_node
from obs_ros.optimization.levenberg_marquardt import Trail, levenberg_marquardt
from obs_ros.optimization.refinement import refined_point


class JumpSearch:
    """Search among hypotheses about one window, from the one without a jump, `still`.

    `known` is the hypothesis that the jumps of the window before are in this one too; None if there
    were none. `correlation` is the noise's lag-1 one, for which the scale of the outputs makes up.
    """

    def __init__(
        self,
        still: Hypothesis,
        deadline: Deadline,
        *,
        known: Hypothesis | None,
        correlation: float = 0.0,
    ) -> None:
        self.best = known if known is not None and beats(known, still, correlation) else still
        self.tried = [h for h in (still, known) if h]
        self._correlation = correlation
        self._deadline = deadline
        self._objective, settings = still.problem.objective, still.problem.settings
        self._begun = self._objective.evaluations
        self.settings = settings

    @property
    def finished(self) -> bool:
        """Whether there was time for all of it."""
        return not self._deadline.passed

    def run(self) -> Hypothesis:
        """Return the best hypothesis: jumps are added as long as that beats the one without."""
        self._add_jumps()
        if self._begin_dated():
            self._add_jumps()
        if not self.futile:
            exchanged = self._solved(with_one_exchanged(self.best))
            self.best = _most_probable([self.best, *exchanged])
            beside = self._solved(self._untried_beside(self.best))
            self.best = _most_probable([self.best, *beside])
        self.best = self._refined(self.best)
        return self.best

    def _add_jumps(self) -> None:
        """Add jumps to the best hypothesis, one at a time."""
        while self.best.jumps < self.settings.most_jumps and not self._over:
            base = self.best
            moves = promising_moves(base)
            rivals = self._solved(start for move in moves for start in move.start(base))
            winner = _most_probable([base, *rivals])
            if not beats(winner, base, self._correlation):
                break
            self.best = self._without_needless(winner)

    def _begin_dated(self) -> bool:
        """Begin anew with a jump dated by the samples before it, where none found explains enough.

        Returns whether there is one that beats what was found: it earns as many rollouts again.
        """
        corrected = self._objective.grid.injection is not None
        if corrected or self._deadline.passed or self.explained(self.best.squares):
            return False
        starts = list(dated(self.tried[0], self._deadline))
        begun, self._begun = self._begun, self._objective.evaluations
        winner = _most_probable([self.best, *self._solved(starts)])
        if not beats(winner, self.best, self._correlation):
            self._begun = begun
            return False
        self.best = winner
        return True

    def mixture(self) -> Mixture:
        """Return the best hypothesis and those that explain the window nearly as well."""
        return Mixture.of(self.best, self.tried, self._correlation)

    def _untried_beside(self, best: Hypothesis) -> list[Start]:
        """Return starts with one jump less or more, whose parameters have not been tried yet."""
        known = {hypothesis.parameters for hypothesis in self.tried}
        starts = [*without_one(best), *with_one_more(best)]
        return [start for start in starts if start.parameters not in known]

    def _without_needless(self, best: Hypothesis) -> Hypothesis:
        """Return the hypothesis without jumps that one found later has made superfluous."""
        while sum(map(len, best.problem.events)) > 1:
            least = _most_probable([best, *self._solved(without_one(best))])
            if least is best:
                break
            best = least
        return best

    def _solved(self, starts: Iterable[Start]) -> list[Hypothesis]:
        """Return the hypotheses that come of some starts, and remember them."""
        solved = []
        for start in starts:
            if self._over:
                break
            if (hypothesis := self._hypothesis(start)) is not None:
                solved.append(hypothesis)
                self.tried.append(hypothesis)
        return solved

    def _hypothesis(self, start: Start) -> Hypothesis | None:
        """Return the hypothesis near a start; None if it was given up, or time was."""
        problem = start.problem
        pursuit = _Pursuit(self, min(h.cost for h in self.tried))
        found = levenberg_marquardt(
            problem,
            self._at_best_time(problem, np.clip(start.point, *problem.limits))[None],
            problem.objective.nodes,
            self.settings.iterations,
            self._deadline,
            hopeless=pursuit.hopeless,
        )
        if self._deadline.passed or pursuit.lost or not np.isfinite(found.squares[0]):
            return None
        return hypothesis_at(problem, found.z[0], start.earlier)

    def _refined(self, best: Hypothesis) -> Hypothesis:
        """Return the best hypothesis at its optimum; the one without jumps came from there."""
        if best is self.tried[0]:
            return best
        problem = best.problem
        z, _ = refined_point(problem, best.point, problem.nodes, self._deadline)
        return best if z is best.point else hypothesis_at(problem, z, best.earlier)

    def _at_best_time(self, problem: PiecewiseProblem, point: Array) -> Array:
        """Return the point (D,) with its latest event where that fits best, of times nearby.

        Where every node was screened, the event is there already.
        Measurements that correct a rollout make squares rugged in the times: each correction that
        comes before a jump, or after it, is another one.
        """
        grid = problem.objective.grid
        if grid.injection is None or not problem.events or sees_every_node(problem):
            return point
        place = problem.layout.times[-1]
        shifts = np.linspace(-1.0, 1.0, self.settings.times_nearby) / (4 * self.settings.times)
        points = np.repeat(point[None], shifts.size, axis=0)
        points[:, place] = np.clip(point[place] + shifts, 0.0, 1.0)
        squares = [np.nansum(problem.trajectory(each)[1] ** 2) for each in points]
        return np.asarray(points[int(np.argmin(squares))])

    @property
    def _over(self) -> bool:
        return self._deadline.passed or self.futile

    @property
    def futile(self) -> bool:
        """Whether as many rollouts as are due have been spent on a window that nothing explains.

        Each halving of the squares earns as many again: a second jump at the same time is found
        after the first.
        """
        spent = self._objective.evaluations - self._begun
        share = self.settings.rollouts_per_unknown * self._objective.dimension
        if spent < share:  # asked at every rollout, so what costs less comes first
            return False
        still, least = self.tried[0].squares, min(h.squares for h in self.tried)
        halvings = math.log2(still / least) if 0.0 < least < still < math.inf else 0.0
        return spent >= share * (1.0 + halvings) and not self.explained(least)

    def explained(self, squares: float) -> bool:
        """Whether noise may well leave these squares."""
        objective, share = self._objective, independent_share(self._correlation)
        freedom = max(1, objective.count(objective.nodes) - objective.dimension)
        return like_noise(squares * inflation(self._correlation) * share, freedom * share)


class _Pursuit:
    """Decides whether an exact solution under way is worth more rollouts.

    It is given up where it could not catch up with the least cost if every rollout to come gained
    as much as the latest have on average; and, in a window that nothing explains, where it hardly
    gains or the search has spent its share.
    """

    def __init__(self, search: JumpSearch, least_cost: float) -> None:
        self._search, self._settings = search, search.settings
        self._limit = least_cost + self._settings.out_of_reach
        self._trail, self._left = Trail(self._settings.trail), self._settings.iterations + 1
        self.lost = False

    def hopeless(self, squares: float) -> bool:
        """Whether to give up at these squares (of residuals and prior), the least so far."""
        gained = self._trail.gain(squares)
        self._left -= 1
        self.lost = squares - gained / self._settings.trail * self._left > self._limit
        if self.lost or self._search.explained(squares):
            return self.lost
        return gained < self._settings.least_gain * squares or self._search.futile


def _most_probable(hypotheses: Iterable[Hypothesis]) -> Hypothesis:
    return min(hypotheses, key=lambda h: h.neg2_log_evidence)
