"""Parameters that no input can tell apart: structural identifiability, tested by numbers.

At random points of the boxes, under random inputs and initial states, the outputs' sensitivities
have the rank that nearly all points and inputs give (local structural identifiability; Bellman &
Astrom 1970; the rank test of Stigter & Molenaar 2015). A direction without sensitivity at every
point is one that no input reveals; how it turns from point to point says whether a product or a sum
of two parameters is left.
"""

import math
import time
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import combinations
from typing import Any

import numpy as np

from obs_ros.core.linear_algebra import singular
from obs_ros.core.model import Variable, inside
from obs_ros.core.record import Record
from obs_ros.core.typing import Array
from obs_ros.inference.assessment.power_products import power_product, sparse
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.integration.backends import Kernels
from obs_ros.integration.grid import Grid


@dataclass(frozen=True)
class StructuralSettings:
    """Effort and limits of the test.

    - `points`: of the parameters, at each of which the same directions must be without effect;
    - `amplitudes`: of inputs without bounds, in units of their nominal values, one experiment each;
    - `nodes`: samples of an experiment, which lasts as long as a window;
    - `middle`: share of the boxes, about their middles, in which points lie;
    - `difference` (boxes): of central differences, whose error is 1e-9 of a derivative;
    - `rank`: singular value, of the largest, below which a direction has no effect;
    - `support`: share of a direction's largest entry below which a parameter does not belong to it;
    - `constant`: relative change from point to point of what counts as constant;
    - `steps`: of the model in an experiment, without and with a compiler; longer windows are not
      tested, which takes less than a second otherwise;
    - `longest` (s of the processor): after which nothing is claimed, as the model is too slow.
    """

    points: int = 3
    amplitudes: tuple[float, ...] = (0.5, 2.0, 10.0)
    nodes: int = 100
    middle: float = 0.6
    difference: float = 1e-5
    rank: float = 1e-6
    support: float = 1e-3
    constant: float = 1e-2
    steps: tuple[int, int] = (2_000, 200_000)
    longest: float = 1.0


STRUCTURAL = StructuralSettings()


@dataclass(frozen=True)
class Confounded:
    """Parameters that no input tells apart, by name; `quantity` is what is left of two of them."""

    names: tuple[str, ...]
    quantity: str = ''

    def __str__(self) -> str:
        if len(self.names) == 1:
            return f'no input can tell {self.names[0]}, on which no output depends: fix it'
        if not self.quantity:
            apart = f'{", ".join(self.names[:-1])} and {self.names[-1]}'
            return f'no input can tell {apart} apart: fix one'
        a, b = self.names
        kinds = {f'{a}*{b}': 'product', f'{b}*{a}': 'product', f'{a} + {b}': 'sum'}
        kind = f'their {kinds[self.quantity]}' if self.quantity in kinds else self.quantity
        return f'no input can tell {a} from {b}: fix one, or estimate {kind}'


@dataclass(frozen=True)
class _Case:
    """What is tested, known again by its key."""

    key: tuple[Any, ...]
    kernels: Kernels = field(compare=False)
    unknowns: Unknowns = field(compare=False)
    seconds: float = field(compare=False)


def confounded(kernels: Kernels, unknowns: Unknowns, seconds: float) -> tuple[Confounded, ...]:
    """Return the estimated parameters that no input tells apart in windows of so many seconds.

    The initial state is unknown. The answer is kept; it is empty where the model is too slow or
    diverges. Windows of about the same length share it.
    """
    arrays = unknowns.index, unknowns.scale.lower, unknowns.scale.upper, unknowns.given
    lengths = round(2.0 * math.log2(seconds)) if seconds > 0.0 else 0
    key = (
        kernels.name,
        kernels.model.method,
        unknowns.model,
        lengths,
        *(a.tobytes() for a in arrays),
    )
    return _confounded(_Case(key, kernels, unknowns, seconds))


@lru_cache(maxsize=64)
def _confounded(case: _Case) -> tuple[Confounded, ...]:
    unknowns, n = case.unknowns, case.unknowns.n_states
    q = unknowns.dimension - n
    end, rng = time.thread_time() + STRUCTURAL.longest, np.random.default_rng(0)
    steps = case.seconds / unknowns.model.max_step
    if not q or not case.seconds > 0.0 or steps > STRUCTURAL.steps[case.kernels.name == 'numba']:
        return ()
    found: list[tuple[Array, Array]] = []
    for _ in range(STRUCTURAL.points):
        places = 0.5 + STRUCTURAL.middle * (rng.random(q) - 0.5)
        blind = _without_effect(case, places, rng, end)
        if blind is None or not len(blind):
            return ()
        point = np.concatenate([np.full(n, 0.5), places])
        found.append((unknowns.scale.values(point)[n:], blind * unknowns.scale.slopes(point)[n:]))
    if len({len(blind) for _, blind in found}) > 1:
        return ()
    return _named(unknowns.names[n:], found)


def _without_effect(
    case: _Case, places: Array, rng: np.random.Generator, end: float
) -> Array | None:
    """Return directions (k, q), in boxes, without effect at a point of parameters (q,).

    None where there was no time, or no rollout stays finite.
    """
    n, q = case.unknowns.n_states, places.size
    norms, parts, blind = np.zeros(q), [np.empty((0, q))], None
    for amplitude in STRUCTURAL.amplitudes:
        jacobian = _jacobian(case, places, amplitude, rng)
        if time.thread_time() > end:
            return None
        if not np.isfinite(jacobian).all():
            continue
        start, rest = jacobian[:, :n], jacobian[:, n:]
        size = np.sqrt((start**2).sum(axis=0))
        left, s, _ = singular(start[:, size > 0.0] / size[size > 0.0])
        left = left[:, s > STRUCTURAL.rank * s[:1]]
        norms = np.hypot(norms, np.sqrt((rest**2).sum(axis=0)))
        parts.append(rest - left @ (left.T @ rest))
        whole = np.where(norms > 0.0, norms, 1.0)
        _, s, directions = singular(np.concatenate(parts) / whole)
        blind = np.asarray(directions[s <= STRUCTURAL.rank * s[0]] / whole)
        if not len(blind):
            break
    return blind


def _jacobian(case: _Case, places: Array, amplitude: float, rng: np.random.Generator) -> Array:
    """Return the outputs' derivatives (N, d) by the unknowns, in boxes, in a random experiment."""
    unknowns, model = case.unknowns, case.unknowns.model
    n = len(model.states)
    t = np.linspace(0.0, case.seconds, STRUCTURAL.nodes)
    u = np.column_stack(
        [_moved(v, amplitude, rng) for v in model.inputs] or [np.empty((t.size, 0))]
    )
    record = Record(t, u, np.zeros((t.size, len(model.outputs))))
    grid = Grid.of(model, record, np.ones(len(model.outputs)))
    start = 0.5 + STRUCTURAL.middle * (rng.random(unknowns.n_states) - 0.5)
    z, d = np.concatenate([start, places]), unknowns.dimension
    points = np.repeat(z[None], 2 * d, axis=0)
    for sign, rows in ((1.0, slice(0, d)), (-1.0, slice(d, 2 * d))):
        points[rows] += sign * STRUCTURAL.difference * np.eye(d)
    lanes = np.repeat(unknowns.given[:, None], 2 * d, axis=1)
    lanes[unknowns.index] = unknowns.scale.values(points).T
    with np.errstate(all='ignore'):
        _, y = case.kernels.trajectories(grid, lanes[:n], lanes[n:])
        size = y.std(axis=(0, 2))
        size = np.where(size > 0.0, size, 1.0)
        change = (y[:, :, :d] - y[:, :, d:]) / (2.0 * STRUCTURAL.difference)
        return np.asarray((change / size[:, None]).reshape(-1, d))


def _moved(variable: Variable, amplitude: float, rng: np.random.Generator) -> Array:
    """Return a random input (N,): levels held for some samples, with noise on top."""
    nodes = STRUCTURAL.nodes
    hold = int(rng.integers(5, 25))
    random = 0.8 * np.repeat(rng.uniform(-1.0, 1.0, nodes), hold)[:nodes]
    random += 0.2 * rng.uniform(-1.0, 1.0, nodes)
    middle, reach = inside(variable), amplitude * max(abs(inside(variable)), 1.0)
    if math.isfinite(variable.lower) and math.isfinite(variable.upper):
        middle, reach = (
            0.5 * (variable.lower + variable.upper), 0.5 * (variable.upper - variable.lower)
        )  # fmt: skip
    moved: Array = np.clip(middle + reach * random, variable.lower, variable.upper)
    return moved


def _named(names: tuple[str, ...], found: list[tuple[Array, Array]]) -> tuple[Confounded, ...]:
    """Name directions, given as values (q,) and changes (k, q) of them at every point."""
    values = np.array([p for p, _ in found])
    pivots: list[int] = []
    changes = np.array([sparse(blind, pivots) for _, blind in found])  # (points, k, q)
    named = []
    for k in range(changes.shape[1]):
        size = np.abs(changes[:, k] / np.maximum(np.abs(values), 1e-300))
        member = (size > STRUCTURAL.support * size.max(axis=1, keepdims=True)).any(axis=0)
        group = np.flatnonzero(member)
        quantity = ''
        if group.size == 2:
            pair = names[group[0]], names[group[1]]
            quantity = _quantity(pair, values[:, group], changes[:, k][:, group])
        named.append(Confounded(tuple(names[i] for i in group), quantity))
    return tuple(named)


def _quantity(names: tuple[str, str], values: Array, changes: Array) -> str:
    """Return what stays while two parameters change, from values and changes (points, 2)."""
    with np.errstate(all='ignore'):
        ratios = changes[:, 0] / changes[:, 1]
        relative = ratios * values[:, 1] / values[:, 0]
    a, b = names
    if _is_constant(relative):
        return power_product(a, b, float(relative.mean()))
    if not _is_constant(ratios):
        return ''
    ratio = float(ratios.mean())  # a - ratio * b stays
    sign = '+' if ratio < 0.0 else '-'
    share = '' if abs(abs(ratio) - 1.0) < STRUCTURAL.constant else f'{abs(ratio):.3g}*'
    return f'{a} {sign} {share}{b}'


def _is_constant(ratios: Array) -> bool:
    pairs = combinations(ratios, 2)
    return bool(
        np.isfinite(ratios).all()
        and all(abs(a - b) <= STRUCTURAL.constant * max(abs(a), abs(b)) for a, b in pairs)
    )
