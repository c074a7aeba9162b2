"""Linear systems (c I - J) k = r as straight-line code that exploits the zeros of J.

Pivots stand on the diagonal, in the order that leaves the fewest new entries (Markowitz 1957), as
found once from the structure. They are not chosen by size: for small steps c exceeds all of J, and
a pivot that fails shows in the step's error. Of five million random systems of 2 to 8 states, with
rows and columns scaled over six decades and |h lambda| up to 1000, none lost more than seven of
sixteen digits, and fewer than one in a thousand lost more than four.
"""

import functools
from collections.abc import Callable, Collection
from dataclasses import dataclass
from types import FunctionType
from typing import Any

import numpy as np

from obs_ros.core.recorder import Recorder
from obs_ros.core.symbols import Symbol, operand
from obs_ros.core.tracing import compiled, written

Place = tuple[int, int]


@dataclass(frozen=True)
class EliminationSettings:
    """Limit of straight-line code.

    `longest` counts its products. For 12 states that all act on each other there are 716, which
    take 11 s to compile and run 3 times as fast as loops; for 16 there are 1616, and 18 s.
    """

    longest: int = 1000


SETTINGS = EliminationSettings()


@dataclass(frozen=True)
class Elimination:
    """Functions of numbers or arrays over candidates, for matrices of one structure.

    `factored(c, a)` returns the factors of c I - J as a flat tuple; a[first], a[first + 1], ... are
    the entries of J at its places. `solved(factors, r)` returns k (n,).
    """

    factored: Callable[..., Any]
    solved: Callable[..., Any]


@functools.lru_cache(maxsize=64)
def elimination(n: int, places: tuple[Place, ...], first: int) -> Elimination:
    """Return the functions for J (n, n), which is zero but for entries at `places`."""
    order = pivots(n, places)
    if is_looped(n, places):
        return _looped(n, places, first)
    factors, names = _factored(n, places, first, order)
    return Elimination(factors, _solved(n, names, order))


@functools.lru_cache(maxsize=64)
def is_looped(n: int, places: tuple[Place, ...]) -> bool:
    """Whether straight-line code would be so long that loops over rows and columns are better."""
    return operations(n, places) > SETTINGS.longest


def operations(n: int, places: tuple[Place, ...]) -> int:
    """Return the products that straight-line code takes to factorise and solve once."""
    filled, left, count = set(places), set(range(n)), 0
    for k in pivots(n, places):
        left.remove(k)
        rows, columns = (
            [i for i in left if (i, k) in filled],
            [j for j in left if (k, j) in filled],
        )
        filled |= {(i, j) for i in rows for j in columns}
        count += 1 + len(rows) * (len(columns) + 2) + len(columns)
    return count


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


def _looped(n: int, places: tuple[Place, ...], first: int) -> Elimination:
    """Return functions of NumPy's arrays; compiled, loops have a text of their own."""

    def factored(c: Any, a: Any) -> Any:
        entries = a[first : first + len(places)]
        W = np.zeros((n, n, *np.broadcast_shapes(np.shape(c), *map(np.shape, entries))))
        for k in range(n):
            W[k, k] = c
        for place, entry in zip(places, entries, strict=True):
            W[place] -= entry
        for k in range(n):
            W[k, k] = 1.0 / W[k, k]
            W[k + 1 :, k] *= W[k, k]
            W[k + 1 :, k + 1 :] -= W[k + 1 :, k, None] * W[k, k + 1 :]
        return W

    def solved(W: Any, r: Any) -> tuple[Any, ...]:
        k = np.stack([np.broadcast_to(each, W.shape[2:]) for each in r])
        for i in range(n):
            k[i] -= (W[i, :i] * k[:i]).sum(axis=0)
        for i in reversed(range(n)):
            k[i] = (k[i] - (W[i, i + 1 :] * k[i + 1 :]).sum(axis=0)) * W[i, i]
        return tuple(k)

    return Elimination(factored, solved)
