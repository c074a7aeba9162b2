"""Linear systems (c I - J) k = r as straight-line code that exploits the zeros of J.

Pivots stand on the diagonal, in the order that leaves the fewest new entries (Markowitz 1957), as
found once from the structure. They are not chosen by size: for small steps c exceeds all of J, and
a pivot that fails shows in the step's error.
"""

import functools
from collections.abc import Collection
from dataclasses import dataclass
from types import FunctionType
from typing import Any

from obs_ros.core.recorder import Recorder
from obs_ros.core.symbols import Symbol, operand
from obs_ros.core.tracing import compiled, written

Place = tuple[int, int]


@dataclass(frozen=True)
class Elimination:
    """Functions of numbers or arrays over candidates, for matrices of one structure.

    `factored(c, a)` returns the factors of c I - J as a flat tuple; a[first], a[first + 1], ... are
    the entries of J at its places. `solved(factors, r)` returns k (n,).
    """

    factored: FunctionType
    solved: FunctionType


@functools.lru_cache(maxsize=64)
def elimination(n: int, places: tuple[Place, ...], first: int) -> Elimination:
    """Return the functions for J (n, n), which is zero but for entries at `places`."""
    order = pivots(n, places)
    factors, names = _factored(n, places, first, order)
    return Elimination(factors, _solved(n, names, order))


def pivots(n: int, places: Collection[Place]) -> list[int]:
    """Return the order of elimination: next is the pivot that can leave the fewest entries."""
    rows: list[set[int]] = [{j for i, j in places if i == k and j != k} for k in range(n)]
    columns: list[set[int]] = [{i for i, j in places if j == k and i != k} for k in range(n)]
    order: list[int] = []
    left = set(range(n))
    while left:
        k = min(left, key=lambda i: (len(rows[i] & left) * len(columns[i] & left), i))
        order.append(k)
        left.remove(k)
        for i in columns[k] & left:
            rows[i] |= (rows[k] & left) - {i}
        for j in rows[k] & left:
            columns[j] |= (columns[k] & left) - {j}
    return order


def _factored(
    n: int, places: tuple[Place, ...], first: int, order: list[int]
) -> tuple[FunctionType, dict[Place, int]]:
    """Return the function that factorises, and where in its tuple each factor stands.

    Off the diagonal B is J, and -(c I - J); on it D is c I - J. A pivot leaves its reciprocal, the
    entries below it their multipliers.
    """
    recorder = Recorder()
    B: dict[Place, Any] = {
        place: Symbol(recorder, f'a[{first + at}]') for at, place in enumerate(places)
    }
    D = [Symbol(recorder, 'c') - B.pop((k, k), 0.0) for k in range(n)]
    factors: dict[Place, Any] = {}
    for at, k in enumerate(order):
        factors[k, k] = inverse = 1.0 / D[k]
        after = order[at + 1 :]
        row = [j for j in after if (k, j) in B]
        factors |= {(k, j): B[k, j] for j in row}
        for i in after:
            if (i, k) in B:
                factors[i, k] = multiplier = B[i, k] * inverse
                for j in row:
                    product = multiplier * B[k, j]
                    if i == j:
                        D[i] = D[i] - product
                    else:
                        B[i, j] = B.get((i, j), 0.0) + product
    text = written(recorder, [operand(f) for f in factors.values()], 'factored', 'c, a')
    return compiled(text, 'factored'), {place: at for at, place in enumerate(factors)}


def _solved(n: int, names: dict[Place, int], order: list[int]) -> FunctionType:
    """Return the function that solves: forward through the multipliers, back through the rows."""
    recorder = Recorder()
    F = {place: Symbol(recorder, f'F[{at}]') for place, at in names.items()}
    k: list[Any] = [Symbol(recorder, f'r[{i}]') for i in range(n)]
    for at, pivot in enumerate(order):
        for i in order[at + 1 :]:
            if (i, pivot) in F:
                k[i] = k[i] + F[i, pivot] * k[pivot]
    for at, pivot in reversed(list(enumerate(order))):
        for j in order[at + 1 :]:
            if (pivot, j) in F:
                k[pivot] = k[pivot] + F[pivot, j] * k[j]
        k[pivot] = k[pivot] * F[pivot, pivot]
    text = written(recorder, [operand(each) for each in k], 'solved', 'F, r')
    return compiled(text, 'solved')
