"""A window that slides along two streams of samples: aligned, ordered, gap-aware."""

from collections.abc import Mapping, Sequence
from operator import index
from typing import get_args

import numpy as np

from obs_ros.core.model import Interpolation
from obs_ros.core.record import Record, Sample
from obs_ros.core.typing import Array, IntArray
from obs_ros.samples.align import align
from obs_ros.samples.break_detector import Suspects, describe_break
from obs_ros.samples.range_check import COUNTS as MEASURABLE
from obs_ros.samples.range_check import Limits, anything, measured
from obs_ros.samples.stream import STAMP_LIMIT, InputStream, Stream

COUNTS = {
    'late': 'samples dropped: they came after their window had been taken',
    'reordered': 'samples that came late, but in time to be sorted in',
    'duplicate': 'samples dropped: their stream has that stamp already, and the first one counts',
    **MEASURABLE,
    'ahead': 'samples dropped: a stray stamp, far ahead of the newest one',
    'out_of_range': f'samples dropped: a stamp beyond +-{STAMP_LIMIT} ns',
    'before_input': 'outputs dropped: not every input had a value yet',
    'overflow': 'samples dropped, oldest first: their stream had reached its capacity',
    'too_few': 'windows dropped: fewer than two outputs',
    'skipped': 'windows passed over: a newer one had closed as well',
    'reset': 'breaks of the timeline, after which all samples were forgotten',
}


class SlidingWindow:
    """Turns output and input samples, in any order of arrival, into one Record per window.

    With T the `duration` and D the `period` (s; by default T, so that windows abut), window k
    covers (t0 + k D, t0 + k D + T]. t0, itself included, is the first output at which every input
    has a value. A window closes when outputs and inputs both have a sample at or after its end.
    Stamps are the only time; arrival time plays no part.

    A record starts and ends with an output of its window. In between, its grid is the union of
    output and input stamps; what a stream did not measure at a node is NaN there. At the two ends,
    which may lie between two samples of an input, the record carries what makes the input right up
    to there: at the first node the last value (`hold`, `mean`) or the interpolated one (`linear`),
    at the last node nothing (`hold`), the interpolated value (`linear`) or the next one (`mean`).
    So no record needs a sample from outside. Its t is the stamp in s; at the size of today's
    dates such a float resolves 0.24 us, and samples closer than that share a node.

    A new timeline (stamps that jump back, or ahead of everything by more than T + D) is believed
    when five samples of a stream in a row tell of it: all older samples are forgotten, and
    `last_break` says so. Samples dropped or mended are counted by reason, see COUNTS.

    One thread at a time may call its methods. Memory is bounded by `capacity` samples a stream.

    `limits` of the inputs and of the outputs say between what a measurement lies.

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
    ) -> None:
        if capacity < 2:
            raise ValueError(f'capacity {capacity} is too small: a window needs two samples')
        if n_inputs < 0 or n_outputs < 1:
            raise ValueError(f'{n_inputs} inputs and {n_outputs} outputs: at least 0 and 1 needed')
        self._duration = nanoseconds('duration', duration)
        self._period = self._duration if period is None else nanoseconds('period', period)
        # The farthest that a sample can be from the newest of its stream and on its timeline.
        self._reach = self._duration + self._period
        self._interpolation = check_interpolation(interpolation, n_inputs)
        input_limits, output_limits = limits or (anything(n_inputs), anything(n_outputs))
        self._capacity = capacity
        self._outputs = Stream(n_outputs, capacity)
        self._inputs = InputStream(n_inputs, capacity)
        self._limits = {self._inputs: input_limits, self._outputs: output_limits}
        self._suspects = {stream: Suspects() for stream in (self._inputs, self._outputs)}
        self._counts = dict.fromkeys(COUNTS, 0)
        # The open window covers (left, end] once its place is settled; before that, a late output
        # may still move t0.
        self._edges: tuple[int, int] | None = None
        self.last_break: str | None = None

    @property
    def counts(self) -> Mapping[str, int]:
        """How many samples or windows were dropped or mended since construction, by reason."""
        return dict(self._counts)

    @property
    def newest_output(self) -> int | None:
        """Stamp of the newest output (ns), None before the first."""
        return self._outputs.newest

    @property
    def newest_input(self) -> int | None:
        """Stamp of the newest input (ns), None before the first."""
        return self._inputs.newest

    @property
    def end(self) -> int | None:
        """Stamp (ns) that both streams must reach for the next window; None before the first."""
        edges = self._edges or self._first_edges()
        return edges[1] if edges else None

    @property
    def collected(self) -> float | None:
        """Time (s) from the start of the next window to where both streams are; None: no start."""
        edges = self._edges or self._first_edges()
        if edges is None:
            return None
        newest = [s.newest for s in (self._outputs, self._inputs) if s.width]
        reached = min(edges[0] if stamp is None else stamp for stamp in newest)
        return min(max(reached - edges[0], 0), self._duration) / 1e9

    @property
    def nbytes(self) -> int:
        """Memory taken by the stored samples (bytes)."""
        return self._outputs.nbytes + self._inputs.nbytes

    def push(self, sample: Sample) -> None:
        """Store a sample; raises ValueError if the number of outputs or inputs is wrong."""
        y = self._checked('outputs', sample.y, self._outputs.width)
        u = self._checked('inputs', sample.u, self._inputs.width)
        stamp = index(sample.stamp)
        if not -STAMP_LIMIT < stamp < STAMP_LIMIT:
            self._counts['out_of_range'] += 1
            return
        for stream, values in ((self._inputs, u), (self._outputs, y)):
            if values is not None:
                values = measured(values, self._limits[stream], self._counts)
            if values is not None:
                self._place(stream, stamp, values)

    def take(self) -> Record | None:
        """Return the oldest window that is closed and was not returned yet, or None."""
        return self._take(newest=False)

    def take_newest(self) -> Record | None:
        """Return the newest window that is closed, or None; closed ones before it are skipped."""
        return self._take(newest=True)

    def reset(self) -> None:
        """Forget all samples, but not the counts."""
        for suspects in self._suspects.values():
            self._counts['ahead'] += suspects.clear()
        self._outputs.clear()
        self._inputs.clear()
        self._edges = None

    def _checked(self, name: str, values: Array | None, width: int) -> Array | None:
        if values is None:
            return None
        array = np.asarray(values, dtype=np.float64)
        if array.shape != (width,):
            raise ValueError(f'sample has {name} of shape {array.shape}, not ({width},)')
        return array if width else None

    def _place(self, stream: Stream, stamp: int, values: Array) -> None:
        """Append or sort in the sample, or hold it back."""
        suspects = self._suspects[stream]
        if stream.newest is not None and stamp <= stream.newest:
            self._counts[self._sort_in(stream, stamp, values)] += 1
            self._suspect(stream, stamp, values, ahead=False)
        elif stamp - self._newest_around(stream, stamp) > self._reach:
            self._suspect(stream, stamp, values, ahead=True)
        else:
            if suspects:
                self._counts['ahead'] += suspects.clear()
            stream.append(stamp, values)
        if len(stream) > self._capacity:
            self._overflow(stream)

    def _sort_in(self, stream: Stream, stamp: int, values: Array) -> str:
        """Store a sample that is not the newest, if it is of use; return what became of it."""
        assert stream.newest is not None
        if stamp == stream.newest:
            return 'duplicate'
        # Before the first window has its place, a stray old stamp must not become its start.
        left = self._edges[0] if self._edges else stream.newest - self._reach
        if stamp > left:
            return 'reordered' if stream.insert(stamp, values) else 'duplicate'
        # An input from before the open window may be the value that holds when it starts.
        if self._edges and stream is self._inputs and self._inputs.remember(stamp, values):
            return 'reordered'
        return 'late'

    def _newest_around(self, stream: Stream, default: int) -> int:
        """Return the newest stamp of the stream; for inputs, of both streams.

        Inputs may be rare, a set point now and then: outputs show that time went on meanwhile.
        """
        own, outputs = stream.newest, self._outputs.newest
        if own is None or outputs is None:
            return next((each for each in (own, outputs) if each is not None), default)
        return outputs if outputs > own else own

    def _suspect(self, stream: Stream, stamp: int, values: Array, *, ahead: bool) -> None:
        suspects = self._suspects[stream]
        self._counts['ahead'] += suspects.add(stamp, values, ahead=ahead)
        if suspects.believed:
            self._start_afresh(stream)

    def _start_afresh(self, stream: Stream) -> None:
        """Forget all but the suspects of both streams, which belong to the new timeline."""
        name = 'output' if stream is self._outputs else 'input'
        released = {each: suspects.release() for each, suspects in self._suspects.items()}
        stamp = released[stream][0][0]
        self.last_break = describe_break(name, self._newest_around(stream, stamp), stamp)
        self._counts['reset'] += 1
        self.reset()
        # Inputs come first: the first of them is then accepted, and no second break can follow.
        for each in (self._inputs, self._outputs):
            for stamp, values in released[each]:
                self._place(each, stamp, values)

    def _overflow(self, stream: Stream) -> None:
        """Drop the oldest sample; where the first window starts is settled by now."""
        if self._edges is None and (edges := self._first_edges()):
            self._open(edges)
        excess = len(stream) - self._capacity
        if excess > 0:
            unused = stream is self._outputs and self._edges is None
            self._counts['before_input' if unused else 'overflow'] += excess
            stream.drop(excess)

    def _first_edges(self) -> tuple[int, int] | None:
        """Return the edges of the first window as far as known now."""
        since = self._inputs.known_since
        if since is None:
            return None
        row = self._outputs.count_until(since - 1)
        if row == len(self._outputs):
            return None
        start = int(self._outputs.stamps[row])
        # One ns earlier, so that the first window includes its start and is like all others.
        return start - 1, start + self._duration

    def _open(self, edges: tuple[int, int]) -> None:
        """Drop what lies before the window's left edge, where it now stays."""
        unused = self._outputs.drop_until(edges[0])
        self._inputs.drop_until(edges[0])
        if self._edges is None:
            self._counts['before_input'] += unused
        # Outputs from a time whose inputs were dropped would be paired with later inputs.
        if self._inputs.known_since is not None:
            self._counts['overflow'] += self._outputs.drop_until(self._inputs.known_since - 1)
        self._edges = edges

    def _take(self, *, newest: bool) -> Record | None:
        while (edges := self._edges or self._first_edges()) and self._passed() >= edges[1]:
            self._open(edges)
            last = (self._passed() - edges[1]) // self._period
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
            record = align(self._outputs, self._inputs, self._edges[1], self._interpolation)
            self._move_on(1)
            if record is not None:
                return record
            self._counts['too_few'] += 1
        return None

    def _passed(self) -> int:
        """Return the stamp (ns) that outputs and inputs have reached."""
        newest = [stream.newest for stream in (self._outputs, self._inputs) if stream.width]
        return min(-STAMP_LIMIT if stamp is None else stamp for stamp in newest)

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


def check_interpolation(
    interpolation: Sequence[Interpolation] | None, n_inputs: int
) -> tuple[Interpolation, ...]:
    """Return one interpolation per input; raises ValueError for another number or unknown ones."""
    if interpolation is None:
        hold: Interpolation = 'hold'
        return (hold,) * n_inputs
    if len(interpolation) != n_inputs:
        raise ValueError(f'{len(interpolation)} interpolations given for {n_inputs} inputs')
    for kind in interpolation:
        if kind not in get_args(Interpolation):
            raise ValueError(
                f'interpolation {kind!r} is none of {", ".join(get_args(Interpolation))}'
            )
    return tuple(interpolation)
