# ruff: noqa: F821
# mypy: ignore-errors
"""The compiled kernels of process noise, as a text that `compiled.py` sets below `kernels.py`.

`squares`, `grams` and `trajectories` again, for rollouts that measurements correct. Nothing here
compiles before it is called.
"""


@jit
def move(q, errors, gain, moving, k):
    """Correct the parameters that move by the innovations (N_OUTPUTS, N_LANES) at node k."""
    for m in range(moving.size):
        row = np.uint64(moving[m]) * LANES
        for i in range(N_OUTPUTS):
            factor = gain[k, i, N_STATES + moving[m]]
            for lane in range(LANES):
                q[row + lane] += factor * errors[np.uint64(i) * LANES + lane]


@entry
def squares_injected(
    t, steps, u, slope, y, weight, measured, period, gain, cross, moving, prefixes, candidates, x0,
    p, out,
):  # fmt: skip
    """Sums of squared scaled innovations from prefix to prefix: out (prefixes, outputs, lanes)."""
    x = np.empty(N_STATES * N_LANES)
    q = np.empty(max(1, N_PARAMETERS) * N_LANES)
    errors = np.empty(N_OUTPUTS * N_LANES)
    total = np.empty(N_OUTPUTS * N_LANES)
    for chunk in range(x0.shape[1] // N_LANES):
        count = count_of(candidates, chunk)
        load(x0, chunk, x)
        load(p, chunk, q)
        k = np.int64(0)
        for g in range(prefixes.size):
            total[:] = 0.0
            while k < prefixes[g]:
                if k > 0:
                    advance(x, q, count, t[k - 1], t[k] - t[k - 1], steps[k - 1], u, slope, k - 1)
                if measured[k]:
                    uk = input_at(u, slope, k, 0.0)
                    node = node_at(y, weight, period, gain, cross, k)
                    for lane in range(LANES):
                        xs = gather_x(x, lane)
                        yk = output(t[k], xs, uk, gather_p(q, lane))
                        xs, yk, es = corrected(xs, yk, node)
                        scatter_x(x, lane, xs)
                        scatter_y(errors, lane, es)
                        add_squares(total, lane, yk, y, weight, period, k)
                    move(q, errors, gain, moving, k)
                k += 1
            for i in range(N_OUTPUTS):
                for lane in range(N_LANES):
                    out[g, i, chunk * N_LANES + lane] = total[i * N_LANES + lane]


@entry
def trajectories_injected(
    t, steps, u, slope, y, weight, measured, period, gain, cross, moving, candidates, x0, p,
    states, moved, outputs,
):  # fmt: skip
    """States (K, n, lanes), moving parameters (K, w, lanes) and outputs (K, r, lanes)."""
    x = np.empty(N_STATES * N_LANES)
    q = np.empty(max(1, N_PARAMETERS) * N_LANES)
    errors = np.empty(N_OUTPUTS * N_LANES)
    for chunk in range(x0.shape[1] // N_LANES):
        count = count_of(candidates, chunk)
        load(x0, chunk, x)
        load(p, chunk, q)
        offset = np.uint64(chunk) * LANES
        for k in range(t.size):
            if k > 0:
                advance(x, q, count, t[k - 1], t[k] - t[k - 1], steps[k - 1], u, slope, k - 1)
            uk = input_at(u, slope, k, 0.0)
            node = node_at(y, weight, period, gain, cross, k)
            for lane in range(LANES):
                xs = gather_x(x, lane)
                yk = output(t[k], xs, uk, gather_p(q, lane))
                xs, yk, es = corrected(xs, yk, node)
                scatter_x(x, lane, xs)
                scatter_y(errors, lane, es)
                put_x(states, k, offset + lane, xs)
                put_y(outputs, k, offset + lane, yk)
            move(q, errors, gain, moving, k)
            for m in range(moving.size):
                for lane in range(LANES):
                    moved[k, m, offset + lane] = q[np.uint64(moving[m]) * LANES + lane]


@entry
def grams_injected(
    t, steps, u, slope, y, weight, measured, period, gain, cross, moving, nodes, x0, p, out
):
    """Gram matrices of innovations and their differences: out (starts, 1 + d, 1 + d)."""
    starts, width = out.shape[0], out.shape[1]
    most = chunks_of(min(starts, N_LANES), width)
    x = np.empty((most, N_STATES * N_LANES))
    q = np.empty((most, max(1, N_PARAMETERS) * N_LANES))
    errors = np.empty(N_OUTPUTS * N_LANES)
    block = nodes_of_block(width)
    rows = np.empty((block * N_OUTPUTS, most * N_LANES))
    targets, turns = np.empty(block * N_OUTPUTS), np.empty(block * N_OUTPUTS)
    columns = np.zeros((width + MORE_COLUMNS, block * N_OUTPUTS))
    out[:] = 0.0
    for begin in range(0, starts, N_LANES):
        end = min(begin + N_LANES, starts)
        chunks = chunks_of(end - begin, width)
        for chunk in range(chunks):
            load(x0, chunk + begin * width // N_LANES, x[chunk])
            load(p, chunk + begin * width // N_LANES, q[chunk])
        first = 0
        while first < nodes:
            last = min(first + block, nodes)
            n_rows = aim(y, weight, measured, period, first, last, targets, turns)
            for chunk in range(chunks):
                xc = x[chunk]
                qc = q[chunk]
                offset, count = np.uint64(chunk) * LANES, count_of((end - begin) * width, chunk)
                row = 0
                for k in range(first, last):
                    if k > 0:
                        h = t[k] - t[k - 1]
                        advance(xc, qc, count, t[k - 1], h, steps[k - 1], u, slope, k - 1)
                    if measured[k]:
                        uk = input_at(u, slope, k, 0.0)
                        node = node_at(y, weight, period, gain, cross, k)
                        for lane in range(LANES):
                            xs = gather_x(xc, lane)
                            yk = output(t[k], xs, uk, gather_p(qc, lane))
                            xs, yk, es = corrected(xs, yk, node)
                            scatter_x(xc, lane, xs)
                            scatter_y(errors, lane, es)
                            put_rows(rows, row, offset + lane, yk, weight, k)
                        move(qc, errors, gain, moving, k)
                        row += N_OUTPUTS
            for s in range(begin, end):
                lane = (s - begin) * width
                add_gram(out[s], rows, targets, turns, n_rows, lane, width, columns)
            first = last
