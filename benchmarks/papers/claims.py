"""Claims of a paper, each with its place, how it was judged, what was found, and the verdict."""

from collections.abc import Iterable
from enum import Enum
from typing import NamedTuple

from benchmarks.intervals import share_interval
from benchmarks.report import table

RARE = 0.05  # a share: what goes wrong less often, with its interval, is reliable

AS_WELL = 1.1  # times the error of another: up to there one does as well

Interval = tuple[float, float]  # lower and upper end


class Verdict(Enum):
    """How a claim fares; the value is the word of the reports."""

    HOLDS = 'holds'
    DOES_NOT_HOLD = '**does not hold**'
    NOT_SHOWN = 'not shown'  # intervals overlap: neither of the two above
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
    """Return the verdict on a claim that no chance decides."""
    return Verdict.HOLDS if holds else Verdict.DOES_NOT_HOLD


def below(one: Interval, other: Interval) -> Verdict:
    """Judge by intervals that one quantity is below another."""
    if one[1] < other[0]:
        return Verdict.HOLDS
    return Verdict.DOES_NOT_HOLD if one[0] >= other[1] else Verdict.NOT_SHOWN


def within(one: Interval, limits: Interval) -> Verdict:
    """Judge by its interval that a quantity lies between two limits."""
    if limits[0] <= one[0] and one[1] <= limits[1]:
        return Verdict.HOLDS
    apart = one[1] < limits[0] or limits[1] < one[0]
    return Verdict.DOES_NOT_HOLD if apart else Verdict.NOT_SHOWN


def rarely(failures: int, runs: int) -> Verdict:
    """Judge by its interval that the share of runs in which something goes wrong is below RARE."""
    return within(share_interval(failures, runs), (0.0, RARE))


def never(failures: int, runs: int) -> Verdict:
    """Judge that something goes wrong in no run at all: one that does refutes it."""
    return Verdict.DOES_NOT_HOLD if failures else rarely(failures, runs)


def as_well(ratio: Interval) -> Verdict:
    """Judge by the interval of a ratio of errors that the first is no larger than the second."""
    return below(ratio, (AS_WELL, AS_WELL))


def every(verdicts: Iterable[Verdict]) -> Verdict:
    """Return the verdict on a claim that consists of several: one that fails refutes it."""
    found = {*verdicts}
    if Verdict.DOES_NOT_HOLD in found:
        return Verdict.DOES_NOT_HOLD
    return Verdict.HOLDS if found <= {Verdict.HOLDS} else Verdict.NOT_SHOWN


def opposite(one: Verdict) -> Verdict:
    """Return the verdict on the contrary."""
    swapped = {Verdict.HOLDS: Verdict.DOES_NOT_HOLD, Verdict.DOES_NOT_HOLD: Verdict.HOLDS}
    return swapped.get(one, one)


def counted(verdicts: Iterable[Verdict]) -> str:
    """Return how many verdicts there are of each kind, as text."""
    found = [*verdicts]
    kinds = (kind for kind in Verdict if kind in found)
    return ', '.join(f'{kind.value.strip("*")} in {found.count(kind)}' for kind in kinds)


class Ratio(NamedTuple):
    """A ratio of median errors with its 95 % interval; above 1: the first is worse."""

    middle: float
    low: float
    high: float

    def __str__(self) -> str:
        return f'{self.middle:.2f} ({self.low:.2f} to {self.high:.2f})'

    @property
    def ends(self) -> Interval:
        """The interval."""
        return self.low, self.high

    @property
    def smaller(self) -> Verdict:
        """The verdict on the claim that the first has smaller errors."""
        return below(self.ends, (1.0, 1.0))

    @property
    def worse(self) -> bool:
        """Whether the first has larger errors beyond doubt."""
        return self.low > 1.0

    @property
    def better(self) -> bool:
        """Whether the first has smaller errors beyond doubt."""
        return self.high < 1.0

    @property
    def word(self) -> str:
        """The result as a word on the first."""
        return 'larger' if self.worse else 'smaller' if self.better else 'no difference'


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
