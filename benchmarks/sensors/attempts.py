"""Runs that may fail, as where a source tree cannot yet do what is asked; a failure is told."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, TypeVar

from benchmarks.report import Requirement
from benchmarks.runner import monte_carlo

Key = TypeVar('Key')
Result = TypeVar('Result')

LONGEST = 160  # characters of an error


class Failure(NamedTuple):
    """A run that raised an error, in words."""

    words: str


def attempted(work: Callable[..., Any], *arguments: Any) -> Any:
    """Return the result of a call, or the failure that an error makes of it."""
    try:
        return work(*arguments)
    except Exception as error:
        return Failure(f'{type(error).__name__}: {" ".join(str(error).split())}'[:LONGEST])


def carried_out(
    work: Callable[..., Result], cells: Mapping[Key, Sequence[tuple[Any, ...]]], label: str
) -> dict[Key, list[Result | Failure]]:
    """Return by cell the results of a module's function on all cores, see `monte_carlo`."""
    runs = {key: [(work, *arguments) for arguments in own] for key, own in cells.items()}
    return monte_carlo(attempted, runs, label)


def failures(results: Sequence[Any]) -> list[Failure]:
    """Return the runs that failed."""
    return [one for one in results if isinstance(one, Failure)]


def judged(
    asked: str, results: Sequence[Any], judge: Callable[[list[Any]], tuple[str, bool]]
) -> Requirement:
    """Return the row of a requirement: measured words and whether it is met, by the judge.

    A run that failed does not meet it, whatever the others have; nor do none at all.
    """
    failed = failures(results)
    if failed:
        measured = f'{len(failed)} of {len(results)} runs failed: {failed[0].words}'
        return Requirement(asked, measured.replace('|', '/'), False)
    if not results:
        return Requirement(asked, 'nothing was measured', False)
    return Requirement(asked, *judge(list(results)))
