"""Calls carried out here one after the other, in local processes, or by a Dask scheduler."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from obs_ros.studies.worker import Arguments, Failure, called

__all__ = ['Failure', 'Where', 'carried_out']

MOST_JOBS = 256  # processes on one machine


@dataclass(frozen=True)
class Where:
    """The place of the work: `jobs` local processes, a `scheduler` by its address, or here.

    Raises ValueError for both at once, and for a number of processes that is none.
    """

    jobs: int | None = None
    scheduler: str | None = None

    def __post_init__(self) -> None:
        if self.jobs is not None and self.scheduler is not None:
            raise ValueError('give --jobs or --scheduler, not both: a scheduler has workers')
        if self.jobs is not None and not 1 <= self.jobs <= MOST_JOBS:
            raise ValueError(f'--jobs must be 1 to {MOST_JOBS}, not {self.jobs}')

    @property
    def here(self) -> bool:
        """Whether this process does the work."""
        return self.jobs is None and self.scheduler is None


def carried_out(
    work: Callable[..., Any],
    runs: Sequence[Arguments],
    where: Where,
    chunk: int = 1,
    say: Callable[[str], None] = lambda line: None,
) -> Iterator[tuple[int, Any]]:
    """Yield index and result of each run, a tuple of arguments, as they come.

    `work` is a module's function. What it raises, and a run whose worker dies again and again, is a
    `Failure` in place of a result. Workers take `chunk` runs at a time; `say` gets remarks.

    Raises MissingPackageError where Dask is needed and not installed, ValueError for versions that
    differ, and OSError for a scheduler that is not there or ends.
    """
    if where.here or not runs:
        for index, run in enumerate(runs):
            yield index, called(work, run)
        return
    # Imported only now: it takes a second, and is not needed otherwise.
    from obs_ros.studies.cluster import over

    yield from over(work, runs, where.jobs, where.scheduler, chunk, say)
