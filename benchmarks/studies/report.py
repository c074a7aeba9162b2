"""Requirements and tables of the benchmark of studies."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from benchmarks.report import Requirement, table
from benchmarks.studies.run import ALONE, LOCAL, ONE, REMOTE, TWO, Measured

ASKED = 0.9  # of the speed-up of bare processes
PEERS = {ONE: ONE, TWO: ONE, ALONE: ALONE, LOCAL: ALONE, REMOTE: ALONE}


def speed_up(seconds: Mapping[str, Sequence[float]], way: str) -> float:
    """Return how many times faster a way is than its like in one process, medians over rounds."""
    return float(np.median(np.divide(seconds[PEERS[way]], seconds[way])))


def acceptance(found: Measured) -> Iterator[Requirement]:
    """Yield what is asked of studies."""
    bare = speed_up(found.seconds, TWO)
    for way in (LOCAL, REMOTE):
        own = speed_up(found.seconds, way)
        yield Requirement(
            f'{way}: speed-up >= {ASKED:g} x that of two bare processes',
            f'{own:.2f} / {bare:.2f} = {own / bare:.2f}',
            own >= ASKED * bare,
        )
    tables = {*found.digests, found.course.digest}
    yield Requirement(
        'the same bits in every way, also with a worker killed',
        f'{len(tables)} different tables of {len(found.digests) + 1}',
        len(tables) == 1,
    )
    course = found.course
    yield Requirement(
        'a worker killed at a third, stopped at two thirds, started again: complete, none twice',
        f'{course.results} of {found.runs} results, {course.stopped_at} when stopped, of which '
        f'{course.rewritten} were done again',
        course.results == found.runs and not course.rewritten,
    )


def times(found: Measured) -> str:
    """Return the table of wall times."""
    return table(
        {
            'way': way,
            'wall time, median (s)': f'{np.median(own):.1f}',
            'least to most': f'{min(own):.1f} to {max(own):.1f}',
            'speed-up': f'{speed_up(found.seconds, way):.2f}',
        }
        for way, own in found.seconds.items()
    )
