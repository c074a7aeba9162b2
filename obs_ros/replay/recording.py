"""Recordings: samples in the order in which a live node would get them."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from obs_ros.core.record import Sample
from obs_ros.core.registry import suggest
from obs_ros.replay.settings import Setup

BAG_SUFFIXES = ('.mcap', '.db3')
TABLE_SUFFIXES = ('.csv', '.tsv', '.txt')


class Recording(Protocol):
    """Samples, once through; `done` (0 to 1) is how much of it was read.

    `refused` counts messages that did not fit, by reason; `remarks` are sentences for the user.
    """

    refused: Counter[str]
    remarks: Sequence[str]
    done: float

    def __iter__(self) -> Iterator[Sample]:
        """Yield the samples; raises ValueError, with the place, at what cannot be read."""


@dataclass(frozen=True)
class Source:
    """The place of a recording, and the names of its columns or topics.

    `columns` names columns of a table by the model's names, `period` (s) is the time from row to
    row of a table without a time column. Of a bag, `topics` has the topics of `output` and `input`
    where they are not plant/output and plant/input, and `node` is whose relative names count.
    """

    path: Path
    columns: Mapping[str, str] = field(default_factory=dict)
    period: float | None = None
    topics: Mapping[str, str] = field(default_factory=dict)
    node: str = '/estimator'


def open_recording(source: Source, chosen: Setup) -> Recording:
    """Return the recording, its head checked against the model.

    Raises ValueError where it does not suit, OSError where it cannot be read and
    MissingPackageError for a bag without the package that reads it.
    """
    path = source.path
    check_file(path)
    if path.is_dir() or path.suffix in BAG_SUFFIXES:
        if source.columns or source.period is not None:
            raise ValueError(f'{path} is a bag: columns and a period are for tables')
        from obs_ros.replay.bag import Bag, Binder

        binder = Binder(source.node, source.topics, chosen.bound, chosen.merge_wait)
        return Bag(path, binder, chosen.model)
    if path.suffix.lower() in TABLE_SUFFIXES:
        if source.topics:
            raise ValueError(f'{path} is a table: topics are for bags')
        from obs_ros.replay.table import Table

        return Table(path, source.columns, source.period, chosen.model)
    raise ValueError(
        f'{path} is no recording known here: a bag is a folder or ends in '
        f'{" or ".join(BAG_SUFFIXES)}, a table ends in {" or ".join(TABLE_SUFFIXES)}'
    )


def check_file(path: Path) -> None:
    """Raise ValueError for what is neither file nor folder: it may be read only once, or never.

    Raises FileNotFoundError for what is not there, naming what may be meant.
    """
    if not path.exists():
        there = [each.name for each in path.parent.iterdir()] if path.parent.is_dir() else []
        hint = suggest(path.name, there)
        raise FileNotFoundError(
            f'{path} does not exist' + (f': {hint}' if hint.startswith('did') else '')
        )
    if not (path.is_file() or path.is_dir()):
        raise ValueError(f'{path} is a pipe or a device: copy what it gives into a file first')
