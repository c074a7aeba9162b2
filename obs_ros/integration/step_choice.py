"""Method and steps of an integration, such that its error stays far below the noise.

Steps of a method are judged by doubling them: the difference of two rollouts whose steps are h and
h / 2 is (1 - 2^-p) of the error of the first, p the order (Richardson; Hairer, Norsett & Wanner
1993, II.4). Where errors are too large, steps go to the intervals that cause them: interval k with
S_k steps and a share m_k of the error gets S_k' ~ (m_k S_k^p)^(1 / (p + 1)), the fewest steps in
all that leave a given error.

Of a method by which candidates take steps of their own, a tolerance of their local errors takes the
place of steps (see `own_steps.py`).
"""

from collections.abc import Callable

import numpy as np

from obs_ros.core.typing import Array, BoolArray, IntArray
from obs_ros.integration.grid import TIGHTER
from obs_ros.integration.step_trials import (
    LARGEST,
    ORDERS,
    STEPPING,
    Choice,
    StepSettings,
    Trial,
    Verdict,
    common,
)


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
    if trial.takes_own(first):
        own = by_own_steps(trial, first, base, settings.loosest, settings)
        if np.isfinite(own.worst):
            return own
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
    other = Choice(second, base, np.inf, np.inf)
    if trial.takes_own(second):
        other = by_own_steps(trial, second, base, settings.loosest, settings, doubtful=first)
    if not np.isfinite(other.worst):
        other = _refined(trial, second, base, base, limit, settings, doubtful=first)
    if other.method == first:
        return other
    enough = min(limit, int(ratio * other.steps.sum()))
    if enough > short:
        found = _refined(trial, first, found.steps, base, enough, settings)
    return found if found.fine or found.worst <= other.worst else other


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
        if last or vain >= _patience(verdict, natural, settings):
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


def _patience(verdict: Verdict, natural: int | None, settings: StepSettings) -> int:
    """Return for how many rounds errors are awaited to fall."""
    if not np.isfinite(verdict.worst(settings.most)):
        return settings.patience if natural is None else natural
    others = verdict.excess[1:]
    alone = others.size > 0 and common(others, settings.most) <= 1.0
    return settings.alone if alone else settings.patience


def by_own_steps(
    trial: Trial,
    method: str,
    base: IntArray,
    tolerance: float,
    settings: StepSettings = STEPPING,
    doubtful: str | None = None,
) -> Choice:
    """Return the loosest tolerance, from one on, by which the reference errs little enough.

    The others control their errors as it does, but most must get through: among endless switches
    none does. Without any that suffices, that by which the reference errs least is returned. Of
    candidates that diverge by the `doubtful` method too, see `_refined`.
    """
    best, vain = Choice(method, base, np.inf, np.inf, np.inf, tolerance, settings.own), 0
    exempt: BoolArray | None = None
    while tolerance >= settings.tightest and vain < 2:
        verdict, counts = trial.judge_own(method, tolerance)
        if doubtful is not None and not np.isfinite(verdict.excess).all():
            other = trial.judge(doubtful, base)
            exempt = np.isinf(verdict.excess) & np.isinf(other.excess)
            exempt[0] = False  # whether by nature or for want of steps: that one has to be led on
            if (worst := other.without(exempt).worst(settings.most)) <= 1.0:
                return Choice(doubtful, base, other.error, worst)
        verdict, doubtful = verdict.without(exempt), None
        worst = np.inf if common(np.isinf(verdict.excess[1:]), settings.most) else verdict.excess[0]
        worst, taken = float(worst), counts.sum(axis=0)
        usual = max(taken[0], np.median(taken))
        most = int(np.clip(settings.ahead * usual, settings.fewest, settings.own))
        vain = 0 if worst < settings.safety * best.worst else vain + 1
        if not vain or not np.isfinite(best.worst):
            steps = np.maximum(base, counts[:, 0])
            best = Choice(
                method, steps, verdict.error, worst, verdict.largest,
                tolerance if np.isfinite(worst) else best.tolerance, most + 10 * int(base.sum()),
            )  # fmt: skip
        if best.fine:
            break
        tolerance *= TIGHTER
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
