"""Parameters along a window in which some jump: sets of them, which one holds where, their prior.

In the interval of its jump a parameter has its mean over that interval, so that outputs depend
smoothly on the time. Loops, compiled where Numba is: arrays have as many rows as a window has
jumps.
"""

import functools
from typing import NamedTuple

import numpy as np

from obs_ros.core.jit import accelerated
from obs_ros.core.typing import Array, IntArray


class Placed(NamedTuple):
    """The jumps of single parameters (J,) of a layout.

    `event` is that of each, `parameter` its place among the unknowns, `after` that of its new value
    in a point, `row` the place among the model's parameters, `weight` the precision of its size.
    """

    event: IntArray
    parameter: IntArray
    after: IntArray
    row: IntArray
    weight: Array


class Schedule(NamedTuple):
    """Sets of parameters (S, q, B), those along each interval (K,) and those at each node (K,)."""

    sets: Array
    along: IntArray
    there: IntArray


@functools.cache
def prepare() -> None:
    """Compile what is below, or load it compiled."""
    place, row, t = np.zeros(1, dtype=np.int64), np.ones((1, 1)), np.arange(2.0)
    times, intervals = moments(row, t, 0.0)
    scheduled(times, intervals, t, place, place, row, row)
    placed = place, place, place, t[1:]
    normal(row[0], place, *placed, row[0], row)


@accelerated
def reached(t: Array, time: float) -> int:
    """Return the first of nodes t (K,) that is no earlier than a time; K if none is."""
    low, high = 0, t.size
    while low < high:
        middle = (low + high) // 2
        if t[middle] < time:
            low = middle + 1
        else:
            high = middle
    return low


@accelerated
def moments(shares: Array, t: Array, rounding: float) -> tuple[Array, IntArray]:
    """Return times (E, B), in s from the start, and their intervals (E, B), of shares (B, E).

    Nodes t (K,) begin at 0; a time within `rounding` of a node is the node's. The interval k of a
    time is that with t[k] < time <= t[k + 1]; the nearest if there is none.
    """
    lanes, events = shares.shape
    last = t.size - 1
    times, intervals = np.empty((events, lanes)), np.empty((events, lanes), dtype=np.int64)
    for e in range(events):
        for lane in range(lanes):
            time = shares[lane, e] * t[last]
            above = reached(t, time)
            for node in (min(above, last), max(above - 1, 0)):
                if abs(time - t[node]) <= rounding:
                    time = t[node]
            times[e, lane] = time
            intervals[e, lane] = min(max(reached(t, time) - 1, 0), last - 1)
    return times, intervals


@accelerated
def in_order(times: Array, lane: int, order: IntArray) -> None:
    """Write the places (E,) of a lane's times (E, B) in rising order; equal ones keep theirs."""
    for e in range(order.size):
        i = e
        while i > 0 and times[order[i - 1], lane] > times[e, lane]:
            order[i] = order[i - 1]
            i -= 1
        order[i] = e


@accelerated
def scheduled(
    times: Array,
    intervals: IntArray,
    t: Array,
    event: IntArray,
    row: IntArray,
    values: Array,
    p: Array,
) -> tuple[Array, IntArray, IntArray]:
    """Return the `Schedule` of candidates with times (E, B) in such intervals (E, B).

    Values (J, B) are those after each jump, p (q, B) the parameters at the start; `event` and `row`
    are those of `Placed`. Candidates may jump in intervals of their own.
    """
    nodes, (events, lanes), (q, _) = t.size, times.shape, p.shape
    used, count = np.zeros(nodes, dtype=np.bool_), 1
    for e in range(events):
        for lane in range(lanes):
            if not used[intervals[e, lane]]:
                used[intervals[e, lane]] = True
                count += 2
    along, there = np.zeros(nodes, dtype=np.int64), np.zeros(nodes, dtype=np.int64)
    sets, order, last = np.empty((count, q, lanes)), np.empty(events, dtype=np.int64), 0
    for i in range(q):
        for lane in range(lanes):
            sets[0, i, lane] = p[i, lane]
    for k in range(nodes - 1):
        along[k], there[k] = last, last
        if used[k]:
            along[k] = last + 1
            for i in range(q):
                for lane in range(lanes):
                    sets[last + 1, i, lane] = sets[last, i, lane]
                    sets[last + 2, i, lane] = sets[last, i, lane]
            mixed, last = last + 1, last + 2
            for lane in range(lanes):
                in_order(times, lane, order)
                for now in order:
                    if intervals[now, lane] != k:
                        continue
                    share = (t[k + 1] - times[now, lane]) / (t[k + 1] - t[k])
                    for j in range(event.size):
                        if event[j] == now:
                            off = values[j, lane] - sets[last, row[j], lane]
                            sets[mixed, row[j], lane] += share * off
                            sets[last, row[j], lane] = values[j, lane]
    along[nodes - 1], there[nodes - 1] = last, last
    return sets, along, there


@accelerated
def normal(
    point: Array,
    places: IntArray,
    event: IntArray,
    parameter: IntArray,
    after: IntArray,
    weight: Array,
    mean: Array,
    precision: Array,
) -> tuple[Array, Array]:
    """Return mean (D,) and precision (D, D) of the prior of a point (D,) whose parameters jump.

    `places` (E,) are those of the events' times, mean (d,) and precision (d, d) the prior of the
    unknowns, the others are those of `Placed`. A value after a jump is about the one before.
    """
    d, size = mean.size, point.size
    found, known = np.zeros(size), np.zeros((size, size))
    latest, order = np.empty(d, dtype=np.int64), np.empty(places.size, dtype=np.int64)
    for i in range(d):
        found[i], latest[i] = mean[i], i
        for k in range(d):
            known[i, k] = precision[i, k]
    times = np.empty((places.size, 1))
    for e in range(places.size):
        times[e, 0] = point[places[e]]
        found[places[e]] = times[e, 0]
    in_order(times, 0, order)
    for now in order:
        for j in range(event.size):
            if event[j] == now:
                i, k = latest[parameter[j]], after[j]
                found[k] = found[i]
                known[i, i] += weight[j]
                known[k, k] += weight[j]
                known[i, k] -= weight[j]
                known[k, i] -= weight[j]
                latest[parameter[j]] = k
    return found, known
