"""A plant's function as its author wrote it becomes one that all backends run.

One that is straight-line already, on tuples, stays as it is. Any other is recorded and written anew
(`tracing`). Where that is impossible it is called candidate by candidate, which is right but slow.
"""

import inspect
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from types import FunctionType, MethodType
from typing import Any

import numpy as np

from obs_ros.core import model_check
from obs_ros.core.model_check import Vectors
from obs_ros.core.recorder import Untraceable
from obs_ros.core.straight_line import is_straight
from obs_ros.core.texts import quoted
from obs_ros.core.tracing import traced, unpacked

ORDER = ('t', 'x', 'u', 'p')
# Names by which arguments are known when they stand in another's place.
_ALIASES = {
    't': 't', 'time': 't', 'x': 'x', 'state': 'x', 'states': 'x', 'u': 'u', 'input': 'u',
    'inputs': 'u', 'control': 'u', 'controls': 'u', 'p': 'p', 'par': 'p', 'pars': 'p',
    'param': 'p', 'params': 'p', 'parameter': 'p', 'parameters': 'p', 'theta': 'p',
}  # fmt: skip
_AGREEMENT = 1e-9  # relative: recorded operations are those of the function, in their order


@dataclass(frozen=True)
class PerCandidate:
    """A function that is called once for every candidate, as no compiler can take it.

    `reason` says why not, with the line and the cure. Errors of values, as a `raise` after a check
    is, make NaN of a candidate.
    """

    function: Callable[..., Any]
    entries: int
    vectors: Callable[..., Any]
    reason: str

    def __call__(self, t: Any, x: Any, u: Any, p: Any) -> tuple[Any, ...]:
        """Return one number, or array over candidates, for each entry."""
        columns = np.broadcast_arrays(*(np.asarray(v, dtype=np.float64) for v in (t, *x, *u, *p)))
        points = np.stack([column.ravel() for column in columns], axis=1).tolist()
        cuts = slice(1, 1 + len(x)), slice(1 + len(x), 1 + len(x) + len(u)), slice(
            1 + len(x) + len(u), None
        )  # fmt: skip
        with np.errstate(all='ignore'):
            found = np.array([self.at(row[0], *(row[cut] for cut in cuts)) for row in points])
        shaped = found.T.reshape(self.entries, *columns[0].shape)
        return tuple(shaped) if columns[0].ndim else tuple(map(float, shaped))

    def at(self, t: float, *vectors: list[float]) -> list[float]:
        """Return the entries at one point; NaN where its values raise an error."""
        try:
            returned = self.function(t, *map(self.vectors, vectors))
            return [float(entry) for entry in unpacked(returned, self.entries)]
        except (ArithmeticError, AssertionError, ValueError):
            return [np.nan] * self.entries


@dataclass(frozen=True)
class Trial:
    """Arguments to try a function with, its vectors' names, and the names of its entries.

    Entries of the arguments are arrays over `lanes` candidates.
    """

    arguments: tuple[Any, ...]
    vectors: Vectors
    names: tuple[str, ...]
    lanes: int

    def points(self) -> list[tuple[Any, ...]]:
        """Return the arguments of each candidate."""
        t, *vectors = self.arguments
        return [
            (t, *([float(value[k]) for value in vector] for vector in vectors))
            for k in range(self.lanes)
        ]


def normalised(given: Any, trial: Trial) -> Callable[..., Any]:
    """Return the function of (t, x, u, p) for all backends.

    Raises ValueError, with the line and the remedy, where it takes other arguments, fails, returns
    something else than one number for each entry, or is finite nowhere.
    """
    given = getattr(given, 'py_func', given)  # as written, where its author compiled it
    if isinstance(given, PerCandidate):  # of another model, whose reason names the author's line
        given = given.function
    code = underlying(given)
    if code is None:
        raise ValueError(f'must be a function of (t, x, u, p), not {quoted(given)}')
    if order := misplaced(given):
        raise ValueError(f'must take (t, x, u, p) in this order, not ({order})'
                         f' ({model_check.place(code)})')  # fmt: skip
    written = given if isinstance(given, FunctionType) else None
    error: ValueError | None = None
    try:
        checked(given, code, trial, given)
    except ValueError as raised:
        error = raised
    else:
        if written is not None and is_straight(written):
            return written
    try:
        return recorded(given, code, trial)
    except Untraceable as refused:
        reason = str(refused)
    failures = []
    for vectors in (tuple, np.array):
        single = PerCandidate(given, len(trial.names), vectors, reason)
        if error is None and written is not None and _agrees(written, single, trial):
            return written
        try:
            checked(single, code, trial, given)
        except ValueError as raised:
            failures.append(raised)
        else:
            return single
    raise failures[0] if error is None or model_check.is_for_numbers(error) else error


def recorded(given: Any, code: FunctionType, trial: Trial) -> FunctionType:
    """Return the function's operations as a function; Untraceable, with the line, if impossible.

    Raises ValueError as `normalised` does where the result is finite nowhere.
    """
    sizes = [len(vector) for vector in trial.arguments[1:]]
    reasons = []
    for vectors in (tuple, np.array):
        try:
            made = traced(given, sizes, len(trial.names), vectors)
        except Exception as error:
            why = str(error) if isinstance(error, Untraceable) else quoted(error)
            reasons.append(f'{why} ({model_check.place(code, error.__traceback__)})')
            continue
        if not _agrees(made, PerCandidate(given, len(trial.names), vectors, ''), trial):
            raise Untraceable(
                'let results depend on t, x, u and p only: they differ when it is called again '
                f'({model_check.place(code)})'
            )
        returned = model_check.called(made, code, trial.arguments, trial.vectors)
        model_check.check_finite(given, code, trial.arguments, returned, trial.names, trial.vectors)
        made.__wrapped__ = given  # type: ignore[attr-defined]  # whose lines are the author's
        return made
    raise Untraceable(reasons[0])


def checked(function: Callable[..., Any], code: FunctionType, trial: Trial, given: Any) -> None:
    """Raise ValueError unless the function returns a tuple of finite arrays over candidates."""
    on = 'candidate by candidate' if function is not given else 'on arrays over candidates'
    returned = model_check.called(function, code, trial.arguments, trial.vectors, on)
    model_check.check_returned(code, returned, trial.names, trial.lanes)
    model_check.check_finite(given, code, trial.arguments, returned, trial.names, trial.vectors)


def _agrees(function: Callable[..., Any], single: PerCandidate, trial: Trial) -> bool:
    """Whether a function of arrays over candidates does the same as one call for each."""
    with np.errstate(all='ignore'):
        together = function(*trial.arguments)
        try:
            theirs = np.array([single.at(*point) for point in trial.points()]).T
        except Exception:  # it takes arrays only
            return True
    ours = np.array([np.broadcast_to(entry, trial.lanes) for entry in together], dtype=np.float64)
    known = np.isfinite(theirs)
    size = np.where(known, np.abs(theirs), 0.0).max(initial=0.0)
    return bool(np.allclose(ours[known], theirs[known], rtol=_AGREEMENT, atol=_AGREEMENT * size))


def underlying(function: Any) -> FunctionType | None:
    """Return the plain function in a partial one, a bound method or a callable object, if any."""
    while isinstance(function, partial | MethodType):
        function = function.func if isinstance(function, partial) else function.__func__
    if isinstance(function, FunctionType):
        return function
    own = inspect.getattr_static(type(function), '__call__', None)
    return own if isinstance(own, FunctionType) else None


def misplaced(function: Any) -> str:
    """Return the names of the arguments where they are known, in another order; else ''."""
    try:
        parameters = list(inspect.signature(function).parameters.values())
    except (TypeError, ValueError):
        return ''
    names = [
        each.name for each in parameters
        if each.kind in (each.POSITIONAL_ONLY, each.POSITIONAL_OR_KEYWORD)
    ]  # fmt: skip
    kinds: Sequence[str | None] = [_ALIASES.get(name.lower()) for name in names[: len(ORDER)]]
    known = [kind for kind in kinds if kind is not None]
    wrong = any(kind not in (None, own) for kind, own in zip(kinds, ORDER, strict=False))
    return ', '.join(names) if wrong and len(known) == len(set(known)) > 1 else ''
