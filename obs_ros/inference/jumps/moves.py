"""Moves from one hypothesis to others: one jump more, one less, or one of another parameter."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from obs_ros.core.changes import replace
from obs_ros.core.typing import Array
from obs_ros.inference.jumps.hypothesis import Hypothesis
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.jumps.screening import (
    screen,
    screen_earlier,
    time_averages,
    values_at,
    widened,
)
from obs_ros.optimization.lm_linalg import TINY


class Start(NamedTuple):
    """A problem, the point (D,) from which it is solved, and the places of earlier jumps."""

    problem: PiecewiseProblem
    point: Array
    earlier: tuple[int, ...]

    @property
    def parameters(self) -> frozenset[int]:
        """Places of the parameters that jump."""
        return frozenset(self.earlier).union(*self.problem.events)


@dataclass(frozen=True, eq=False)
class NewJump:
    """One parameter jumps at a time of its own.

    The `score` of a move is its gain in -2 log evidence to first order, less its penalty. `gains`
    (T,) and `sizes` (T,), in boxes, are those at `times` (T,), shares of the window.
    """

    score: float
    parameter: int
    times: Array
    gains: Array
    sizes: Array

    @classmethod
    def screened(cls, base: Hypothesis, parameters: list[int]) -> Iterator['NewJump']:
        """Yield the best new jump of each parameter.

        Its time lies anywhere in the window: the evidence is the mean over all of them.
        """
        times, gains, sizes = screen(base, parameters)
        if times.size < 2:
            return
        scores = time_averages(times, gains) - base.problem.settings.jump_penalty
        for j, parameter in enumerate(parameters):
            yield cls(float(scores[j]), parameter, times, gains[:, j], sizes[:, j])

    def start(self, base: Hypothesis) -> Iterator[Start]:
        """Yield a start at the best time; one on either side, if an input steps between."""
        for i in _near(self.times, self.gains, base.problem.settings.times):
            time, size = float(self.times[i]), float(self.sizes[i])
            yield with_jump(base, self.parameter, time, size)


@dataclass(frozen=True)
class JoinedJump:
    """One parameter jumps with others, at the time of an `event` that is there, by `size` boxes."""

    score: float
    parameter: int
    event: int
    size: float

    @classmethod
    def screened(cls, base: Hypothesis, parameters: list[int]) -> Iterator['JoinedJump']:
        """Yield the jump of each parameter that does not jump at an event yet."""
        for event, place in enumerate(base.layout.times):
            others = [i for i in parameters if i not in base.problem.events[event]]
            if others:
                _, gains, sizes = screen(base, others, base.point[[place]])
                scores = gains[0] - base.problem.settings.further_penalty
                for parameter, score, size in zip(others, scores, sizes[0], strict=True):
                    yield cls(float(score), parameter, event, float(size))

    def start(self, base: Hypothesis) -> Iterator[Start]:
        """Yield the one start."""
        yield _joined(base, self.parameter, self.event, self.size)


@dataclass(frozen=True)
class EarlierJump:
    """One parameter jumped before this window, where nothing showed it."""

    score: float
    parameter: int

    @classmethod
    def screened(cls, base: Hypothesis, parameters: list[int]) -> Iterator['EarlierJump']:
        """Yield the jump of each parameter that has not jumped before the window yet."""
        if base.problem.events or base.problem.prior.gap is None:
            return
        gains, squares = screen_earlier(base, parameters)
        for parameter, gain, visible in zip(parameters, gains, squares, strict=True):
            if parameter not in base.earlier:
                unseen = base.problem.settings.unseen(base.problem.prior.gap, visible)
                yield cls(gain - base.problem.settings.earlier_penalty(unseen), parameter)

    def start(self, base: Hypothesis) -> Iterator[Start]:
        """Yield the one start, under a prior that is as wide as the parameter's box."""
        prior = widened(base.problem.prior, base.problem.objective.unknowns, self.parameter)
        problem = replace(base.problem, prior=prior)
        yield Start(problem, base.point, (*base.earlier, self.parameter))


Move = NewJump | JoinedJump | EarlierJump


def promising_moves(base: Hypothesis) -> list[Move]:
    """Return the moves that are worth an exact solution, the best first.

    They may count beside the base, and score not too much less than the best.
    """
    parameters, settings = base.problem.objective.unknowns.may_jump, base.problem.settings
    if not parameters:
        return []
    found: list[Move] = [
        *NewJump.screened(base, parameters),
        *EarlierJump.screened(base, parameters),
        *JoinedJump.screened(base, parameters),
    ]
    found.sort(key=lambda move: -move.score)
    worst = max(-settings.reach, found[0].score - settings.rival_margin)
    chosen = [move for move in found[: settings.rivals] if move.score > worst]
    # To first order a second jump is seen at its own time, and not yet at that of a first one which
    # has stood for both.
    alone = {move.parameter for move in chosen if isinstance(move, NewJump)}
    joined = [move for move in found if isinstance(move, JoinedJump) and move.parameter in alone]
    return [*chosen, *(move for move in joined[:1] if move not in chosen)]


def without_one(base: Hypothesis) -> Iterator[Start]:
    """Yield starts without one of the jumps inside the window each."""
    start = Start(base.problem, base.point, base.earlier)
    for event, parameters in enumerate(base.problem.events):
        for i in range(len(parameters)):
            yield _without(start, event, i)


def with_one_more(base: Hypothesis) -> Iterator[Start]:
    """Yield starts with one more parameter that jumps with others, the most promising first.

    They score no less than a hypothesis that still counts beside the base.
    """
    settings = base.problem.settings
    moves = JoinedJump.screened(base, base.problem.objective.unknowns.may_jump)
    for move in sorted(moves, key=lambda move: -move.score)[: settings.rivals]:
        if move.score > -settings.reach:
            yield from move.start(base)


def with_one_exchanged(base: Hypothesis) -> Iterator[Start]:
    """Yield starts with another parameter in place of each that jumped.

    Screening sees parameters beside those that jumped already. Of two that act alike, the second is
    not missed there, and would not be named.
    """
    still = set(base.problem.objective.unknowns.may_jump) - base.parameters
    for event, jumped, before, after in base.layout.jumped(base.point):
        for other in sorted(still):
            both = _joined(base, other, event, 0.0)
            parameters = both.problem.events[event]
            place = int(both.problem.layout.times[event]) + len(parameters)
            steps = np.full(both.point.size, both.problem.settings.first_step)
            jacobian = both.problem.linearisation(both.point, steps).jacobian
            old, new = jacobian[:, after], jacobian[:, place]
            # As much as changes the outputs most nearly as the jump does that it is to replace.
            size = (base.point[after] - base.point[before]) * (old @ new) / max(new @ new, TINY)
            both.point[place] += size
            yield _without(both, event, parameters.index(jumped))


def with_jump(base: Hypothesis, parameter: int, time: float, size: float) -> Start:
    """Return a start with one more event; the parameter's later values move along."""
    value = values_at(base, parameter, np.array([time]))[0] + size
    point, times = base.point.copy(), base.layout.times
    for jump in base.layout.jumped(point):
        if jump.parameter == parameter and base.point[times[jump.event]] > time:
            point[jump.after] += size
    problem = replace(base.problem, events=(*base.problem.events, (parameter,)))
    return Start(problem, np.concatenate([point, [time, value]]), base.earlier)


def _joined(base: Hypothesis, parameter: int, event: int, size: float) -> Start:
    """Return a start with one more parameter that jumps at the time of an event."""
    events, place = list(base.problem.events), int(base.layout.times[event])
    end = place + 1 + len(events[event])
    events[event] = (*events[event], parameter)
    value = values_at(base, parameter, base.point[[place]])[0] + size
    problem = replace(base.problem, events=tuple(events))
    return Start(problem, np.insert(base.point, end, value), base.earlier)


def _without(start: Start, event: int, i: int) -> Start:
    """Return a start without the jump of the i-th parameter of an event."""
    problem, point, earlier = start
    events, place = list(problem.events), int(problem.layout.times[event])
    rest = (*events[event][:i], *events[event][i + 1 :])
    events[event : event + 1] = [rest] if rest else []
    gone = [place + 1 + i] if rest else [place, place + 1]
    return Start(replace(problem, events=tuple(events)), np.delete(point, gone), earlier)


def _near(times: Array, gains: Array, parts: int) -> list[int]:
    """Return the place of the best of times (T,), and of another peak of the gains (T,) near it.

    Near is within one of so many parts of the window; steps of a part of a part tell peaks apart.
    """
    best = int(np.argmax(gains))
    near = times[best] + np.arange(1 - parts, parts) / parts**2
    places = np.unique(np.append(np.searchsorted(times, near).clip(0, times.size - 1), best))
    beside = np.concatenate([[-np.inf], gains[places], [-np.inf]])
    peaks = places[(beside[1:-1] >= beside[:-2]) & (beside[1:-1] >= beside[2:])]
    return sorted(peaks.tolist(), key=lambda i: -gains[i])[:2]
