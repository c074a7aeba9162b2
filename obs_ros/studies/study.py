"""A study: recordings by variants, what of it is stored, and the rest carried out."""

from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from obs_ros.replay.recording import Source
from obs_ros.studies.keys import content, key
from obs_ros.studies.result import Result
from obs_ros.studies.run import at, replayed
from obs_ros.studies.runner import Where, carried_out
from obs_ros.studies.store import Store
from obs_ros.studies.tables import RECORDING
from obs_ros.studies.variants import Variant, shown
from obs_ros.studies.worker import Failure


@dataclass(frozen=True, eq=False)
class Run:
    """A recording under a variant; `key` names its result, `digest` is that of the recording."""

    recording: str
    variant: Variant
    source: Source
    digest: str
    key: str

    @property
    def labels(self) -> Mapping[str, str]:
        """The cells of its rows: the recording, and what varies."""
        return {RECORDING: self.recording, **{n: shown(v) for n, v in self.variant.varied.items()}}

    def __str__(self) -> str:
        """Name both."""
        return f'{self.recording} with {self.variant}' if self.variant.varied else self.recording


@dataclass
class Study:
    """Runs in the order of recordings, then variants.

    `unreadable` has recordings that were left out, and why; `failed` the same of runs, by key.
    """

    runs: Sequence[Run]
    store: Store
    deadline: bool = False
    unreadable: Mapping[str, str] = field(default_factory=dict)
    failed: dict[str, str] = field(default_factory=dict)

    @staticmethod
    def of(
        paths: Sequence[Path],
        variants: Sequence[Variant],
        source: Source,
        store: Store,
        *,
        deadline: bool = False,
    ) -> 'Study':
        """Return the study of these recordings, each read like `source`.

        Recordings that cannot be read are left out, see `unreadable`.
        """
        runs, unreadable = [], {}
        for path, name in zip(paths, labels(paths), strict=True):
            own = at(source, path)
            try:
                digest = content(path)
            except (OSError, ValueError) as error:
                unreadable[name] = str(error)
                continue
            keys = (key(digest, own, variant.setup, deadline) for variant in variants)
            runs += [
                Run(name, variant, own, digest, each)
                for variant, each in zip(variants, keys, strict=True)
            ]
        return Study(runs, store, deadline, unreadable)

    def left(self) -> list[Run]:
        """Return the runs that are still to be done, each once; the same content is the same."""
        first = {run.key: run for run in reversed(self.runs)}
        return [
            run for run in self.runs if first[run.key] is run and self.store.get(run.key) is None
        ]

    def carry_out(
        self, left: Sequence[Run], where: Where, say: Callable[[str], None] = lambda line: None
    ) -> Generator[tuple[Run, str], None, None]:
        """Do these runs, and store each result as it comes; yield the run and why it failed.

        That is empty where it did not. Raises as `runner.carried_out` does.
        """
        calls = [(run.source, run.digest, run.variant.given, self.deadline) for run in left]
        for index, found in carried_out(replayed, calls, where, say=say):
            run = left[index]
            if isinstance(found, Failure):
                self.failed[run.key] = found.words
            else:
                self.store.put(run.key, found)
            yield run, self.failed.get(run.key, '')

    @property
    def missing(self) -> list[tuple[str, str, str]]:
        """Recording, variant and reason of all that has no result."""
        return [
            *((recording, '', why) for recording, why in self.unreadable.items()),
            *((run.recording, str(run.variant), self.failed[run.key])
              for run in self.runs if run.key in self.failed),
        ]  # fmt: skip

    def results(self) -> Iterator[tuple[Run, Result]]:
        """Yield the results there are, in the order of the runs."""
        for run in self.runs:
            if (stored := self.store.get(run.key)) is not None:
                yield run, Result.from_bytes(stored)


def labels(paths: Sequence[Path]) -> list[str]:
    """Return a name for each recording: that of its file, with folders where two are the same."""
    parts = [path.resolve().parts for path in paths]
    found = []
    for own in parts:
        length = 1
        while length < len(own) and sum(p[-length:] == own[-length:] for p in set(parts)) > 1:
            length += 1
        found.append('/'.join(own[-length:]))
    return found
