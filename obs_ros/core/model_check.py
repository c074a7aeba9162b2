"""Trial of a plant's function before it is used: errors name the line and the remedy."""

import dis
import linecache
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import FunctionType, TracebackType
from typing import Any

import numpy as np

from obs_ros.core.texts import LONGEST, one_line, quoted

Vectors = Mapping[str, tuple[str, ...]]  # names of the entries of x, u and p, in this order

_UNPACKING = re.compile(
    r'(?:too many|not enough) values to unpack \(expected (?:at least )?(\d+)(?:, got (\d+))?\)'
)
_MATH = re.compile(
    r'must be real number, not|only (?:length-1|0-dimensional|size-1) arrays? can be converted'
)
# Said of the time where it is taken for a vector.
_ORDER = ('positional argument', 'cannot unpack non-iterable', 'is not subscriptable',
          'invalid index to scalar')  # fmt: skip


def called(
    function: Callable[..., Any],
    code: FunctionType,
    arguments: Sequence[Any],
    vectors: Vectors,
    on: str = 'on arrays over candidates',
) -> tuple[Any, ...]:
    """Return what a function of (t, x, u, p) returns for `arguments`, arrays over candidates.

    `code` is the plain function, as in a bound method, whose lines are named; `on` says by what it
    is tried. Raises ValueError that names the line, and the remedy, when it fails.
    """
    try:
        with np.errstate(all='ignore'):
            return function(*arguments)  # type: ignore[no-any-return]
    except Exception as error:
        raise ValueError(
            f'fails {on}: {quoted(error)}'
            f'{_remedy(error, vectors)} ({place(code, error.__traceback__)})'
        ) from error


def check_returned(
    function: FunctionType, returned: Any, names: tuple[str, ...], lanes: int
) -> None:
    """Raise ValueError unless it is a tuple with a number, for each candidate, by each name."""
    wanted = (
        f'must return a tuple of {len(names)} entries, one number for each candidate and each of '
        f'{", ".join(names)}'
    )
    where = f' ({_return_line(function)})'
    if returned is None:
        raise ValueError(f'{wanted}, not None: is the `return` missing?{where}')
    if not isinstance(returned, tuple):
        comma = ': write a comma, `return (value,)`' if len(names) == 1 else ''
        raise ValueError(f'{wanted}, not {_kind(returned)}{comma}{where}')
    if len(returned) != len(names):
        raise ValueError(f'{wanted}, not {len(returned)}{where}')
    for name, entry in zip(names, returned, strict=True):
        try:
            shape = np.asarray(entry, dtype=np.float64).shape
        except (TypeError, ValueError):
            raise ValueError(f'{wanted}; that of {name} is {_kind(entry)}{where}') from None
        if shape not in ((), (lanes,)):
            raise ValueError(
                f'{wanted}; that of {name} is an array of shape {shape}: '
                f'use entries, as in x[0], not whole vectors{where}'
            )


def check_finite(
    function: Callable[..., Any],
    code: FunctionType,
    arguments: Sequence[Any],
    returned: tuple[Any, ...],
    names: tuple[str, ...],
    vectors: Vectors,
) -> None:
    """Raise ValueError when an entry of `returned` is finite for none of the candidates.

    For some it may be infinite: the middle of the bounds, say, is often a singular point.
    """
    for name, entry in zip(names, returned, strict=True):
        if np.isfinite(np.asarray(entry, dtype=np.float64)).any():
            continue
        first = [
            argument if np.ndim(argument) == 0 else tuple(value[0] for value in argument)
            for argument in arguments
        ]
        where, why = _return_line(code), ''
        try:
            with np.errstate(divide='raise', over='raise', invalid='raise', under='ignore'):
                function(*first)
        except Exception as error:
            where, why = place(code, error.__traceback__), f', {quoted(error)}'
        at = ', '.join(
            f'{label} = {value:g}'
            for labels, values in zip(vectors.values(), first[1:], strict=True)
            for label, value in zip(labels, values, strict=True)
        )
        raise ValueError(
            f'is not finite: {name} is {np.ravel(entry)[0]:g} at {at or "t = 0"}, '
            f'nor is it anywhere else that was tried{why} ({where})'
        )


def is_for_numbers(error: ValueError) -> bool:
    """Whether a function failed since it was written for numbers: it branches on them, say."""
    cause = error.__cause__
    return 'ambiguous' in str(cause) or (
        isinstance(cause, TypeError) and _MATH.search(str(cause)) is not None
    )


def _remedy(error: Exception, vectors: Vectors) -> str:
    text = str(error)
    if isinstance(error, TypeError | IndexError) and any(words in text for words in _ORDER):
        return ' (it is called with t, x, u, p)'
    if _UNPACKING.search(text) or isinstance(error, IndexError):
        sizes = '; '.join(
            f'{vector} has {len(names)}: {", ".join(names)}' if names else f'{vector} has none'
            for vector, names in vectors.items()
        )
        return f' ({sizes})'
    return ''


def place(function: FunctionType, traceback: TracebackType | None = None) -> str:
    """Say where an error arose: the last line of the function's own file on the way there."""
    found = function.__code__.co_firstlineno
    while traceback is not None:
        if traceback.tb_frame.f_code.co_filename == function.__code__.co_filename:
            found = traceback.tb_lineno
        traceback = traceback.tb_next
    return source_line(function.__code__.co_filename, found)


def _return_line(function: FunctionType) -> str:
    """Say where a function returns, the last time."""
    code = function.__code__
    number = code.co_firstlineno
    for instruction in dis.get_instructions(code):
        if instruction.opname.startswith('RETURN') and instruction.positions is not None:
            number = instruction.positions.lineno or number
    return source_line(code.co_filename, number)


def source_line(file: str, number: int) -> str:
    """Return the name of a file, the number of a line and what stands there."""
    text = one_line(linecache.getline(file, number), LONGEST)
    return f'{Path(file).name}:{number}' + (f': `{text}`' if text else '')


def _kind(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return f'an array of shape {value.shape}'
    return f'the {type(value).__name__} {quoted(value, 60)}'
