"""Directions of parameters with as few of them as can be, and power products of two in words."""

import math
from dataclasses import dataclass

import numpy as np

from obs_ros.core.typing import Array


@dataclass(frozen=True)
class PowerSettings:
    """Limits of power products that mean something.

    - `round_ratio`: how near a ratio of powers must be to a multiple of one half;
    - `most_halves`: the largest such multiple.
    """

    round_ratio: float = 0.05
    most_halves: int = 6


POWERS = PowerSettings()


def sparse(directions: Array, chosen: list[int] | None = None) -> Array:
    """Return other directions (k, q) that span the same space, each with k - 1 zeros at least.

    `chosen` are the places (k) that are 1 in one direction and 0 in the others; an empty list gets
    them.
    """
    rows = directions.copy()
    given = list(chosen or ())
    pivots: list[int] = []
    for k in range(len(rows)):
        free = np.abs(rows[k])
        free[pivots] = 0.0
        pivot = given[k] if given else int(free.argmax())
        rows[k] /= rows[k, pivot]
        for other in range(len(rows)):
            if other != k:
                rows[other] -= rows[other, pivot] * rows[k]
        pivots.append(pivot)
    if chosen is not None and not given:
        chosen += pivots
    return rows


def power_product(a: str, b: str, ratio: float) -> str:
    """Return the power product that does not change when a changes `ratio` times as much as b."""
    if not math.isfinite(ratio):
        return ''
    halves = round(2.0 * ratio)
    if abs(halves) > POWERS.most_halves:
        return ''
    if halves == 0:  # the other way round
        return power_product(b, a, 1.0 / ratio) if abs(ratio) > POWERS.round_ratio else ''
    if abs(2.0 * ratio - halves) > 2.0 * POWERS.round_ratio * max(1.0, abs(ratio)):
        return ''
    # d ln a = ratio * d ln b, so a / b^ratio stays.
    over, under = (1, abs(halves) // 2) if halves % 2 == 0 else (2, abs(halves))
    first = a if over == 1 else f'{a}^{over}'
    second = b if under == 1 else f'{b}^{under}'
    return f'{first}/{second}' if halves > 0 else f'{first}*{second}'
