"""Identity of a model: what it declares in words, and what it does at fixed points.

Its source says little: a function that is written in another way is the same plant, and one that
reads a constant from elsewhere may be another.
"""

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from obs_ros.core.model import Model, Variable, inside
from obs_ros.core.rng import random_generator
from obs_ros.core.texts import quoted
from obs_ros.core.typing import Array

POINTS = 8
SAME = 1e-9  # of the largest value at any point: libraries of mathematics differ in the last bits


@dataclass(frozen=True)
class Identity:
    """A model and the settings of its observer by name, in `words`, and its `behaviour` (P, S)."""

    words: Mapping[str, str]
    behaviour: Array


def declared(model: Model) -> dict[str, str]:
    """Return all that a model declares of itself and its variables, in words, by name."""
    found = {name: repr(getattr(model, name)) for name in ('name', 'kind', 'time', 'period')}
    for kind in ('state', 'input', 'output', 'parameter'):
        variables: tuple[Variable, ...] = getattr(model, f'{kind}s')
        found[f'{kind}s'] = ', '.join(variable.name for variable in variables)
        for variable in variables:
            for each in dataclasses.fields(variable):
                value = getattr(variable, each.name)
                if each.name != 'name' and value != each.default:
                    found[f'{each.name} of {kind} {variable.name}'] = repr(value)
    return found


@np.errstate(all='ignore')
def behaviour(model: Model) -> Array:
    """Return rates or next states, and outputs, (P, n + r) at fixed points inside the bounds."""
    rng = random_generator(0)

    def values(variables: tuple[Variable, ...]) -> tuple[Array, ...]:
        return tuple(_within(variable, rng.random(POINTS)) for variable in variables)

    t = 100.0 * np.arange(POINTS) / POINTS
    x, u, p = values(model.states), values(model.inputs), values(model.parameters)  # type: ignore[arg-type]
    columns = (*model.dynamics(t, x, u, p), *model.output(t, x, u, p))
    return np.array([np.broadcast_to(column, POINTS) for column in columns], dtype=float).T


def difference(there: Identity, here: Identity) -> str:
    """Say what differs first between two identities; '' if nothing does."""
    words, own, before, now = there.words, here.words, there.behaviour, here.behaviour
    for name in (*own, *words):
        if words.get(name) != own.get(name):
            was, is_now = (quoted(each[name]) if name in each else 'none' for each in (words, own))
            return f'{name} was {was}, and is {is_now}'
    if before.shape != now.shape:
        return 'the equations have another number of entries'
    size = np.nanmax(np.where(np.isfinite(now), np.abs(now), 0.0), axis=0, initial=0.0)
    same = (np.abs(before - now) <= SAME * size) | (before == now)
    same |= np.isnan(before) & np.isnan(now)
    if same.all():
        return ''
    point, column = np.argwhere(~same)[0]
    return (
        f'the equations are others: entry {column} of rates and outputs at point {point} was '
        f'{before[point, column]:.6g}, and is {now[point, column]:.6g}'
    )


def _within(variable: Variable, share: Array) -> Array:
    """Return values at shares (P,) of the way between the bounds, or of a range that is likely."""
    middle = inside(variable)
    width = variable.upper - variable.lower
    if np.isfinite(width):
        return np.asarray(variable.lower + share * width)
    low, high = middle - max(1.0, abs(middle)), middle + max(1.0, abs(middle))
    return np.clip(low + share * (high - low), variable.lower, variable.upper)
