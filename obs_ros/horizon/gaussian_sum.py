"""Sums of normal distributions, each with the jumps that it believes in.

What a window hands on is a Gaussian sum (Sorenson & Alspach 1971, Automatica 7, 465-479)

    p(p) = sum_j w_j N(p; m_j, C_j),

a component for each lineage: a history of jumps that is still possible. Mean and covariance of the
whole are those of the one normal distribution that a fit takes for it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from obs_ros.core.changes import replace
from obs_ros.core.typing import Array
from obs_ros.horizon.found_jumps import JumpFound


@dataclass(frozen=True)
class SumSettings:
    """Limits of a sum.

    - `most`: components: one jump has seldom more than two rivals;
    - `least_weight`: probability below which a component ends;
    - `remembered`: windows after which a jump is history, and its lineages may merge;
    - `same_time`: window; jumps nearer to each other than that are one and the same,
    - `same_deviations`: and those nearer than so many standard deviations of their times,
    - `most_apart`: but never those farther apart than this share of a window.
    """

    most: int = 3
    least_weight: float = 0.01
    remembered: float = 10.0
    same_time: float = 0.05
    same_deviations: float = 5.0
    most_apart: float = 0.5


SUM = SumSettings()
Lineage = tuple[JumpFound, ...]


@dataclass(frozen=True)
class Component:
    """A normal distribution of parameters, in boxes: mean (q,), covariance (q, q), its weight.

    `jumps` are those that it believes in, up to the end of its window.
    """

    weight: float
    mean: Array
    covariance: Array
    jumps: Lineage = ()


def moments(components: Sequence[Component]) -> tuple[Array, Array]:
    """Return mean (q,) and covariance (q, q) of a sum, whose weights are normalised."""
    if len(components) == 1:
        return components[0].mean, components[0].covariance
    weights = np.array([one.weight for one in components])
    mean = weights @ np.array([one.mean for one in components])
    covariance = np.zeros((mean.size, mean.size))
    for one in components:
        off = one.mean - mean
        covariance += one.weight * (one.covariance + np.outer(off, off))
    return mean, covariance


def reduced(
    components: Sequence[Component], end: float, duration: float, settings: SumSettings = SUM
) -> tuple[Component, ...]:
    """Return the sum with lineages merged that do not differ lately, and unlikely ones ended.

    `end` (s) is that of the newest window, `duration` (s) how long it is.
    """
    merged: list[list[Component]] = []
    since = end - settings.remembered * duration
    for one in sorted(components, key=lambda one: -one.weight):
        one = replace(one, jumps=tuple(jump for jump in one.jumps if jump.time > since))
        for group in merged:
            if same_lineage(group[0].jumps, one.jumps, duration, settings):
                group.append(one)
                break
        else:
            merged.append([one])
    found = sorted(map(_one_of, merged), key=lambda one: -one.weight)[: settings.most]
    total = sum(one.weight for one in found)
    found = [one for one in found if one.weight >= settings.least_weight * total]
    return normalised(found)


def normalised(components: Sequence[Component]) -> tuple[Component, ...]:
    """Return the components with weights that add up to 1."""
    total = sum(one.weight for one in components)
    return tuple(replace(one, weight=one.weight / total) for one in components)


def same_event(
    one: JumpFound, other: JumpFound, duration: float, settings: SumSettings = SUM
) -> bool:
    """Whether two jumps are near enough in time to be one, whatever they are called."""
    within = settings.same_deviations * max(one.deviation, other.deviation)
    within = min(within, settings.most_apart * duration)
    return abs(one.time - other.time) <= max(settings.same_time * duration, within)


def same_lineage(
    one: Lineage, other: Lineage, duration: float, settings: SumSettings = SUM
) -> bool:
    """Whether two lineages believe in the same jumps."""
    return len(one) == len(other) and all(
        a.names == b.names and same_event(a, b, duration, settings)
        for a, b in zip(one, other, strict=True)
    )


def set_at(jumps: Lineage, event: JumpFound, duration: float) -> frozenset[str]:
    """Return the parameters that jumped at the time of an event, by a lineage; empty if none."""
    return frozenset[str]().union(
        *(jump.names for jump in jumps if same_event(jump, event, duration))
    )


def _one_of(group: Sequence[Component]) -> Component:
    """Return the one component that stands for some of the same lineage, the heaviest first."""
    weight = sum(one.weight for one in group)
    mean, covariance = moments(normalised(group))
    return Component(weight, mean, covariance, group[0].jumps)
