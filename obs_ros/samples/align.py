"""One grid for two streams: the outputs and inputs of a window as a Record."""

from collections.abc import Sequence

import numpy as np

from obs_ros.core.interpolation import segment
from obs_ros.core.model import Interpolation
from obs_ros.core.record import Record
from obs_ros.core.typing import Array, BoolArray, IntArray
from obs_ros.samples.stream import InputStream, Stream


def align(
    outputs: Stream,
    inputs: InputStream,
    end: int,
    interpolation: Sequence[Interpolation],
    past: int = 0,
    period: float | None = None,
) -> Record | None:
    """Return the stored samples up to `end` (ns), from the first output to the last.

    With the `period` (s) of a discrete model the record's rows are its nodes, with the inputs in
    force there: those of the last samples up to a node.

    None with fewer than two outputs. Nodes before the first and after the last output are left
    out, since nothing was measured there that an estimate could be compared with; inputs are kept
    for so long before as `past` (ns). Where only inputs came that hold on as they were, is no node.
    """
    count = outputs.count_until(end)
    if count < 2:
        return None
    first, last = int(outputs.stamps[0]), int(outputs.stamps[count - 1])
    rows = slice(inputs.count_until(first - 1), inputs.count_until(last))
    output_times, input_times = seconds(outputs.stamps[:count]), seconds(inputs.stamps[rows])
    values = inputs.values[rows]
    if period is None:
        telling = _telling(inputs, rows, interpolation)
        telling |= np.isin(input_times, output_times, assume_unique=True)
        input_times, values = input_times[telling], values[telling]
        t = np.union1d(output_times, input_times)
    else:
        nodes = nodes_between(outputs.stamps[:count], round(1e9 * period))
        t, places = seconds(nodes), nodes.searchsorted(inputs.stamps[rows])
        input_times = t[places]
    if t.size < 2:
        return None
    y = on_grid(t, output_times, outputs.values[:count])
    u = on_grid(t, input_times, values)
    for column, kind in enumerate(interpolation):
        if np.isnan(u[0, column]):
            u[0, column] = value_at_start(inputs, first, column, kind)
        if np.isnan(u[-1, column]):
            u[-1, column] = value_at_end(inputs, last, column, kind)
    before = _before(inputs, first, past, interpolation) if past else None
    return Record(t, u, y, last, before)


def _telling(inputs: InputStream, rows: slice, kinds: Sequence[Interpolation]) -> BoolArray:
    """Whether the input samples (L,) tell more than that inputs hold on as they were."""
    values = inputs.values[rows]
    telling = np.zeros(len(values), dtype=np.bool_)
    for column, kind in enumerate(kinds):
        known = np.flatnonzero(~np.isnan(values[:, column]))
        if kind == 'hold' and known.size:
            held = inputs.before(int(inputs.stamps[rows][0]) - 1, column)[1]
            known = known[np.diff(values[known, column], prepend=held) != 0.0]
        telling[known] = True
    return telling


def _before(
    inputs: InputStream, first: int, past: int, interpolation: Sequence[Interpolation]
) -> tuple[Array, Array]:
    """Return times (L,) and inputs (L, m) from so long before `first` (ns) as `past` to there."""
    begin = first - past
    rows = slice(inputs.count_until(begin - 1), inputs.count_until(first))
    times = seconds(inputs.stamps[rows])
    t = np.union1d(times, seconds(np.array([begin, first])))
    u = on_grid(t, times, inputs.values[rows])
    for column, kind in enumerate(interpolation):
        if np.isnan(u[0, column]):
            u[0, column] = value_at_start(inputs, begin, column, kind)
    return t, u


def seconds(stamps: IntArray) -> Array:
    """Return stamps (K,) in ns as the nearest times in s."""
    # The division rounds once where * 1e-9 rounds twice: 0.3 s is 0.3, not 0.30000000000000004.
    return stamps.astype(np.float64) / 1e9


def nodes_between(stamps: IntArray, period: int) -> IntArray:
    """Return the nodes (K,) from the first to the last of some (L,), in ns, and `period` ns apart.

    Where their phase changes, nodes are a little closer or farther.
    """
    gaps = np.diff(stamps)
    counts = np.maximum(1, np.rint(gaps / period)).astype(np.int64)
    number = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    steps = number * np.repeat(gaps, counts) // np.repeat(counts, counts)
    return np.append(np.repeat(stamps[:-1], counts) + steps, stamps[-1:])


def on_grid(t: Array, times: Array, values: Array) -> Array:
    """Return values (n, width) at their times (n,) on the grid t (K,), NaN elsewhere."""
    grid = np.full((t.size, values.shape[1]), np.nan)
    rows, columns = np.nonzero(~np.isnan(values))  # a NaN must not wipe out a node's other sample
    grid[np.searchsorted(t, times)[rows], columns] = values[rows, columns]
    return grid


def value_at_start(inputs: InputStream, stamp: int, column: int, kind: Interpolation) -> float:
    """Return the input at the first node: from there on, each kind of interpolation is right.

    `mean` needs the sample before, not the input at the node: the mean of the samples before and
    after the node is the input on both sides of it.
    """
    return between(inputs, stamp, column) if kind == 'linear' else inputs.before(stamp, column)[1]


def value_at_end(inputs: InputStream, stamp: int, column: int, kind: Interpolation) -> float:
    """Return the input at the last node, NaN if the last sample holds until there."""
    if kind == 'hold':
        return float('nan')
    after = inputs.after(stamp, column)[1]
    return between(inputs, stamp, column) if kind == 'linear' else after


def between(inputs: InputStream, stamp: int, column: int) -> float:
    """Return the input interpolated at `stamp`, or its last value if no later one is known."""
    earlier, value = inputs.before(stamp, column)
    later, next_value = inputs.after(stamp, column)
    if np.isnan(next_value):
        return value
    gap, after = (later - earlier) / 1e9, (stamp - earlier) / 1e9
    return segment('linear', value, next_value, gap, after)[0]
