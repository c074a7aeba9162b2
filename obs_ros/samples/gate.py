"""Samples as they come, made fit for observers that go from output to output."""

from collections.abc import Mapping
from operator import index

import numpy as np

from obs_ros.core.model import Model
from obs_ros.core.record import Sample
from obs_ros.core.typing import Array
from obs_ros.integration.input_history import HeldInputs
from obs_ros.samples.break_detector import Suspects, describe_break
from obs_ros.samples.range_check import COUNTS as MEASURABLE
from obs_ros.samples.range_check import limits, measured
from obs_ros.samples.stream import STAMP_LIMIT
from obs_ros.samples.stuck_sensor import Repeats

COUNTS = {
    'late': 'outputs older than the newest: dropped; inputs: dropped too, or in force from now on',
    'duplicate': 'samples dropped: their stream has that stamp already, and the first one counts',
    **MEASURABLE,
    'stuck': 'outputs with entries that a stuck sensor repeats, which count as not measured',
    'ahead': 'samples dropped: a stray stamp, far ahead of the newest one',
    'out_of_range': f'samples dropped: a stamp beyond +-{STAMP_LIMIT} ns',
    'early': 'outputs dropped: not every input had a value yet',
    'overflow': 'inputs dropped, oldest first: too many came without an output',
    'reset': 'breaks of the timeline, after which all samples were forgotten',
}
SHORTEST_GAP, FIRST_GAP = 10.0, 60.0  # s
INTERVALS = 1000  # mean intervals between outputs that may pass at once

Output = tuple[int, Array]


class Intake:
    """Checks, orders and counts samples; hands the outputs out, one after the other.

    An output must be newer than the last; an input that comes late is in force from the last output
    on. Stamps that jump back, or ahead by more than `longest_gap` s, are believed when five samples
    of a stream in a row tell of them: all is forgotten then, and `last_break` says so. What a stuck
    sensor repeats counts as not measured; `repeats` tells which are. `noise` tells of which outputs
    the noise is known.
    """

    def __init__(
        self, model: Model, longest_gap: float, noise: Mapping[str, float] | None = None
    ) -> None:
        self.inputs = HeldInputs(model)
        # Outputs whose noise is known cannot stand still; see `stuck`.
        self.repeats = Repeats([variable.name in (noise or {}) for variable in model.outputs])
        self._limits = {
            'input': limits(model, model.inputs), 'output': limits(model, model.outputs)
        }  # fmt: skip
        self.counts = dict.fromkeys(COUNTS, 0)
        self.last_break: str | None = None
        self._width = {'input': len(model.inputs), 'output': len(model.outputs)}
        self._longest_gap = longest_gap
        self._suspects = {'input': Suspects(), 'output': Suspects()}
        self.reset()

    def reset(self) -> None:
        """Forget all samples, but not the counts."""
        for suspects in self._suspects.values():
            self.counts['ahead'] += suspects.clear()
        self.inputs.clear()
        self.repeats.clear()
        self._newest: dict[str, int | None] = {'input': None, 'output': None}
        self._first, self._count = 0, 0  # outputs of this timeline
        self._begun: int | None = None  # the newest output handed out
        self._interval = 0.0  # ns, mean over the samples that told of this timeline

    def push(self, sample: Sample) -> list[Output]:
        """Take a sample; return the outputs (stamp in ns, values) that are due now.

        When `last_break` is another than before, they begin a new timeline.

        Raises ValueError if the number of outputs or inputs is wrong.
        """
        y = self._checked('output', sample.y)
        u = self._checked('input', sample.u)
        stamp = index(sample.stamp)
        due: list[Output] = []
        if not -STAMP_LIMIT < stamp < STAMP_LIMIT:
            self.counts['out_of_range'] += 1
            return due
        for stream, values in (('input', u), ('output', y)):
            if values is not None:
                values = measured(values, self._limits[stream], self.counts)
            if values is not None:
                self._place(stream, stamp, values, due)
        return due

    def _checked(self, stream: str, values: Array | None) -> Array | None:
        if values is None:
            return None
        # A copy: compiled steps must see one layout, and whoever publishes may reuse the array.
        array = np.array(values, dtype=np.float64, order='C')
        width = self._width[stream]
        if array.shape != (width,):
            raise ValueError(f'sample has {stream}s of shape {array.shape}, not ({width},)')
        return array if width else None

    def _place(self, stream: str, stamp: int, values: Array, due: list[Output]) -> None:
        newest = self._newest[stream]
        if newest is not None and stamp <= newest:
            self.counts['duplicate' if stamp == newest else 'late'] += 1
            self._suspect(stream, stamp, values, due, ahead=False)
        elif self._far_ahead(stamp - self._newest_around(stream, stamp)):
            self._suspect(stream, stamp, values, due, ahead=True)
        else:
            if self._suspects[stream]:
                self.counts['ahead'] += self._suspects[stream].clear()
            self._newest[stream] = stamp
            if stream == 'input':
                self._accept_input(stamp, values)
            else:
                self._accept_output(stamp, values, due)

    def _accept_input(self, stamp: int, values: Array) -> None:
        if self._begun is not None and stamp < self._begun:
            self.counts['late'] += 1
            stamp = self._begun
        self.counts['overflow'] += not self.inputs.add(stamp, values)

    def _accept_output(self, stamp: int, values: Array, due: list[Output]) -> None:
        if not self._count:
            self._first = stamp
        self._count += 1
        if stuck := self.repeats.note(values):
            self.counts['stuck'] += 1
            values = values.copy()
            values[list(stuck)] = np.nan
            if np.isnan(values).all():
                return
        if self.inputs.known_at(stamp):
            self._begun = stamp
            due.append((stamp, values))
        else:
            self.counts['early'] += 1

    def _far_ahead(self, gap: int) -> bool:
        """Whether a sample so far (ns) ahead of all others cannot be on their timeline."""
        if self._longest_gap:
            return gap > self._longest_gap * 1e9
        if gap <= SHORTEST_GAP * 1e9:
            return False
        newest, mean = self._newest['output'], self._interval
        if newest is not None and self._count > 1:
            mean = max(mean, (newest - self._first) / (self._count - 1))
        return gap > (INTERVALS * mean if mean else FIRST_GAP * 1e9)

    def _newest_around(self, stream: str, default: int) -> int:
        """Return the newest stamp of the stream; for inputs, of both streams."""
        own, outputs = self._newest[stream], self._newest['output']
        if own is None or outputs is None:
            return next((each for each in (own, outputs) if each is not None), default)
        return outputs if outputs > own else own

    def _suspect(
        self, stream: str, stamp: int, values: Array, due: list[Output], *, ahead: bool
    ) -> None:
        suspects = self._suspects[stream]
        self.counts['ahead'] += suspects.add(stamp, values, ahead=ahead)
        if suspects.believed:
            self._start_afresh(stream, due)

    def _start_afresh(self, stream: str, due: list[Output]) -> None:
        """Forget all but the suspects of both streams, which belong to the new timeline."""
        released = {name: suspects.release() for name, suspects in self._suspects.items()}
        first, last = released[stream][0][0], released[stream][-1][0]
        self.last_break = describe_break(stream, self._newest_around(stream, first), first)
        self.counts['reset'] += 1
        self.reset()
        self._interval = (last - first) / (len(released[stream]) - 1)
        due.clear()
        # Inputs come first: the first of them is then accepted, and no second break can follow.
        for name in ('input', 'output'):
            for stamp, values in released[name]:
                self._place(name, stamp, values, due)
