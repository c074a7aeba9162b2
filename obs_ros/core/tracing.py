"""A plant's function as straight-line code: recorded once with symbols, written anew.

Loops over tuples, arrays, objects and helpers leave nothing but the operations on numbers that they
come to. Where a function branches on values it is recorded once for every way through it, and the
results are selected: all ways are computed for every candidate.
"""

import importlib
import linecache
from collections.abc import Callable, Sequence
from types import FunctionType
from typing import Any

import numpy as np

from obs_ros.core.fingerprint import fingerprint
from obs_ros.core.recorder import LIMITS, TOO_MANY, Operand, Recorder, Untraceable
from obs_ros.core.symbols import Symbol, operand
from obs_ros.core.twins import Twins

DEEPEST = 12  # brackets in one another, so that lines stay readable and the parser's stack small


def traced(
    function: Callable[..., Any], sizes: Sequence[int], entries: int, vectors: Callable[..., Any]
) -> FunctionType:
    """Return the straight-line function of (t, x, u, p) that computes the same.

    x, u and p, of these `sizes`, are handed to the function as `vectors`, tuple or np.array, makes
    them. Raises Untraceable where it computes what cannot be recorded, or returns something else
    than `entries` numbers, and whatever the function itself raises.
    """
    recorder, results = recorded(function, sizes, entries, vectors)
    name = getattr(function, '__name__', type(function).__name__)
    return compiled(written(recorder, [operand(r) for r in results], name), name)


def recorded(
    function: Callable[..., Any],
    sizes: Sequence[int],
    entries: int,
    vectors: Callable[..., Any],
    recorder: Recorder | None = None,
) -> tuple[Recorder, tuple[Any, ...]]:
    """Return the operations of a function, recorded by this `recorder`, and its results.

    See `traced`.
    """
    recorder, twin = recorder or Recorder(), Twins().twin(function)
    arguments = [Symbol(recorder, 't')]
    for vector, size in zip('xup', sizes, strict=True):
        symbols = [Symbol(recorder, f'{vector}[{i}]') for i in range(size)]
        arguments.append(vectors(symbols))
    return recorder, _explored(lambda: unpacked(twin(*arguments), entries), entries, recorder, ())


def unpacked(returned: Any, entries: int) -> tuple[Any, ...]:
    """Return the numbers of what a function returns: a tuple, a list or an array of one dimension.

    Raises TypeError if it is nothing of that kind.
    """
    if isinstance(returned, np.ndarray) and returned.shape == (entries,):
        returned = tuple(returned)
    if not isinstance(returned, list | tuple) or len(returned) != entries:
        raise TypeError(f'return a tuple, a list or an array of {entries} numbers')
    return tuple(v.item() if isinstance(v, np.ndarray) and v.size == 1 else v for v in returned)


def _explored(
    call: Callable[[], tuple[Any, ...]],
    entries: int,
    recorder: Recorder,
    decisions: tuple[bool, ...],
) -> tuple[Any, ...]:
    """Return the results over all ways through a function that begin with these decisions.

    A way that raises an error of values, as a `raise` after a check does, has NaN as its result.
    """
    recorder.begin(decisions)
    try:
        results = call()
    except (ArithmeticError, ValueError, AssertionError):
        if not recorder.taken:
            raise
        results = (np.nan,) * entries
    taken = list(recorder.taken.items())
    for place in reversed(range(len(decisions), len(taken))):
        ahead = tuple(way for _, way in taken[:place])
        others = _explored(call, entries, recorder, (*ahead, False))
        results = tuple(
            Symbol(recorder, recorder.merged(taken[place][0], *map(operand, both)))
            for both in zip(results, others, strict=True)
        )
    return results


def written(
    recorder: Recorder, results: Sequence[Operand], name: str, arguments: str = 't, x, u, p'
) -> str:
    """Return the text of a function of these arguments that computes these results.

    What is used once stands where it is used, so that NumPy reuses its memory.
    """
    uses, needed = [0] * len(recorder.nodes), [r for r in results if isinstance(r, int)]
    for place in needed:
        uses[place] += 1
    for place in reversed(range(len(recorder.nodes))):
        if uses[place]:
            for each in recorder.nodes[place][1]:
                if isinstance(each, int):
                    uses[each] += 1
    if sum(map(bool, uses)) > LIMITS.operations:
        raise Untraceable(TOO_MANY)
    lines: list[str] = []
    texts: dict[Operand, str] = {}  # of nodes that stand where they are used, or have a name
    depths: dict[Operand, int] = {}

    def text(each: Operand) -> str:
        return texts.get(each, str(each))

    for place, (template, operands) in enumerate(recorder.nodes):
        if not uses[place]:
            continue
        depth = 1 + max((depths.get(each, 0) for each in operands), default=0)
        whole = template.format(*map(text, operands))
        if uses[place] == 1 and depth < DEEPEST:
            texts[place] = whole if template.startswith(('np.', 'special.')) else f'({whole})'
            depths[place] = depth
        else:
            lines.append(f'    v{place} = {whole}\n')
            texts[place] = f'v{place}'
    name = name if name.isidentifier() else 'function'
    values = ', '.join(map(text, results))
    return f'def {name}({arguments}):\n{"".join(lines)}    return ({values},)\n'


def compiled(text: str, name: str, **used: Callable[..., Any]) -> FunctionType:
    """Return the function of a text, which tracebacks show, with the functions that it calls."""
    file = f'<straight-line {name} {fingerprint(text)}>'
    linecache.cache[file] = len(text), None, text.splitlines(keepends=True), file
    scope: dict[str, Any] = {'np': np, '__name__': __name__, **used}
    if 'special.' in text:
        scope['special'] = importlib.import_module('scipy.special')
    exec(compile(text, file, 'exec'), scope)
    made: FunctionType = scope[name if name.isidentifier() else 'function']
    return made
