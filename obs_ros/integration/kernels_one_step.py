# ruff: noqa: F821
# mypy: ignore-errors
"""The compiled kernel of one-step sensitivities, as a text appended to `kernels.py`."""


@jit
def in_lanes(states, k, moved, first, last, x):
    """Put the state of node k in all lanes, moved in those of the entries from first to last."""
    for i in range(N_STATES):
        for lane in range(LANES):
            x[np.uint64(i) * LANES + lane] = states[k, i]
        if first <= i < last:
            x[i * N_LANES + 1 + i - first] += moved[i]


@entry
def one_step(
    t,
    steps,
    u,
    slope,
    y,
    period,
    along,
    there,
    states,
    begins,
    moved,
    sets,
    transition,
    sensitivity,
):
    """Differences by moved states and parameters over each interval, and of the outputs.

    They are about states (K, n) for the outputs, and those with which intervals begin (K, n), one
    of which moved (n,) at a time; of the sets of parameters (S,
    q, lanes) the one along[k] holds in an interval, there[k] at a node. Each chunk begins with the
    candidate that is not moved. See `Kernels.one_step`.
    """
    x = np.empty(N_STATES * N_LANES)
    q = np.empty(max(1, N_PARAMETERS) * N_LANES)
    shows = np.empty((N_OUTPUTS, N_LANES))
    own = N_LANES - 1  # moved candidates of a chunk
    for chunk in range(sets.shape[2] // N_LANES):
        first = chunk * own
        last = min(first + own, transition.shape[2])
        count = np.uint64(1 + last - first)
        for k in range(t.size):
            in_lanes(states, k, moved, first, last, x)
            load(sets[there[k]], chunk, q)
            uk = input_at(u, slope, k, 0.0)
            for lane in range(LANES):
                yk = output(t[k], gather_x(x, lane), uk, gather_p(q, lane))
                put_outputs(shows, lane, shown(yk, y, k))
            for i in range(N_OUTPUTS):
                for j in range(first, last):
                    off = shows[i, 1 + j - first] - shows[i, 0]
                    sensitivity[k, i, j] = shortest(off, period[i])
            if k < t.size - 1:
                in_lanes(begins, k, moved, first, last, x)
                load(sets[along[k]], chunk, q)
                advance(x, q, count, t[k], t[k + 1] - t[k], steps[k], u, slope, k)
                for i in range(N_STATES):
                    for j in range(first, last):
                        transition[k, i, j] = x[i * N_LANES + 1 + j - first] - x[i * N_LANES]
