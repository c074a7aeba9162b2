"""Derivatives of a plant's function, by forward differentiation of its recorded operations.

Griewank & Walther 2008, chapter 3 (the forward mode) and section 7.1 (sparsity): each operation
passes on the derivatives of its operands, of which only those that are not zero by structure are
computed. What the function computes already is shared.
"""

import contextlib
import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from types import FunctionType
from typing import Any

from obs_ros.core.differentials import CHOICES, CONSTANT, PARTIALS
from obs_ros.core.estimated_delays import plain
from obs_ros.core.plant_function import PerCandidate
from obs_ros.core.recorder import Operand, Recorder, Untraceable
from obs_ros.core.symbols import Symbol, operand
from obs_ros.core.tracing import compiled, recorded, written

ARGUMENTS = 't, h, x, u, v, p'


@dataclass(frozen=True)
class DifferenceSettings:
    """Forward differences where nothing can be recorded.

    - `step`: distance of two values of a state, relative to its size or its change in a step,
      whichever is larger: half of a float's digits (Press et al. 2007, section 5.7);
    - `smallest`: size that a state counts as at least, in its unit: at 0 none is known;
    - `share`: distance of two times, in integration steps: larger than the rounding of stamps.
    """

    step: float = 2.0**-26
    smallest: float = 1e-3
    share: float = 2.0**-10


DIFFERENCES = DifferenceSettings()


@dataclass(frozen=True)
class Linearisation:
    """A plant's f (n,) with its derivatives, as one function of numbers or arrays over candidates.

    `function(t, h, x, u, v, p)` returns a flat tuple: f, then the entries of df/dx at `places`
    (row, column), all others being zero, then df/dt + df/du v of the states `moving`, likewise.
    v are the inputs' slopes in units per s; the step h, in s, scales differences where `exact` is
    false: the function cannot be recorded, or its derivatives take too many operations.
    """

    function: FunctionType
    n: int
    places: tuple[tuple[int, int], ...]
    moving: tuple[int, ...]
    exact: bool


@functools.lru_cache(maxsize=64)
def linearisation(function: Callable[..., Any], n: int, m: int, q: int) -> Linearisation:
    """Return the derivatives of f(t, x, u, p), of n states, m inputs and q parameters."""
    if not isinstance(plain(function), PerCandidate):
        # Code that cannot be recorded raises whatever it meets.
        with contextlib.suppress(Exception):
            return differentiated(function, n, m, q)
    return by_differences(function, n, m)


def differentiated(function: Callable[..., Any], n: int, m: int, q: int) -> Linearisation:
    """Return exact derivatives; raises Untraceable, or what the function raises, if impossible."""
    recorder, results = recorded(function, (n, m, q), n, tuple)
    time, entries = n, list(map(operand, results))  # what varies: states, then all that time moves
    known: dict[Operand, dict[int, Any]] = {f'x[{j}]': {j: 1.0} for j in range(n)}
    known['t'] = {time: 1.0}
    known |= {f'u[{i}]': {time: Symbol(recorder, f'v[{i}]')} for i in range(m)}
    for place in _needed(recorder, entries):
        known[place] = _derivatives(recorder, place, known)
    slopes = [known.get(entry, {}) for entry in entries]
    places = tuple((i, j) for i in range(n) for j in sorted(slopes[i]) if j != time)
    moving = tuple(i for i in range(n) if time in slopes[i])
    found = [*(slopes[i][j] for i, j in places), *(slopes[i][time] for i in moving)]
    text = written(recorder, [*entries, *map(operand, found)], 'linearised', ARGUMENTS)
    return Linearisation(compiled(text, 'linearised'), n, places, moving, exact=True)


def _needed(recorder: Recorder, results: Sequence[Operand]) -> list[int]:
    """Return the nodes that the results depend on, in their order."""
    needed = {each for each in results if isinstance(each, int)}
    for place in reversed(range(len(recorder.nodes))):
        if place in needed:
            needed.update(each for each in recorder.nodes[place][1] if isinstance(each, int))
    return sorted(needed)


def _derivatives(
    recorder: Recorder, place: int, known: dict[Operand, dict[int, Any]]
) -> dict[int, Any]:
    """Return the derivatives of a node by all that it depends on."""
    template, operands = recorder.nodes[place]
    inner = [known.get(each, {}) for each in operands]
    seeds = sorted({seed for each in inner for seed in each})
    if not seeds or template in CONSTANT:
        return {}
    own, values = Symbol(recorder, place), [_value(recorder, each) for each in operands]
    if template in CHOICES:
        choose = CHOICES[template]
        found = {s: choose(values, [each.get(s, 0.0) for each in inner]) for s in seeds}
    elif template in PARTIALS:
        rules = PARTIALS[template]
        partials = [f(own, *values) if d else 0.0 for f, d in zip(rules, inner, strict=True)]
        found = {s: _total(partials, [each.get(s, 0.0) for each in inner]) for s in seeds}
    else:
        raise Untraceable(f'no derivative of {template.format("a", "b", "c")} is known')
    return {s: value for s, value in found.items() if isinstance(value, Symbol) or value != 0.0}


def _total(partials: Sequence[Any], inner: Sequence[Any]) -> Any:
    """Return the chain rule's sum of products."""
    total: Any = 0.0
    for partial, derivative in zip(partials, inner, strict=True):
        if not isinstance(partial, Symbol) and partial == -1.0:
            total = total - derivative
        else:
            total = total + partial * derivative
    return total


def _value(recorder: Recorder, each: Operand) -> Any:
    """Return the symbol, or the number, that an operand stands for."""
    if isinstance(each, int):
        return Symbol(recorder, each, is_condition(recorder.nodes[each][0]))
    try:
        number = float(each.strip('()').removeprefix('np.').replace('(-np.', '-'))
    except ValueError:
        return Symbol(recorder, each, each in ('True', 'False'))
    return int(number) if each.strip('()').lstrip('-').isdigit() else number


def is_condition(template: str) -> bool:
    """Whether an operation yields true or false."""
    words = '<', '>', '==', '!=', 'np.logical_', 'np.is', 'np.signbit'
    return any(word in template for word in words)


def by_differences(function: Callable[..., Any], n: int, m: int) -> Linearisation:
    """Return forward differences, lane by lane, of a function that cannot be recorded."""
    lines = ['f = dynamics(t, x, u, p)\n']
    found = [f'f[{i}]' for i in range(n)]
    columns: dict[tuple[int, int], str] = {}
    for j in range(n):
        size = (
            f'np.maximum(np.maximum(np.abs(x[{j}]), np.abs(h * f[{j}])), {DIFFERENCES.smallest!r})'
        )
        moved = ', '.join(f'y{j}' if i == j else f'x[{i}]' for i in range(n))
        lines.append(f'y{j} = x[{j}] + {DIFFERENCES.step!r} * {size}\n')
        lines.append(f'r{j} = 1.0 / (y{j} - x[{j}])\n')
        lines.append(f'f{j} = dynamics(t, ({moved},), u, p)\n')
        columns |= {(i, j): f'(f{j}[{i}] - f[{i}]) * r{j}' for i in range(n)}
    later = ''.join(f'u[{i}] + s * v[{i}], ' for i in range(m))
    lines.append(f's = {DIFFERENCES.share!r} * h\n')
    lines.append(f'later = dynamics(t + s, x, ({later}), p)\n')
    places = tuple(sorted(columns))
    found += [columns[place] for place in places]
    found += [f'(later[{i}] - f[{i}]) / s' for i in range(n)]
    body = ''.join(f'    {line}' for line in lines)
    text = f'def linearised({ARGUMENTS}):\n{body}    return ({", ".join(found)},)\n'
    made = compiled(text, 'linearised', dynamics=function)
    return Linearisation(made, n, places, tuple(range(n)), exact=False)
