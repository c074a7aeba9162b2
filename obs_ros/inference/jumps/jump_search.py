"""The jump search: which parameter jumped inside this window, when, and by how much.

Hypotheses are compared by their evidence E: squares, penalties, and the logarithm of how much the
window narrows the prior. The least E wins.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from obs_ros.core.deadline import Deadline
from obs_ros.core.linear_algebra import scaled_inverse
from obs_ros.core.residual_tests import independent_share, inflation, inflation_by, like_noise
from obs_ros.core.typing import Array
from obs_ros.inference.jumps.hypothesis import Hypothesis, hypothesis_at
from obs_ros.inference.jumps.piecewise import Layout, PiecewiseProblem, may_jump
from obs_ros.inference.jumps.settings import JUMP_SETTINGS
from obs_ros.inference.objective import Objective
from obs_ros.inference.prior import Prior, box_variances
from obs_ros.optimization.levenberg_marquardt import Trail, levenberg_marquardt

TINY = 1e-200  # guards a division


class JumpSearch:
    """Hypotheses about one window, raced from the one without a jump.

    `known` is the one that what has jumped before did so; `correlation` is the noise's lag-1 one,
    for which the scale of the outputs makes up.
    """

    def __init__(
        self,
        still: Hypothesis,
        deadline: Deadline,
        *,
        known: Hypothesis | None,
        correlation: float = 0.0,
    ) -> None:
        self._correlation = correlation
        self.best = known if known is not None and _beats(known, still, correlation) else still
        self.tried = [h for h in (still, known) if h]
        self._deadline = deadline
        self._begun = still.problem.objective.evaluations
        self._hopeful = (
            JUMP_SETTINGS.hopeful if known is None else JUMP_SETTINGS.hopeful_after_known
        )

    @property
    def finished(self) -> bool:
        """Whether there was time for all of it."""
        return not self._deadline.passed

    def run(self) -> Hypothesis:
        """Add jumps as long as that lowers the evidence; return the best hypothesis.

        A parameter may also have jumped since the last window that the prior knows of.
        """
        while self.best.jumps < JUMP_SETTINGS.most_jumps and not self._over:
            rivals = self._all_solved(self._starts(self.best))
            winner = min(rivals, key=lambda h: h.neg2_log_evidence, default=self.best)
            if not _beats(winner, self.best, self._correlation):
                break
            self.best = self._without_needless(winner)
        if self._futile:
            return self.best
        exchanged = self._all_solved(_exchanged(self.best))
        self.best = min([self.best, *exchanged], key=lambda h: h.neg2_log_evidence)
        return self.best

    def _without_needless(self, best: Hypothesis) -> Hypothesis:
        """Return the hypothesis without jumps that one found later has made superfluous."""
        while sum(map(len, best.layout.events)) > 1:
            fewer = self._all_solved(_reduced(best))
            least = min(fewer, key=lambda h: h.neg2_log_evidence, default=best)
            if least.neg2_log_evidence >= best.neg2_log_evidence:
                break
            best = least
        return best

    def alternatives(self) -> list[Hypothesis]:
        """Return those with other sets of parameters that explain the window nearly as well."""
        least: dict[frozenset[int], Hypothesis] = {}
        for other in sorted(self.tried, key=lambda h: h.neg2_log_evidence):
            least.setdefault(other.parameters, other)
        least.pop(self.best.parameters, None)
        limit = self.best.neg2_log_evidence + JUMP_SETTINGS.similar
        return [other for other in least.values() if other.neg2_log_evidence < limit]

    def _all_solved(
        self, starts: Iterable[tuple[PiecewiseProblem, Array, tuple[int, ...]]]
    ) -> list[Hypothesis]:
        """Return the hypotheses that come of some starts, and remember them."""
        solved = []
        for start in starts:
            if self._over:
                break
            if (hypothesis := self._solved(*start)) is not None:
                solved.append(hypothesis)
                self.tried.append(hypothesis)
        return solved

    def _solved(
        self, problem: PiecewiseProblem, point: Array, earlier: tuple[int, ...]
    ) -> Hypothesis | None:
        """Return the best hypothesis of a problem near a point; None if out of time."""
        nodes = problem.objective.nodes
        start = np.clip(point, *problem.limits)[None]
        pursuit = _Pursuit(min(h.cost for h in self.tried), self._explained, lambda: self._futile)
        starts = levenberg_marquardt(
            problem,
            start,
            nodes,
            JUMP_SETTINGS.iterations,
            self._deadline,
            hopeless=pursuit.hopeless,
        )
        if self._deadline.passed or pursuit.lost or not np.isfinite(starts.squares[0]):
            return None
        return hypothesis_at(problem, starts.z[0], earlier)

    @property
    def _over(self) -> bool:
        return self._deadline.passed or self._futile

    @property
    def _futile(self) -> bool:
        """Whether as much as is due has been spent on a window that nothing explains.

        Each halving of the squares earns as many rollouts again: a second jump at the same time is
        found after the first.
        """
        objective = self.best.problem.objective
        spent = objective.evaluations - self._begun
        share = JUMP_SETTINGS.rollouts_per_unknown * objective.dimension
        if spent < share:  # asked at every rollout, so what costs less comes first
            return False
        still, least = self.tried[0].squares, min(h.squares for h in self.tried)
        halvings = math.log2(still / least) if 0.0 < least < still < math.inf else 0.0
        return spent >= share * (1.0 + halvings) and not self._explained(least)

    def _explained(self, squares: float) -> bool:
        """Whether noise may well leave these squares."""
        objective, share = self.best.problem.objective, independent_share(self._correlation)
        freedom = max(1, objective.count(objective.nodes) - objective.dimension)
        return like_noise(squares * inflation(self._correlation) * share, freedom * share)

    def _starts(
        self, base: Hypothesis
    ) -> Iterator[tuple[PiecewiseProblem, Array, tuple[int, ...]]]:
        """Yield the problem, point and earlier jumps of what is worth an exact solution."""
        found = []
        objective = base.problem.objective
        parameters = may_jump(objective.unknowns)
        if not parameters:
            return
        # Not believing the prior cannot gain more than what it costs.
        off = base.point[: objective.dimension] - base.problem.prior.mean
        pull = off @ base.problem.prior.precision @ off
        price = base.problem.settings.earlier_penalty(base.problem.prior.gap)
        doubted = not base.layout.events and pull > price + self._hopeful
        spread = np.arange(1, JUMP_SETTINGS.times) / JUMP_SETTINGS.times
        gains, sizes = self._screened(base, spread, parameters)
        scores = gains - JUMP_SETTINGS.jump_penalty - 2.0 * math.log(JUMP_SETTINGS.times)
        for j, parameter in enumerate(parameters):
            i = int(scores[:, j].argmax())
            found.append((scores[i, j], parameter, spread[i], sizes[i, j]))
            if doubted and parameter not in base.earlier:
                score = self._earlier(base, parameter) - price
                found.append((score, parameter, 0.0, 0.0))
        for event, place in zip(base.layout.events, base.layout.times, strict=True):
            others = [parameter for parameter in parameters if parameter not in event]
            if others:
                time = base.point[place]
                gains, sizes = self._screened(base, np.array([time]), others)
                for j, parameter in enumerate(others):
                    score = gains[0, j] - JUMP_SETTINGS.further_penalty
                    found.append((score, parameter, time, sizes[0, j]))
        found.sort(key=lambda candidate: -candidate[0])
        best = found[0][0]
        for score, parameter, time, size in found[: JUMP_SETTINGS.rivals]:
            if score > max(self._hopeful, best - JUMP_SETTINGS.rival_margin):
                yield from self._near(base, parameter, float(time), float(size))

    def _near(
        self, base: Hypothesis, parameter: int, time: float, size: float
    ) -> Iterator[tuple[PiecewiseProblem, Array, tuple[int, ...]]]:
        """Yield one start, or one for each of the two best times nearby."""
        objective, prior = base.problem.objective, base.problem.prior
        if time == 0.0:
            wider = widened(prior, objective, parameter)
            problem = replace(base.problem, prior=wider)
            yield problem, base.point, (*base.earlier, parameter)
        elif time in base.point[base.layout.times]:
            layout, point = _joined(base, parameter, time, size)
            yield replace(base.problem, events=layout.events), point, base.earlier
        else:
            fine = (
                time
                + np.arange(-JUMP_SETTINGS.times + 1, JUMP_SETTINGS.times, 2)
                / JUMP_SETTINGS.times**2
            )
            fine = fine[(fine > 0.0) & (fine < 1.0)]
            gains, sizes = self._screened(base, fine, [parameter])
            # Where an input steps there may be a minimum on either side.
            for i in _peaks(gains[:, 0])[:2]:
                layout, point = _added(base, parameter, float(fine[i]), float(sizes[i, 0]))
                yield replace(base.problem, events=layout.events), point, base.earlier

    def _screened(
        self, base: Hypothesis, times: Array, parameters: Sequence[int]
    ) -> tuple[Array, Array]:
        """Return gains in evidence and sizes (T, J) of jumps of single parameters, to first order.

        A jump lasts from its time, a share of the window, to the end. No penalty is taken off.
        """
        layout, d = base.layout, len(parameters)
        times = at_nodes(base.problem.objective.grid.t, times)
        probe = replace(layout, events=(*layout.events, *[tuple(parameters)] * times.size))
        values = np.array([_value_at(base, parameter, times) for parameter in parameters]).T
        point = np.concatenate([base.point, np.column_stack([times, values]).ravel()])
        points = np.repeat(point[None], 1 + times.size * d, axis=0)
        places = base.point.size + np.arange(times.size)[:, None] * (1 + d) + 1 + np.arange(d)
        step = np.where(values > 0.5, -JUMP_SETTINGS.probe_step, JUMP_SETTINGS.probe_step).ravel()
        lanes = 1 + np.arange(step.size)
        points[lanes, places.ravel()] += step
        rows = replace(base.problem, events=probe.events).rows(points)
        with np.errstate(invalid='ignore'):  # the model may diverge
            pieces = ((rows[:, 1:] - rows[:, :1]) / step).reshape(-1, times.size, d)
        pieces = np.nan_to_num(pieces, nan=0.0, posinf=0.0, neginf=0.0)
        # A piece lasts to the next time; a jump, to the end.
        shapes = np.cumsum(pieces[:, ::-1], axis=1)[:, ::-1].reshape(-1, times.size * d)
        variances = box_variances(base.problem.objective.unknowns)
        n = base.problem.objective.unknowns.n_states
        weight = np.tile([1.0 / variances[parameter - n] for parameter in parameters], times.size)
        cross = base.linearisation.jacobian.T @ shapes
        height = (shapes**2).sum(axis=0) + weight
        height -= (cross * (base.covariance @ cross)).sum(axis=0)
        height = np.maximum(height, weight)
        slope = shapes.T @ base.linearisation.residual
        gains = slope**2 / height - np.log(height / weight)
        return gains.reshape(times.size, d), (-slope / height).reshape(times.size, d)

    def _earlier(self, base: Hypothesis, parameter: int) -> float:
        """Return the gain in evidence of not believing the prior about one parameter."""
        objective = base.problem.objective
        wider = widened(base.problem.prior, objective, parameter)
        narrow = base.problem.prior
        hessian = base.linearisation.jacobian.T @ base.linearisation.jacobian
        off = base.point[: objective.dimension] - narrow.mean
        pull = narrow.precision @ off
        values = []
        for prior in (narrow, wider):
            gradient = prior.precision @ off - pull
            information = hessian + prior.precision
            gain = gradient @ scaled_inverse(information) @ gradient
            squares = off @ prior.precision @ off - gain
            log_det = np.linalg.slogdet(information)[1]
            values.append(squares + log_det - np.linalg.slogdet(prior.precision)[1])
        return float(values[0] - values[1])


class _Pursuit:
    """Decides whether a solution under way is worth more rollouts; `best` is the least cost."""

    def __init__(
        self, best: float, explained: Callable[[float], bool], futile: Callable[[], bool]
    ) -> None:
        self._best, self._explained, self._futile = best, explained, futile
        self._trail, self._left = Trail(JUMP_SETTINGS.latest), JUMP_SETTINGS.iterations + 1
        self.lost = False

    def hopeless(self, squares: float) -> bool:
        """Whether to give up at these squares (of residuals and prior), the least so far."""
        gained = self._trail.gain(squares)
        self._left -= 1
        self.lost = (
            squares - gained / JUMP_SETTINGS.latest * self._left
            > self._best + JUMP_SETTINGS.out_of_reach
        )
        if self.lost or self._explained(squares):
            return self.lost
        return gained < JUMP_SETTINGS.hardly * squares or self._futile()


def _peaks(gains: Array) -> list[int]:
    """Return where the gains (T,) are larger than beside them, the largest first."""
    beside = np.concatenate([[-np.inf], gains, [-np.inf]])
    peaks = np.flatnonzero((gains >= beside[:-2]) & (gains >= beside[2:]))
    return sorted(peaks.tolist(), key=lambda i: -gains[i])


def at_nodes(t: Array, times: Array) -> Array:
    """Return the shares of the window (T,) at which the nodes nearest to `times` (T,) lie."""
    nodes = np.searchsorted(t, t[0] + times * (t[-1] - t[0]))
    return np.asarray((t[np.clip(nodes, 1, t.size - 2)] - t[0]) / (t[-1] - t[0]))


def _beats(winner: Hypothesis, best: Hypothesis, correlation: float) -> bool:
    """Whether a hypothesis with more jumps is to be believed.

    Where its residual is correlated, more than the noise is known to be, squares count for less:
    what a model leaves out is not to be taken for jumps. And where the model has kinks, what the
    prior is narrowed by means little: squares must have been gained as well.
    """
    gained = best.squares - winner.squares
    paid = (winner.neg2_log_evidence - winner.squares) - (best.neg2_log_evidence - best.squares)
    if gained <= paid or winner.cost > best.cost:
        return False
    return gained > paid * inflation_by(winner.trajectory[1], correlation)


def widened(prior: Prior, objective: Objective, *places: int) -> Prior:
    """Return the prior with parameters that may since have jumped anywhere."""
    covariance = scaled_inverse(prior.precision)
    n = objective.unknowns.n_states
    variances = box_variances(objective.unknowns)
    for place in places:
        covariance[place, place] += variances[place - n]
    return Prior.of(objective.unknowns, prior.mean[n:], covariance[n:, n:], prior.gap)


def _value_at(base: Hypothesis, parameter: int, times: Array) -> Array:
    """Return the values (T,) of a parameter at some times."""
    values = np.full(times.shape, base.point[parameter])
    layout = base.layout
    for event, jumped, _, after in layout.jumped(base.point):
        if jumped == parameter:
            values[times >= base.point[layout.times[event]]] = base.point[after]
    return values


def _added(base: Hypothesis, parameter: int, time: float, size: float) -> tuple[Layout, Array]:
    """Return the layout and the point with one more event; later values move along."""
    value = _value_at(base, parameter, np.array([time]))[0] + size
    point = base.point.copy()
    for event, jumped, _, after in base.layout.jumped(point):
        if jumped == parameter and base.point[base.layout.times[event]] > time:
            point[after] += size
    layout = replace(base.layout, events=(*base.layout.events, (parameter,)))
    return layout, np.concatenate([point, [time, value]])


def _joined(base: Hypothesis, parameter: int, time: float, size: float) -> tuple[Layout, Array]:
    """Return the layout and the point with one more parameter jumping at an event's time."""
    layout = base.layout
    event = int(np.flatnonzero(base.point[layout.times] == time)[0])
    events = list(layout.events)
    end = int(layout.times[event]) + 1 + len(events[event])
    events[event] = (*events[event], parameter)
    value = _value_at(base, parameter, np.array([time]))[0] + size
    return replace(layout, events=tuple(events)), np.insert(base.point, end, value)


def _reduced(base: Hypothesis) -> Iterator[tuple[PiecewiseProblem, Array, tuple[int, ...]]]:
    """Yield the problem, point and earlier jumps without one of the jumps inside the window."""
    problem, layout = base.problem, base.layout
    for event, parameters in enumerate(layout.events):
        for i in range(len(parameters)):
            rest = (*parameters[:i], *parameters[i + 1 :])
            events = (
                *layout.events[:event],
                *([rest] if rest else []),
                *layout.events[event + 1 :],
            )
            time = int(layout.times[event])
            gone = [time + 1 + i] if rest else [time, time + 1]
            yield (
                replace(problem, events=events),
                np.delete(base.point, gone),
                base.earlier,
            )


def _exchanged(base: Hypothesis) -> Iterator[tuple[PiecewiseProblem, Array, tuple[int, ...]]]:
    """Yield starts with another parameter in place of each that jumped.

    The search screens parameters beside what it has found. Of two that act alike the second is not
    missed there, and would not be named.
    """
    problem, layout, point = base.problem, base.layout, base.point
    still = set(may_jump(problem.objective.unknowns)) - base.parameters
    for event, jumped, before, after in layout.jumped(point):
        for other in sorted(still):
            both, start = _joined(base, other, float(point[layout.times[event]]), 0.0)
            place = int(both.times[event]) + len(both.events[event])
            jacobian = replace(problem, events=both.events).linearisation(
                start, np.full(start.size, JUMP_SETTINGS.first_step)
            ).jacobian  # fmt: skip
            old, new = jacobian[:, after], jacobian[:, place]
            # As much as changes the outputs most nearly as the jump does that it is to replace.
            size = (point[after] - point[before]) * (old @ new) / max(new @ new, TINY)
            start[place] += size
            rest = tuple(i for i in both.events[event] if i != jumped)
            events = (*both.events[:event], rest, *both.events[event + 1 :])
            yield (
                replace(problem, events=events),
                np.delete(start, after),
                base.earlier,
            )
