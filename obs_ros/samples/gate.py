"""The one gate through which samples enter: measured, in order, and of one timeline."""

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from operator import index
from typing import Protocol

import numpy as np

from obs_ros.core.model import Model
from obs_ros.core.record import Sample
from obs_ros.core.typing import Array
from obs_ros.samples.break_detector import Suspects, describe_break
from obs_ros.samples.delay_line import Shifts
from obs_ros.samples.merge import Role
from obs_ros.samples.nodes import COUNTS as ON_NODES
from obs_ros.samples.own_times import OwnTimes
from obs_ros.samples.range_check import COUNTS as MEASURABLE
from obs_ros.samples.range_check import Limits, limits, measured
from obs_ros.samples.stream import STAMP_LIMIT

COUNTS = {
    'late': 'samples whose window or step was over when they came: outputs are dropped, inputs '
    'are in force from there on',
    'reordered': 'samples that came late, but in time to be sorted in',
    'duplicate': 'samples dropped: their stream has that stamp already, and the first one counts',
    **MEASURABLE,
    **ON_NODES,
    'ahead': 'samples dropped: a stray stamp, far ahead of the newest one',
    'out_of_range': f'samples dropped: a stamp beyond +-{STAMP_LIMIT} ns',
    'reset': 'breaks of the timeline, after which all samples were forgotten',
}


@dataclass(frozen=True)
class GateSettings:
    """The limits of the gate; the same ones give the same decisions, whoever listens.

    Time goes on over a gap of up to `reach` s, as the user configures it: duration plus period of a
    window, or `longest_gap` of a recursive observer. With a reach of 0 nothing is configured. Then
    the reach is that of the node's default window, so that one stream is one timeline to either
    kind of observer; or some mean intervals between outputs, where these take longer. Mean
    intervals alone would not do: a stream of 100 Hz would end at a gap of 15 s, over which a window
    of 1000 s, and the plant, go on.

    Times are in s, and intervals are mean ones between outputs.

    - `default_reach`: a window of 1000 s, and 1000 s to the next.
    - `reach_intervals`: of a plant sampled by the hour so many samples in a row may be lost;
      up to 200 s from sample to sample `default_reach` is more.
    - `most_steps`: integration steps within the default reach of a recursive observer, as nothing
      can interrupt the way from one sample to the next: 2 s of the costliest, `h_infinity`. A model
      whose steps are of 20 ms or more has the full reach, one of 1 ms 100 s. Where steps are chosen
      (`max_step` infinite), `LiveStepSettings` bounds their number.
    - `at_once`, `intervals_at_once`: the longer of the two is the gap that one sample may prove;
      it is the reach until two outputs have shown the pace.
    - `believed`: samples in a row, two at least, that prove a longer gap or a new timeline:
      one bad stamp must not end everything.
    """

    reach: float = 0.0
    default_reach: float = 2000.0
    reach_intervals: float = 10.0
    most_steps: float = 1e5
    at_once: float = 10.0
    intervals_at_once: float = 1000.0
    believed: int = 5

    def within_steps(self, model: Model) -> 'GateSettings':
        """Return the settings with a default reach that takes the model `most_steps` at most.

        A discrete model has a memory of every node, and no reach beyond that.
        """
        steps = self.most_steps * model.max_step
        reach = self.reach if model.period is None else min(self.reach, steps)
        return replace(self, reach=reach, default_reach=min(self.default_reach, steps))


DEFAULT = GateSettings()
Released = Mapping[Role, Sequence[tuple[int, Array]]]  # stamps (ns) and values of suspects


class Store(Protocol):
    """The memory of whoever takes samples: a window, or the inputs and outputs of an observer."""

    @property
    def passed(self) -> int | None:
        """Stamp (ns) up to which all is over; None before anything is settled."""

    def keep(self, role: Role, stamp: int, values: Array) -> bool:
        """Sort in a sample; False if its stamp is there already.

        It is the newest of its stream, or newer than `passed`, or an input.
        """

    def forget(self) -> None:
        """Forget all samples: a new timeline begins."""


class Gate:
    """Checks and orders samples, counts them by reason, and hands those that enter to the `store`.

    Per stream, inputs or outputs, a sample enters by these rules, in this order:

    1. Its stamp is one that a clock can give, and some of its entries lie between their limits;
       the others count as not measured.
    2. Not newer than the newest of its stream, it is `duplicate`, `late` or sorted in: `reordered`.
       It is late at or before `Store.passed`, and at first farther back than the reach. A window
       has passed the end of the last one; a recursive observer, which cannot go back, its newest
       output. A late input is in force from there on.
    3. Farther ahead of all others than `GateSettings.at_once`, it is held back, and `ahead` if a
       sample in order follows. Outputs show that time went on where inputs are rare, such as a set
       point.
    4. As many samples of a stream in a row as `GateSettings.believed`, all held back by rule 2 or 3
       and with rising stamps, are believed. Ahead by no more than the reach, they enter: there was
       a gap. Else a new timeline begins: `last_break` says so, everything older is forgotten, and
       those held back enter. None of them is lost.

    The decisions depend on the samples, the settings and `Store.passed` only: two gates with the
    same settings take the same stream for the same timeline.

    Stamps are those of the messages. With `shifts` the store gets the samples at their own times,
    and with the `period` (s) of a discrete model at its nodes; see `NodeLine`.
    """

    def __init__(
        self, inputs: Limits, outputs: Limits, store: Store, settings: GateSettings,
        shifts: Shifts | None = None, period: float | None = None,
    ) -> None:  # fmt: skip
        self.limit(settings)
        self.counts = dict.fromkeys(COUNTS, 0)
        self.last_break: str | None = None
        self._ranges: dict[Role, Limits] = {'input': inputs, 'output': outputs}
        self._passing = store
        self._times = OwnTimes(store, shifts, period, self.counts)
        self._store = self._times.entrance
        self._suspects: dict[Role, Suspects] = {
            'input': Suspects(settings.believed), 'output': Suspects(settings.believed)
        }  # fmt: skip
        self.reset()

    @classmethod
    def of(cls, model: Model, store: Store, settings: GateSettings) -> 'Gate':
        """Return a gate for samples of a model."""
        ranges = limits(model, model.inputs), limits(model, model.outputs)
        return cls(*ranges, store, settings, Shifts.of(model), model.period)

    def limit(self, settings: GateSettings) -> None:
        """Let samples enter by these limits from now on."""
        self._limits = settings
        reach = settings.reach or settings.default_reach
        self._near = round(1e9 * min(settings.at_once, reach))  # ns; certainly not far ahead

    def shift(self, shifts: Shifts | None) -> None:
        """Let samples enter at other times from now on, if there are delays at all."""
        self._times.shift(shifts)

    def reset(self) -> None:
        """Forget all stamps, but not the counts."""
        for suspects in self._suspects.values():
            self.counts['ahead'] += suspects.clear()
        self.newest: dict[Role, int | None] = {'input': None, 'output': None}  # ns
        self._first, self._outputs = 0, 0  # stamp (ns) of the first, and number, of this timeline
        self._interval = 0.0  # ns, mean over the samples that began this timeline
        self._over: int | None = None  # ns, until the first output that is newer
        self._early: deque[tuple[int, Array]] = deque(maxlen=1000)  # inputs until then
        self._times.clear()

    def resume(self, passed: int) -> None:
        """Take outputs up to `passed` (ns) for over, as an earlier process had them.

        The first one that is newer goes on, whatever the gap; as many as `believed` that are not
        begin a new timeline.
        """
        self._over = passed

    def reached(self) -> int | None:
        """Return the time (ns) that outputs and inputs have both reached; None before it."""
        stamps = {role: self.newest[role] for role, ranges in self._ranges.items() if ranges}
        known = {role: stamp for role, stamp in stamps.items() if stamp is not None}
        if len(known) < len(stamps):
            return None
        return self._times.reached(known)

    def push(self, sample: Sample) -> bool:
        """Take a sample; return whether it began a new timeline.

        Raises ValueError if the number of outputs or inputs is wrong.
        """
        y, u = self._checked('output', sample.y), self._checked('input', sample.u)
        stamp, breaks = index(sample.stamp), self.counts['reset']
        if not -STAMP_LIMIT < stamp < STAMP_LIMIT:
            self.counts['out_of_range'] += 1
            return False
        if u is not None and (u := measured(u, self._ranges['input'], self.counts)) is not None:
            self._place('input', stamp, u)
        if y is not None and (y := measured(y, self._ranges['output'], self.counts)) is not None:
            self._place('output', stamp, y)
        return self.counts['reset'] > breaks

    def _checked(self, role: Role, values: Array | None) -> Array | None:
        if values is None:
            return None
        # A copy: compiled steps must see one layout, and whoever publishes may reuse the array.
        array = np.array(values, dtype=np.float64, order='C')
        width = len(self._ranges[role])
        if array.shape != (width,):
            raise ValueError(f'sample has {role}s of shape {array.shape}, not ({width},)')
        return array if width else None

    def _place(self, role: Role, stamp: int, values: Array) -> None:
        newest, suspects = self.newest[role], self._suspects[role]
        if role == 'output' and newest is None and self._over is not None and stamp <= self._over:
            newest = self._over
        if newest is not None and stamp <= newest:
            self.counts[self._sort_in(role, stamp, newest, values)] += 1
            self._suspect(role, stamp, values, ahead=False)
        elif self._far_ahead(stamp - self._newest_around(role, stamp)):
            self._suspect(role, stamp, values, ahead=True)
        else:
            if suspects:
                self.counts['ahead'] += suspects.clear()
            self._enter(role, stamp, values)

    def _enter(self, role: Role, stamp: int, values: Array) -> None:
        """Let in the newest sample of its stream."""
        self.newest[role] = stamp
        if role == 'output':
            self._first = self._first if self._outputs else stamp
            self._outputs += 1
            self._over = None
            self._early.clear()
        elif self._over is not None:  # in force when outputs go on, or of a new timeline
            self._early.append((stamp, values))
        elif (passed := self._passed(role)) is not None:
            self.counts['late'] += stamp <= passed
        self._store.keep(role, stamp, values)

    def _sort_in(self, role: Role, stamp: int, newest: int, values: Array) -> str:
        """Let the store sort in a sample that is not the newest; return why to count it."""
        if stamp == newest:
            return 'duplicate'
        passed = self._passed(role)
        # Before anything is settled, a stray old stamp must not become the start.
        if stamp > (newest - self._reach if passed is None else passed):
            return 'reordered' if self._store.keep(role, stamp, values) else 'duplicate'
        if role == 'input' and passed is not None:
            self._store.keep(role, stamp, values)
        return 'late'

    def _passed(self, role: Role) -> int | None:
        """Return the stamp (ns) up to which all is over for samples of that role."""
        passed = self._passing.passed
        return passed if passed is None else passed - self._times.earliest(role)

    @property
    def _mean_interval(self) -> float:
        """The mean interval (ns) between outputs, without gaps; 0 before it is known."""
        newest = self.newest['output']
        if newest is None or self._outputs < 2:
            return self._interval
        return max(self._interval, (newest - self._first) / (self._outputs - 1))

    @property
    def _reach(self) -> int:
        """The farthest (ns) that a sample can be from the others and on their timeline."""
        limits = self._limits
        mean = limits.reach_intervals * self._mean_interval
        return round(limits.reach * 1e9 or max(limits.default_reach * 1e9, mean))

    def _far_ahead(self, gap: int) -> bool:
        """Whether a sample so far (ns) ahead of all others takes more like it to be believed."""
        if gap <= self._near:
            return False
        return gap > self._reach or 0.0 < self._limits.intervals_at_once * self._mean_interval < gap

    def _newest_around(self, role: Role, default: int) -> int:
        """Return the newest stamp (ns) of the stream; for inputs, of both streams."""
        own, outputs = self.newest[role], self.newest['output']
        if own is None or outputs is None:
            return next((each for each in (own, outputs) if each is not None), default)
        return max(own, outputs)

    def _suspect(self, role: Role, stamp: int, values: Array, *, ahead: bool) -> None:
        suspects = self._suspects[role]
        self.counts['ahead'] += suspects.add(stamp, values, ahead=ahead)
        if not suspects.believed:
            return
        # Inputs come first: the first of them is then accepted, and no second break can follow.
        released = {each: suspects.release() for each, suspects in self._suspects.items()}
        if 0 < released[role][0][0] - self._newest_around(role, stamp) <= self._reach:
            self._go_on(released)
        else:
            self._start_afresh(role, released)

    def _go_on(self, released: Released) -> None:
        """Let the suspects in that are ahead: there was a gap, which says nothing of the pace."""
        outputs, newest = released['output'], self.newest['output']
        if outputs and newest is not None:
            self._first += max(outputs[0][0] - newest, 0)
        for role, samples in released.items():
            for stamp, values in samples:
                newest = self.newest[role]
                if newest is None or stamp > newest:
                    self._enter(role, stamp, values)

    def _start_afresh(self, role: Role, released: Released) -> None:
        """Forget all but the suspects of both streams, which belong to the new timeline."""
        first, last = released[role][0][0], released[role][-1][0]
        before = self._newest_around(role, first if self._over is None else self._over)
        self.last_break = describe_break(role, before, first)
        self.counts['reset'] += 1
        released = {**released, 'input': [*self._early, *released['input']]}
        self.reset()
        self._store.forget()
        self._interval = (last - first) / (len(released[role]) - 1)
        for each, samples in released.items():
            for stamp, values in samples:
                self._place(each, stamp, values)
