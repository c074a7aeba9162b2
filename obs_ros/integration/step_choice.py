"""Method and steps of an integration, such that its error stays far below the noise.

Steps of a method are judged by doubling them: the difference of two rollouts whose steps are h and
h / 2 is (1 - 2^-p) of the error of the first, p the order (Richardson; Hairer, Norsett & Wanner
1993, II.4). Where errors are too large, steps go to the intervals that cause them: interval k with
S_k steps and a share m_k of the error gets S_k' ~ (m_k S_k^p)^(1 / (p + 1)), the fewest steps in
all that leave a given error.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from obs_ros.core.typing import Array, BoolArray, IntArray

ORDERS = {'rk4': 4, 'euler': 1, 'rosenbrock': 3}


@dataclass(frozen=True)
class StepSettings:
    """Limits in choosing method and steps.

    - `aimed`: integration error in standard deviations of the noise; a tenth adds half a percent
      to what noise leaves;
    - `tolerated`: error of an answer above which it is found anew with finer steps; by three tenths
      of the noise an estimate is hardly moved;
    - `share`: of its distance from the measurements, root mean square, by which a candidate of the
      search may err: its costs, which are ranked, are then right within a third or so;
    - `reference`: the same of the first candidate, at any output: near the measurements it is held
      to `aimed`, and a guess that is far from them is not worth more;
    - `most`: share of these candidates of which that is asked; in the corners of a box a plant may
      well do what it never does;
    - `cheaper`: how many times less another method must cost than RK4, whose kernels are there
      already and whose costs are smooth;
    - `steps`: of one candidate through one window, at most; steps that the model itself asks for by
      its `max_step` come on top;
    - `rounds`: in which steps are spread anew; each needs about six rollouts of a few candidates;
    - `patience`: rounds in a row that bring errors down by less than half, after which they are
      taken for what no steps can lower;
    - `natural`: the same for candidates that diverge all along, where no mode dies out: they do so
      by nature;
    - `attempts`: times that an answer is found anew in finer steps;
    - `growth`: by which steps in an interval change in one round;
    - `safety`: share of the error allowed at which the steps aim.
    """

    aimed: float = 0.1
    tolerated: float = 0.3
    share: float = 0.2
    reference: float = 0.02
    most: float = 0.75
    cheaper: float = 2.0
    steps: int = 100_000
    rounds: int = 12
    patience: int = 4
    natural: int = 3
    attempts: int = 2
    growth: float = 8.0
    safety: float = 0.5


STEPPING = StepSettings()
LARGEST = 1e6  # times what is allowed: how much more it is then tells nothing of the steps


class Verdict(NamedTuple):
    """Steps judged: the first candidate's `error` in deviations of the noise, and `excess` (B,).

    Excess is a candidate's error over what it is allowed; infinite where it diverges. `largest` is
    the error, root mean square, of any candidate, in deviations of the noise.
    """

    error: float
    excess: Array
    largest: float = np.inf

    def worst(self, most: float = STEPPING.most) -> float:
        """Return the excess of the first candidate, or that within which `most` others stay."""
        others = common(self.excess[1:], most) if self.excess.size > 1 else 0.0
        return float(max(self.excess[0], others))

    def without(self, exempt: BoolArray | None) -> 'Verdict':
        """Return the verdict in which candidates `exempt` (B,) count for nothing."""
        if exempt is None:
            return self
        return self._replace(excess=np.where(exempt, 0.0, self.excess))


class Trial(Protocol):
    """Candidates, the first of them a reference, to integrate by any method and steps (N,)."""

    def judge(self, method: str, steps: IntArray) -> Verdict:
        """Return how far the candidates are off with these steps."""

    def decays(self) -> bool:
        """Whether any candidate has a mode that dies out within an interval, as stiff plants do."""

    def shares(self, method: str, steps: IntArray, verdict: Verdict) -> Array:
        """Return the share (N,) of each interval in the worst excess; their sum is about that."""


class Choice(NamedTuple):
    """The method, its steps (N,), and the reference's integration error in deviations of noise."""

    method: str
    steps: IntArray
    error: float
    worst: float  # excess of most candidates: up to 1 the steps suffice
    largest: float = np.inf  # error of any candidate

    @property
    def fine(self) -> bool:
        """Whether errors are within what is allowed."""
        return self.worst <= 1.0


def chosen(
    trial: Trial,
    methods: tuple[str, ...],
    base: IntArray,
    cost: Callable[[str], float],
    settings: StepSettings = STEPPING,
) -> Choice:
    """Return the first method with the steps it needs, unless the second is clearly cheaper.

    base (N,) are the fewest steps; `cost`, that of one step by a method. The second method is
    tried where the first needs more steps than it could ever save. Without any that suffice, those
    that err least are returned.
    """
    limit = settings.steps + int(base.sum())
    first = methods[0]
    verdict = trial.judge(first, base)
    if (worst := verdict.worst(settings.most)) <= 1.0:
        return Choice(first, base, verdict.error, worst, verdict.largest)
    if len(methods) == 1:
        return _refined(trial, first, base, base, limit, settings)
    if not trial.decays():
        return _refined(trial, first, base, base, limit, settings, natural=settings.natural)
    second = methods[1]
    ratio = settings.cheaper * cost(second) / cost(first)
    short = min(limit, int(ratio * base.sum()))
    found = _refined(trial, first, base, base, short, settings)
    if found.fine:
        return found
    other = _refined(trial, second, base, base, limit, settings, doubtful=first)
    if other.method == first:
        return other
    enough = min(limit, int(ratio * other.steps.sum()))
    if enough > short:
        found = _refined(trial, first, found.steps, base, enough, settings)
    return found if found.fine or found.worst < other.worst else other


def _refined(
    trial: Trial,
    method: str,
    steps: IntArray,
    base: IntArray,
    limit: int,
    settings: StepSettings,
    doubtful: str | None = None,
    natural: int | None = None,
) -> Choice:
    """Return the steps (N,), `limit` in all at most, that suffice; else those that err least.

    They grow from `steps`, and are `base` (N,) at least; for `natural` rounds, if given, where too
    many candidates diverge.

    Candidates that diverge by the `doubtful` method too, at the first steps, diverge by nature:
    where they alone are too many, that method is returned.
    """
    order = float(ORDERS[method])
    exempt: BoolArray | None = None
    best, before = Choice(method, steps, np.inf, np.inf), (np.inf, 0)
    last, vain = False, 0
    for number in range(settings.rounds):
        verdict = trial.judge(method, steps)
        if not number and doubtful is not None and not np.isfinite(verdict.excess).all():
            other = trial.judge(doubtful, steps)
            exempt = np.isinf(verdict.excess) & np.isinf(other.excess)
            if (worst := other.without(exempt).worst(settings.most)) <= 1.0:
                return Choice(doubtful, steps, other.error, worst)
        verdict = verdict.without(exempt)
        worst = verdict.worst(settings.most)
        now = Choice(method, steps, verdict.error, worst, verdict.largest)
        if now.fine:
            return _halved(trial, now, base, exempt, settings)
        vain = 0 if worst < settings.safety * best.worst else vain + 1
        best = best if vain else now
        patience = settings.patience if natural is None or np.isfinite(worst) else natural
        if last or vain >= patience:
            break
        order = observed_order(order, before, (worst, int(steps.sum())), ORDERS[method])
        before = worst, int(steps.sum())
        shares = trial.shares(method, steps, verdict)
        wanted = redistributed(steps, shares, order, base, settings)
        if last := bool(wanted.sum() > limit):
            wanted = np.maximum(base, (wanted * (limit / wanted.sum())).astype(np.int64))
        if wanted.sum() > limit or (wanted <= steps).all():
            break
        steps = wanted
    return best


def _halved(
    trial: Trial,
    found: Choice,
    base: IntArray,
    exempt: BoolArray | None,
    settings: StepSettings,
) -> Choice:
    """Return fewer steps if they suffice too: steps grow fast where all that is seen diverges."""
    while found.worst * 2.0 ** ORDERS[found.method] < 1.0:
        steps = np.maximum(base, -(-found.steps // 2))
        if not (steps < found.steps).any():
            break
        verdict = trial.judge(found.method, steps).without(exempt)
        worst = verdict.worst(settings.most)
        if worst > 1.0:
            break
        found = Choice(found.method, steps, verdict.error, worst, verdict.largest)
    return found


def observed_order(
    order: float, before: tuple[float, int], now: tuple[float, int], highest: float
) -> float:
    """Return the order by which errors have fallen: at kinks less than that of the method.

    `before` and `now` are excess and number of steps in two rounds.
    """
    ratio = now[1] / before[1] if before[1] else 1.0
    if not (np.isfinite(before[0]) and np.isfinite(now[0]) and ratio > 1.0):
        return order
    return float(np.clip(np.log(before[0] / now[0]) / np.log(ratio), 1.0, highest))


def redistributed(
    steps: IntArray,
    shares: Array,
    order: float,
    least: IntArray,
    settings: StepSettings = STEPPING,
) -> IntArray:
    """Return the fewest steps (N,) with which shares (N,) of the excess come to `safety` in all.

    `least` (N,) are the fewest in each interval.
    """
    shares = np.clip(shares, 1e-12, LARGEST)
    wanted = (shares * steps**order) ** (1.0 / (order + 1.0))
    low = np.maximum(least, steps / settings.growth)

    def taken(scale: float) -> Array:
        return np.asarray(np.maximum(scale * wanted, low))

    lowest, highest = -60.0, 60.0  # powers of two of the scale
    for _ in range(50):
        middle = 0.5 * (lowest + highest)
        left = float(np.sum(shares * (steps / taken(2.0**middle)) ** order))
        lowest, highest = (middle, highest) if left > settings.safety else (lowest, middle)
    # What growth withholds from some intervals, others could not make up for.
    taken_now = np.minimum(taken(2.0**highest), settings.growth * steps)
    return np.asarray(np.ceil(taken_now * (1.0 - 1e-9)), dtype=np.int64)


def doubling_error(difference: Array, method: str) -> Array:
    """Return the error of results, by their difference from those of twice as many steps."""
    return np.asarray(np.abs(difference) / (1.0 - 0.5 ** ORDERS[method]))


def common(values: Array, most: float) -> Array:
    """Return along the last axis what a share `most` of the values does not exceed."""
    if not values.shape[-1]:
        return np.zeros(values.shape[:-1])
    place = int(np.ceil(most * values.shape[-1])) - 1
    return np.asarray(np.partition(values, place, axis=-1)[..., place])
