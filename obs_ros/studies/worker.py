"""The part of a run that a worker does: a call, with its error in words."""

import pickle
import traceback
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from obs_ros.core.texts import one_line, quoted
from obs_ros.studies.versions import differences, versions


class Failure(NamedTuple):
    """A call without a result: why, in one line, and where it was raised."""

    words: str
    details: str = ''


class Differs(NamedTuple):
    """Versions of a worker that differ from the client's, in words."""

    words: str


Arguments = Sequence[Any]


def packed(work: Callable[..., Any], runs: Sequence[Arguments]) -> bytes:
    """Return calls of a module's function, to be done by `unpacked`."""
    return pickle.dumps((work, [tuple(run) for run in runs]))


def unpacked(calls: bytes, here: Mapping[str, str]) -> list[Any] | Differs:
    """Return the results of the calls, in their order, or that `here` are other versions.

    These are looked at first: nothing that another version has written is read.
    """
    if words := differences(here, versions()):
        return Differs(words)
    work, runs = pickle.loads(calls)
    return [called(work, run) for run in runs]


def called(work: Callable[..., Any], arguments: Arguments) -> Any:
    """Return the result of a call, or the failure that an exception makes of it."""
    try:
        return work(*arguments)
    except Exception as error:
        # Errors of these kinds are written for the user.
        own = isinstance(error, ValueError | OSError | ImportError)
        return Failure(one_line(error) if own else quoted(error), traceback.format_exc())
