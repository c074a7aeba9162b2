"""A window that slides along two streams of samples: aligned, ordered, gap-aware."""

from collections.abc import Mapping, Sequence

import numpy as np

from obs_ros.core.interpolation import check_kinds
from obs_ros.core.model import Interpolation, Variable
from obs_ros.core.record import Record, Sample
from obs_ros.core.typing import Array, IntArray
from obs_ros.samples.align import align
from obs_ros.samples.delay_line import Shifts
from obs_ros.samples.gate import COUNTS as ENTERING
from obs_ros.samples.gate import Gate, GateSettings
from obs_ros.samples.merge import Role
from obs_ros.samples.range_check import Limits, anything
from obs_ros.samples.saturation_count import SaturationCount
from obs_ros.samples.stream import STAMP_LIMIT, InputStream, Stream

COUNTS = {
    **ENTERING,
    'before_input': 'outputs dropped: not every input had a value yet',
    'overflow': 'samples dropped, oldest first: their stream had reached its capacity',
    'too_few': 'windows dropped: fewer than two outputs',
    'skipped': 'windows passed over: a newer one had closed as well',
}


class SlidingWindow:
    """Turns output and input samples, in any order of arrival, into one Record per window.

    With T the `duration` and D the `period` (s; by default T, so that windows abut), window k
    covers (t0 + k D, t0 + k D + T]. t0, itself included, is the first output at which every input
    has a value. A window closes when outputs and inputs both have a sample at or after its end.
    Stamps are the only time; arrival time plays no part.

    A record starts and ends with an output of its window. In between, its grid is the union of
    output and input stamps, less those at which inputs only hold on as they were; a value that a
    stream did not measure at a node is NaN there. The two ends may lie between two samples of an
    input. There the record has the value that makes the input right up to the end: at the first
    node the last one (`hold`, `mean`) or the interpolated one (`linear`), at the last node none
    (`hold`), the interpolated one (`linear`) or the next one (`mean`). So no record needs a sample
    from outside. Its t is the stamp in s; at the size of today's dates such a float resolves
    0.24 us, and samples closer than that share a node.

    Samples enter by the rules of `Gate`, with a reach of T + D; those dropped or mended are counted
    by reason, see COUNTS. `limits` are those of measured inputs and outputs, `shifts` lead from
    stamps to the samples' own times, at which they lie here; of the inputs before a window records
    have those that they ask for. With the period `nodes` (s) of a discrete model samples lie at its
    nodes, and windows end halfway between two: no drift moves a node out of its window. Values of
    saturated sensors are counted for the `outputs` given.

    One thread at a time may call its methods. Memory is bounded by `capacity` samples a stream.

    Raises ValueError for a duration or period that is not positive, a capacity below 2, fewer
    than no inputs or one output, and an unknown `interpolation` (one per input, default `hold`).
    """

    def __init__(
        self,
        duration: float,
        period: float | None = None,
        *,
        n_inputs: int,
        n_outputs: int,
        capacity: int = 20000,
        interpolation: Sequence[Interpolation] | None = None,
        limits: tuple[Limits, Limits] | None = None,
        outputs: Sequence[Variable] = (),
        shifts: Shifts | None = None,
        nodes: float | None = None,
    ) -> None:
        if capacity < 2:
            raise ValueError(f'capacity {capacity} is too small: a window needs two samples')
        if n_inputs < 0 or n_outputs < 1:
            raise ValueError(f'{n_inputs} inputs and {n_outputs} outputs: at least 0 and 1 needed')
        self._duration = nanoseconds('duration', duration)
        self._period = self._duration if period is None else nanoseconds('period', period)
        self._interpolation = check_kinds(interpolation, n_inputs)
        self._capacity = capacity
        self._outputs = Stream(n_outputs, capacity)
        self._inputs = InputStream(n_inputs, capacity)
        reach = GateSettings(reach=(self._duration + self._period) / 1e9)
        limits = limits or (anything(n_inputs), anything(n_outputs))
        self._gate = Gate(*limits, self, reach, shifts, nodes)
        self._nodes = nodes
        self._half = round(0.5e9 * (nodes or 0.0))
        self._saturation = SaturationCount(outputs)
        self._past = 0 if shifts is None else shifts.past
        self._counts = dict.fromkeys(COUNTS.keys() - ENTERING.keys(), 0)
        # The open window covers (left, end] once its place is settled; before that, a late output
        # may still move t0.
        self._edges: tuple[int, int] | None = None
        self._resumed = False  # and no window was taken since

    @property
    def counts(self) -> Mapping[str, int]:
        """Numbers of samples and windows dropped, mended or saturated so far, by reason."""
        return {**self._gate.counts, **self._counts, **self._saturation.counts}

    @property
    def last_break(self) -> str | None:
        """The last break of the samples' timeline, in words."""
        return self._gate.last_break

    @property
    def passed(self) -> int | None:
        """The end of the last window, or the open one's left edge if that overlaps."""
        if self._edges is None:
            return None
        left, end = self._edges
        return min(left, end - self._period)

    @property
    def end(self) -> int | None:
        """Stamp (ns) that both streams must reach for the next window; None before the first."""
        edges = self._edges or self._first_edges()
        return edges[1] if edges else None

    @property
    def collected(self) -> float | None:
        """Time (s) from the start of the next window to where both streams are, or None."""
        edges = self._edges or self._first_edges()
        if edges is None:
            return None
        return min(max(self._reached() - edges[0], 0), self._duration) / 1e9

    @property
    def nbytes(self) -> int:
        """Memory taken by the stored samples (bytes)."""
        return self._outputs.nbytes + self._inputs.nbytes

    @property
    def last_end(self) -> int | None:
        """End (ns) of the window before the open one; None before the first."""
        return None if self._edges is None else self._edges[1] - self._period

    def resume(self, last_end: int) -> None:
        """Open the window after one that ended there (ns), as across a gap; nothing came yet.

        Outputs of the time before it begin a new timeline, as they would without a restart.
        """
        end = last_end + self._period
        self._open((end - self._duration, end))
        self._resumed = True
        self._gate.resume(min(last_end, end - self._duration))

    def push(self, sample: Sample) -> bool:
        """Take a sample; return whether it began a new timeline.

        Raises ValueError if the number of outputs or inputs is wrong.
        """
        return self._gate.push(sample)

    def keep(self, role: Role, stamp: int, values: Array) -> bool:
        """See `Store`."""
        passed = self.passed if role == 'input' else None
        if passed is not None and stamp <= passed - self._past:
            # An input from before the open window may be the value that holds when it starts.
            return self._inputs.remember(stamp, values)
        stream = self._inputs if role == 'input' else self._outputs
        kept = stream.add(stamp, values)
        if kept and role == 'output':
            self._saturation.note(values)
        if len(stream) > self._capacity:
            self._overflow(stream)
        return kept

    def take(self) -> Record | None:
        """Return the oldest window that is closed and was not returned yet, or None."""
        return self._take(newest=False)

    def take_newest(self) -> Record | None:
        """Return the newest window that is closed, or None; closed ones before it are skipped."""
        return self._take(newest=True)

    def reset(self) -> None:
        """Forget all samples, but not the counts."""
        self._gate.reset()
        self.forget()

    def forget(self) -> None:
        """See `Store`."""
        self._outputs.clear()
        self._inputs.clear()
        self._edges, self._resumed = None, False

    def _overflow(self, stream: Stream) -> None:
        """Drop the oldest sample; where the first window starts is settled by now."""
        if self._edges is None and (edges := self._first_edges()):
            self._open(edges)
        excess = len(stream) - self._capacity
        if excess > 0:
            unpaired = self._edges is None or self._inputs.known_since is None
            unused = stream is self._outputs and unpaired
            self._counts['before_input' if unused else 'overflow'] += excess
            stream.drop(excess)

    def _first_edges(self) -> tuple[int, int] | None:
        """Return the edges of the first window as far as known now."""
        since = self._inputs.known_since
        if since is None:
            return None
        row = self._outputs.count_until(since + self._past - 1)
        if row == len(self._outputs):
            return None
        start = int(self._outputs.stamps[row])
        # One ns earlier, so that the first window includes its start and is like all others.
        return start - 1, start + self._duration + self._half

    def _open(self, edges: tuple[int, int]) -> None:
        """Drop the samples before the window's left edge, where it now stays."""
        unused = self._outputs.drop_until(edges[0])
        self._inputs.drop_until(edges[0] - self._past)
        if self._edges is None:
            self._counts['before_input'] += unused
        # Outputs from a time whose inputs were dropped would be paired with later inputs.
        if self._inputs.known_since is not None:
            since = self._inputs.known_since + self._past
            reason = 'before_input' if self._resumed else 'overflow'
            self._counts[reason] += self._outputs.drop_until(since - 1)
            self._resumed = False
        self._edges = edges

    def _take(self, *, newest: bool) -> Record | None:
        while (edges := self._edges or self._first_edges()) and self._reached() >= edges[1]:
            self._open(edges)
            last = (self._reached() - edges[1]) // self._period
            lows, highs = self._solvable(edges[1], last)
            if not lows.size:
                self._counts['too_few'] += last + 1
                self._move_on(last + 1)
                return None
            chosen = int(highs[-1] if newest else lows[0])
            if newest:
                begins = np.maximum(lows, np.concatenate([[0], highs[:-1] + 1]))
                skipped = int(np.maximum(highs - begins + 1, 0).sum()) - 1
                self._counts['skipped'] += skipped
            else:
                skipped = 0
            self._counts['too_few'] += chosen - skipped
            if chosen:
                self._move_on(chosen)
            assert self._edges is not None
            streams, end = (self._outputs, self._inputs), self._edges[1]
            record = align(*streams, end, self._interpolation, self._past, self._nodes)
            self._move_on(1)
            if record is not None:
                return record
            self._counts['too_few'] += 1
        return None

    def _reached(self) -> int:
        """Return the stamp (ns) that outputs and inputs have both reached."""
        reached = self._gate.reached()
        return -STAMP_LIMIT if reached is None else reached

    def _solvable(self, end: int, last: int) -> tuple[IntArray, IntArray]:
        """Return first and last number of the windows that hold two neighbouring outputs, by pairs.

        Window 0 ends at `end` (ns); those after window `last` are not looked at. Windows without
        any pair are in none of these ranges, so that no number of them takes time.
        """
        stamps = self._outputs.stamps
        left = end - self._duration
        lows = np.maximum(-((end - stamps[1:]) // self._period), 0)
        # Outputs before the open window are dropped: all that is there is at least in window 0.
        highs = np.clip((stamps[:-1] - left - 1) // self._period, 0, last)
        some = lows <= highs
        return lows[some], highs[some]

    def _move_on(self, windows: int) -> None:
        """Open the window that comes so many windows after the open one."""
        assert self._edges is not None
        end = self._edges[1] + windows * self._period
        self._open((end - self._duration, end))


def nanoseconds(name: str, seconds: float) -> int:
    """Return the time in ns; raises ValueError unless it is positive and below 73 years."""
    if not 1e-9 <= seconds < STAMP_LIMIT / 2 * 1e-9:
        raise ValueError(f'{name} {seconds} s is not a positive time of 1e-9 to 2.3e9 s')
    return round(seconds * 1e9)
