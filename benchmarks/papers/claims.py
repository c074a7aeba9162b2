"""Claims of a paper, each with its place, how it was judged, what was found, and the verdict."""

from collections.abc import Iterable
from enum import Enum
from typing import NamedTuple

from benchmarks.intervals import share_interval
from benchmarks.report import table

RARE = 0.05  # a share: what goes wrong less often, with its interval, is reliable


class Verdict(Enum):
    """How a claim fares; the value is the word of the reports."""

    HOLDS = 'holds'
    DOES_NOT_HOLD = '**does not hold**'
    CANNOT_BE_JUDGED = 'cannot be judged from the print'


class Claim(NamedTuple):
    """A claim of a paper.

    `place` is the section, equation, figure or table; `judged` tells how it was judged: quantity
    and seeds; `figure` was found, with its 95 % interval; `ours` is our default beside it.
    """

    place: str
    sentence: str
    judged: str
    figure: str
    verdict: Verdict
    ours: str = ''


def verdict(holds: bool) -> Verdict:
    """Return the verdict on a claim that can be judged."""
    return Verdict.HOLDS if holds else Verdict.DOES_NOT_HOLD


def reliable(failures: int, runs: int) -> bool:
    """Tell if the 95 % interval of a share of failures ends below RARE."""
    return share_interval(failures, runs)[1] <= RARE


def claims_table(claims: Iterable[Claim]) -> str:
    """Return the table of claims, of one form for all papers."""
    return table(
        {
            'place': claim.place,
            'claim': claim.sentence,
            'judged by': claim.judged,
            'found': claim.figure,
            'verdict': claim.verdict.value,
            'our default': claim.ours,
        }
        for claim in claims
    )


def share(hits: int, runs: int) -> str:
    """Return a rate as text: so many of the runs, and the 95 % interval of their share."""
    low, high = share_interval(hits, runs)
    return f'{hits} of {runs} ({low:.3f} to {high:.3f})'
