"""Known delays: from the stamps of samples to when they were measured, or act."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from heapq import heappop, heappush
from typing import Protocol, TypeVar

import numpy as np

from obs_ros.core.estimated_delays import SUFFIX
from obs_ros.core.model import Model, Variable
from obs_ros.core.record import Record
from obs_ros.core.typing import Array, BoolArray, IntArray
from obs_ros.samples.align import align
from obs_ros.samples.merge import Role
from obs_ros.samples.stream import STAMP_LIMIT, InputStream, Stream

NOTHING: Mapping[str, float] = {}
MOST_HELD = 20000  # samples; of more the oldest go on early, to memories that are bounded as well
Kind = TypeVar('Kind', bound=Stream)
RANK: Mapping[Role, int] = {'input': 0, 'output': 1}  # at one time inputs go before outputs


@dataclass(frozen=True)
class Shifts:
    """Times (ns), by input and by output, from a sample's stamp to its own time.

    An output stamped s was measured at s - delay, an input stamped s acts from s + delay on. So far
    back as `past` (ns) inputs may act late by a delay that is estimated: windows need them.
    """

    inputs: tuple[int, ...]
    outputs: tuple[int, ...]
    past: int = 0

    @classmethod
    def of(cls, model: Model, found: Mapping[str, float] = NOTHING) -> 'Shifts | None':
        """Return the shifts of a model's known delays; None where there is no delay at all.

        Of those that are estimated `found` gives the parameters; the others are 0, as the rollouts
        of windows shift them.
        """
        if not any(variable.delay for variable in (*model.inputs, *model.outputs)):
            return None
        uppers = [v.delay[1] for v in model.inputs if isinstance(v.delay, tuple)]
        return cls(
            tuple(_known(variable, found) for variable in model.inputs),
            tuple(-_known(variable, found) for variable in model.outputs),
            round(1e9 * max(0.0, *uppers)) if uppers else 0,
        )

    @cached_property
    def groups(self) -> dict[Role, list[tuple[int, BoolArray]]]:
        """Each shift of the inputs and outputs, with the mask (width,) of those that have it."""
        found: dict[Role, list[tuple[int, BoolArray]]] = {}
        roles: tuple[tuple[Role, tuple[int, ...]], ...]
        roles = ('input', self.inputs), ('output', self.outputs)
        for role, shifts in roles:
            if shifts:
                own = np.array(shifts, dtype=np.int64)
                found[role] = [(int(shift), np.asarray(own == shift)) for shift in np.unique(own)]
        return found

    def parts(self, role: Role, stamp: int, values: Array) -> Iterator[tuple[int, Array]]:
        """Yield the own times (ns) of a sample's values (width,), with NaN for those of others."""
        for shift, mask in self.groups[role]:
            part = np.where(mask, values, np.nan)
            if not np.isnan(part).all():
                yield stamp + shift, part


class Receiver(Protocol):
    """The memory behind a delay line; see `Store`."""

    @property
    def passed(self) -> int | None:
        """Stamp (ns) up to which all is over."""

    def keep(self, role: Role, stamp: int, values: Array) -> bool:
        """Sort in a sample."""

    def forget(self) -> None:
        """Forget all samples."""


class DelayLine:
    """Hands samples on to a `store` at their own times, in order of these.

    A sample waits as long as older ones may come, because their signals' delays are longer: until
    stamps have gone on by the difference.
    """

    def __init__(self, store: Receiver, shifts: Shifts) -> None:
        self._store = store
        self.shift(shifts)
        self.clear()

    def shift(self, shifts: Shifts) -> None:
        """Let samples be shifted by that from now on."""
        self._shifts = shifts
        # None of the samples of a role is farther back than by its least shift.
        self._earliest = {role: groups[0][0] for role, groups in shifts.groups.items()}

    def clear(self) -> None:
        """Forget the samples that wait."""
        self._order: list[tuple[int, int]] = []  # times and ranks
        self._waiting: dict[tuple[int, int], tuple[Role, Array]] = {}
        self._newest: dict[Role, int] = {}  # stamps

    def keep(self, role: Role, stamp: int, values: Array) -> bool:
        """Take a sample of that stamp (ns); False if all of it is there already."""
        new = False
        for time, part in self._shifts.parts(role, stamp, values):
            key = time, RANK[role]
            if key not in self._waiting:
                heappush(self._order, key)
                self._waiting[key] = role, part
                new = True
                continue
            known = self._waiting[key][1]
            new |= bool((np.isnan(known) & ~np.isnan(part)).any())
            self._waiting[key] = role, np.where(np.isnan(known), part, known)
        self._newest[role] = max(stamp, self._newest.get(role, stamp))
        self._release()
        return new

    def forget(self) -> None:
        """See `Store`."""
        self.clear()
        self._store.forget()

    @property
    def passed(self) -> int | None:
        """See `Store`: in the samples' own times."""
        return self._store.passed

    def earliest(self, role: Role) -> int:
        """Return the least shift (ns) of a role that has signals."""
        return self._earliest[role]

    def reached(self, newest: Mapping[Role, int]) -> int:
        """Return the time (ns) that streams of these newest stamps (ns) have reached."""
        return min(stamp + self._earliest[role] for role, stamp in newest.items())

    def _release(self) -> None:
        # At the newest stamp another stream may have more to bring, but not before it.
        before = max(self._newest.values()) - 1
        clocks = {role: max(before, self._newest.get(role, before)) for role in self._earliest}
        until = self.reached(clocks)
        while self._order and (self._order[0][0] <= until or len(self._order) > MOST_HELD):
            key = heappop(self._order)
            role, values = self._waiting.pop(key)
            passed = self._store.passed
            # Those of a new timeline come stream by stream, and shifts may change.
            if role == 'input' or passed is None or key[0] > passed:
                self._store.keep(role, key[0], values)


def at_own_times(model: Model, record: Record) -> Record:
    """Return a record with every sample at its own time, by the known delays.

    It begins with an output where every input is known by then, and was so long before as a delay
    that is estimated may be; earlier outputs are left out. Without delays, or with other columns
    than the model's, it is the very record.

    Raises ValueError where fewer than two outputs are left.
    """
    shifts = Shifts.of(model)
    widths = record.u.shape[1], record.y.shape[1]
    if shifts is None or widths != (len(model.inputs), len(model.outputs)):
        return record
    if not (any(shifts.inputs) or any(shifts.outputs) or shifts.past):
        return record
    stamps = np.round(record.t * 1e9).astype(np.int64)
    outputs = _stream(Stream, shifts.groups.get('output', ()), stamps, record.y)
    inputs = _stream(InputStream, shifts.groups.get('input', ()), stamps, record.u)
    since = inputs.known_since
    outputs.drop_until((-STAMP_LIMIT if since is None else since + shifts.past) - 1)
    kinds = [variable.interpolation for variable in model.inputs]
    end = int(outputs.stamps[-1]) if len(outputs) else 0
    found = align(outputs, inputs, end, kinds, shifts.past)
    if found is None:
        raise ValueError(
            'lengthen the record: its inputs, at the times when they act, span fewer than two '
            'of its outputs'
        )
    stamp = None
    if record.stamp is not None:
        newest = stamps[np.isfinite(record.y).any(axis=1)][-1]
        stamp = record.stamp + end - int(newest)
    return Record(found.t, found.u, found.y, stamp, found.past)


def _stream(
    kind: type[Kind], groups: Sequence[tuple[int, BoolArray]], stamps: IntArray, values: Array
) -> Kind:
    """Return a stream of rows of values (K, width), each value at its own time."""
    times = [stamps + shift for shift, _ in groups]
    every = reduce(np.union1d, times) if times else stamps[:0]
    own = np.full((every.size, values.shape[1]), np.nan)
    for (_, mask), at in zip(groups, times, strict=True):
        own[np.ix_(np.searchsorted(every, at), mask)] = values[:, mask]
    known = ~np.isnan(own).all(axis=1)
    stream = kind(values.shape[1], max(every.size, 1))
    stream.fill(every[known], own[known])
    return stream


def _known(variable: Variable, found: Mapping[str, float]) -> int:
    """Return the delay (ns) as far as it is known."""
    delay = variable.delay
    if isinstance(delay, tuple):
        delay = found.get(f'{variable.name}{SUFFIX}', 0.0)
    return round(1e9 * (delay or 0.0))
