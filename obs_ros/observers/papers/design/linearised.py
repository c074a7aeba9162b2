"""Any model about its nominal point, as the design of gains wants plants."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from obs_ros.core.model import Model, Variable, inside, names
from obs_ros.core.registry import suggest
from obs_ros.core.texts import quoted
from obs_ros.core.typing import Array
from obs_ros.observers.papers.design.plants import LipschitzPlant


@dataclass(frozen=True)
class LinearisationSettings:
    """How a model's equations become matrices."""

    points: int = 200  # random ones of the box, where the effects of the parameters are looked at
    seed: int = 0  # of these
    step: float = 6e-6  # of a half range, in central differences: eps^(1/3)
    rank: float = 1e-6  # of the largest singular value: below, a direction is none
    flat: float = 1e-6  # of the largest slope of the effects: a smaller one is rounding
    effect_step: float = 1e-3  # of a half range, for the slopes of effects: second differences


LINEARISATION = LinearisationSettings()


def linearised(
    model: Model,
    parameters: Sequence[str],
    *,
    share: float = 0.2,
    disturbances: Sequence[str] = (),
    settings: LinearisationSettings = LINEARISATION,
) -> LipschitzPlant:
    """Return a model about its nominal point, with `parameters` (q) off by a `share` of nominal.

    x' = A x + B Phi2(x, u) (theta - theta0) + N eta. A and C are derivatives at the nominal point;
    B (n, l) spans the effects that the parameters have on x' over the box of x and u. E has a row
    for each state on which they depend, times the largest slope there, and gamma is the root of the
    number of rows. N (n, m) is the effect of the parameters that are `disturbances`, each of half
    its range; without any it pushes each state by its scale, half its range, in 1 s. How A changes
    over the box is left out: `stable_share` tells what becomes of the gains there.

    Raises ValueError for unknown names, and a parameter on which no rate depends.
    """
    x, u, p = (np.array([inside(v) for v in group]) for group in _groups(model))
    scale = np.array([_half_range(v) for v in model.states])
    chosen = [_place(model, name) for name in parameters]
    sized = [(j, share * (abs(p[j]) or _half_range(model.parameters[j]))) for j in chosen]

    def effects(x: Array, u: Array) -> Array:
        return np.array([_effect(model, x, u, p, j, d) for j, d in sized]).T

    rng = np.random.default_rng(settings.seed)
    points = [[_random(g, rng) for g in _groups(model)[:2]] for _ in range(settings.points)]
    found = np.array([effects(*point) for point in points]) / scale[:, None]
    for name, size in zip(parameters, np.abs(found).max(axis=(0, 1)), strict=True):
        if not size > 0.0:
            raise ValueError(f'leave {name} out: no rate of {model.name} depends on it')
    B = scale[:, None] * _basis(np.concatenate(list(found), axis=1), settings.rank)
    back = np.asarray(np.linalg.pinv(B), dtype=np.float64)
    slopes = _steepest(effects, back, points, settings.effect_step * scale)
    A, C = _slopes(model, x, u, p, settings.step * scale)
    rows = np.flatnonzero(slopes * scale > settings.flat * (slopes * scale).max())
    return LipschitzPlant(
        A=A,
        B=B,
        C=C,
        N=_pushes(model, disturbances, x, u, p) if disturbances else np.diag(scale),
        E=np.diag(slopes)[rows] if rows.size else np.zeros((1, x.size)),
        gamma=float(np.sqrt(rows.size)),
        scale=scale,
        disturbance=1.0,
    )


def stable_share(
    model: Model, L: Array, settings: LinearisationSettings = LINEARISATION
) -> tuple[int, int]:
    """Return at how many random points of the box A - L C (n, n) is stable, and of how many."""
    rng, stable = np.random.default_rng(settings.seed), 0
    steps = settings.step * np.array([_half_range(v) for v in model.states])
    for _ in range(settings.points):
        x, u, p = (_random(group, rng) for group in _groups(model))
        A, C = _slopes(model, x, u, p, steps)
        stable += bool(np.linalg.eigvals(A - L @ C).real.max() < 0.0)
    return stable, settings.points


def _slopes(model: Model, x: Array, u: Array, p: Array, steps: Array) -> tuple[Array, Array]:
    """Return the derivatives of rates (n, n) and outputs (r, n) by the states."""
    A = derivative(lambda z: _rates(model, z, u, p), x, steps)
    return A, derivative(lambda z: _outputs(model, z, u, p), x, steps)


def derivative(function: Callable[[Array], Array], x: Array, steps: Array) -> Array:
    """Return central differences (..., n) of a function at x (n,), with a step for each entry."""
    columns = []
    for i, step in enumerate(steps):
        moved = np.zeros_like(x)
        moved[i] = step
        columns.append((function(x + moved) - function(x - moved)) / (2.0 * step))
    return np.stack(columns, axis=-1)


def _steepest(
    effects: Callable[[Array, Array], Array],
    back: Array,
    points: Sequence[Sequence[Array]],
    steps: Array,
) -> Array:
    """Return the largest slopes (n,) by the states of `back` (l, n) times the effects (n, q)."""

    def pulled(x: Array, fed: Array) -> Array:
        return back @ effects(x, fed)

    slopes = np.zeros(steps.size)
    for at, fed in points:
        # (l, q, n)
        changes = derivative(partial(pulled, fed=fed), at, steps)
        slopes = np.maximum(slopes, np.linalg.norm(changes, axis=0).sum(axis=0))
    return slopes


def _groups(model: Model) -> tuple[Sequence[Variable], Sequence[Variable], Sequence[Variable]]:
    return model.states, model.inputs, model.parameters


def _rates(model: Model, x: Array, u: Array, p: Array) -> Array:
    return np.array(model.dynamics(0.0, tuple(x), tuple(u), tuple(p)), dtype=np.float64)


def _outputs(model: Model, x: Array, u: Array, p: Array) -> Array:
    return np.array(model.output(0.0, tuple(x), tuple(u), tuple(p)), dtype=np.float64)


def _effect(model: Model, x: Array, u: Array, p: Array, j: int, amount: float) -> Array:
    """Return the effect (n,) on the rates of so much of parameter j, about its value."""
    moved = np.zeros_like(p)
    moved[j] = 1e-3 * amount
    rates = (_rates(model, x, u, p + side * moved) for side in (1.0, -1.0))
    return np.asarray(next(rates) - next(rates)) / 2e-3


def _pushes(model: Model, disturbances: Sequence[str], x: Array, u: Array, p: Array) -> Array:
    """Return the effect (n, m) on the rates of each disturbance, of half its range."""
    places = [_place(model, name) for name in disturbances]
    sizes = [_half_range(model.parameters[j]) for j in places]
    return np.array([_effect(model, x, u, p, j, d) for j, d in zip(places, sizes, strict=True)]).T


def _place(model: Model, name: str) -> int:
    known = names(model.parameters)
    if name not in known:
        raise ValueError(f'{model.name} has no parameter {quoted(name)}: {suggest(name, known)}')
    return known.index(name)


def _basis(columns: Array, rank: float) -> Array:
    """Return unit vectors (n, l) that span the columns; the largest entry of each is positive."""
    left, size, _ = np.linalg.svd(columns, full_matrices=False)
    kept = left[:, size > rank * size[0]]
    largest = kept[np.abs(kept).argmax(axis=0), np.arange(kept.shape[1])]
    return np.asarray(kept * np.sign(largest))


def _half_range(variable: Variable) -> float:
    """Return half the width of the bounds, or the size of the variable where they are infinite."""
    half = 0.5 * (variable.upper - variable.lower)
    return half if np.isfinite(half) else abs(inside(variable)) or 1.0


def _random(variables: Sequence[Variable], rng: np.random.Generator) -> Array:
    """Return values within the bounds, of unbounded ones within their half range of `inside`."""
    shares = rng.uniform(-1.0, 1.0, len(variables))
    middles = [
        0.5 * (v.lower + v.upper) if np.isfinite(v.upper - v.lower) else inside(v)
        for v in variables
    ]
    return np.array(
        [m + share * _half_range(v) for m, share, v in zip(middles, shares, variables, strict=True)]
    )
