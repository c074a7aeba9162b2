# ruff: noqa: F821
# mypy: ignore-errors
"""The compiled kernels of process noise, as a text that `compiled.py` sets below `kernels.py`.

`squares`, `grams` and `trajectories` again, for rollouts that measurements correct, and the pass of
the extended Kalman filter. Nothing here compiles before it is called.
"""


@jit
def observe(x, q, t, u, yhat):
    """Write the outputs (N_OUTPUTS, N_LANES) of the candidates in the lanes."""
    for lane in range(LANES):
        scatter_y(yhat, lane, output(t, gather_x(x, lane), u, gather_p(q, lane)))


@jit
def correct(x, q, yhat, errors, y, weight, gain, cross, moving, k):
    """Correct the candidates by the outputs at node k, one after the other; see `Injection`."""
    for i in range(N_OUTPUTS):
        if weight[k, i] != 0.0:
            row = np.uint64(i) * LANES
            for j in range(i):
                if weight[k, j] != 0.0:
                    for lane in range(LANES):
                        yhat[row + lane] += cross[k, i, j] * errors[np.uint64(j) * LANES + lane]
            for lane in range(LANES):
                errors[row + lane] = y[k, i] - yhat[row + lane]
            for s in range(N_STATES):
                for lane in range(LANES):
                    x[np.uint64(s) * LANES + lane] += gain[k, i, s] * errors[row + lane]
            for m in range(moving.size):
                to, factor = np.uint64(moving[m]) * LANES, gain[k, i, N_STATES + moving[m]]
                for lane in range(LANES):
                    q[to + lane] += factor * errors[row + lane]


@entry
def squares_injected(
    t, steps, u, slope, y, weight, measured, gain, cross, moving, prefixes, x0, p, out
):
    """Sums of squared scaled innovations from prefix to prefix: out (prefixes, outputs, lanes)."""
    x = np.empty(N_STATES * N_LANES)
    q = np.empty(max(1, N_PARAMETERS) * N_LANES)
    yhat, errors = np.empty(N_OUTPUTS * N_LANES), np.empty(N_OUTPUTS * N_LANES)
    total = np.empty(N_OUTPUTS * N_LANES)
    for chunk in range(x0.shape[1] // N_LANES):
        load(x0, chunk, N_STATES, x)
        load(p, chunk, N_PARAMETERS, q)
        k = 0
        for g in range(prefixes.size):
            total[:] = 0.0
            while k < prefixes[g]:
                if k > 0:
                    advance(x, q, t[k - 1], t[k] - t[k - 1], steps[k - 1], u, slope, k - 1)
                if measured[k]:
                    observe(x, q, t[k], input_at(u, slope, k, 0.0), yhat)
                    correct(x, q, yhat, errors, y, weight, gain, cross, moving, k)
                    for i in range(N_OUTPUTS):
                        row = np.uint64(i) * LANES
                        for lane in range(LANES):
                            residual = weight[k, i] * (yhat[row + lane] - y[k, i])
                            total[row + lane] += residual**2
                k += 1
            for i in range(N_OUTPUTS):
                for lane in range(N_LANES):
                    out[g, i, chunk * N_LANES + lane] = total[i * N_LANES + lane]


@entry
def trajectories_injected(
    t, steps, u, slope, y, weight, measured, gain, cross, moving, x0, p, states, moved, outputs
):
    """States (K, n, lanes), moving parameters (K, w, lanes) and outputs (K, r, lanes)."""
    x = np.empty(N_STATES * N_LANES)
    q = np.empty(max(1, N_PARAMETERS) * N_LANES)
    yhat, errors = np.empty(N_OUTPUTS * N_LANES), np.empty(N_OUTPUTS * N_LANES)
    for chunk in range(x0.shape[1] // N_LANES):
        load(x0, chunk, N_STATES, x)
        load(p, chunk, N_PARAMETERS, q)
        offset = np.uint64(chunk) * LANES
        for k in range(t.size):
            if k > 0:
                advance(x, q, t[k - 1], t[k] - t[k - 1], steps[k - 1], u, slope, k - 1)
            observe(x, q, t[k], input_at(u, slope, k, 0.0), yhat)
            if measured[k]:
                correct(x, q, yhat, errors, y, weight, gain, cross, moving, k)
            for s in range(N_STATES):
                for lane in range(LANES):
                    states[k, s, offset + lane] = x[np.uint64(s) * LANES + lane]
            for m in range(moving.size):
                for lane in range(LANES):
                    moved[k, m, offset + lane] = q[np.uint64(moving[m]) * LANES + lane]
            for i in range(N_OUTPUTS):
                for lane in range(LANES):
                    outputs[k, i, offset + lane] = yhat[np.uint64(i) * LANES + lane]


@entry
def grams_injected(t, steps, u, slope, y, weight, measured, gain, cross, moving, nodes, x0, p, out):
    """Gram matrices of innovations and their differences: out (starts, 1 + d, 1 + d)."""
    lanes = x0.shape[1]
    chunks = lanes // N_LANES
    starts, width = out.shape[0], out.shape[1]
    x = np.empty((chunks, N_STATES * N_LANES))
    q = np.empty((chunks, max(1, N_PARAMETERS) * N_LANES))
    yhat, errors = np.empty(N_OUTPUTS * N_LANES), np.empty(N_OUTPUTS * N_LANES)
    for chunk in range(chunks):
        load(x0, chunk, N_STATES, x[chunk])
        load(p, chunk, N_PARAMETERS, q[chunk])
    block = max(1, BLOCK_VALUES // (lanes * N_OUTPUTS))
    rows = np.empty((block * N_OUTPUTS, lanes))
    targets = np.empty(block * N_OUTPUTS)
    columns = np.empty((width, block * N_OUTPUTS))
    out[:] = 0.0
    first = 0
    while first < nodes:
        last = min(first + block, nodes)
        n_rows = 0
        for k in range(first, last):
            if measured[k]:
                for i in range(N_OUTPUTS):
                    targets[n_rows + i] = y[k, i] * weight[k, i]
                n_rows += N_OUTPUTS
        for chunk in range(chunks):
            xc = x[chunk]
            qc = q[chunk]
            offset = np.uint64(chunk) * LANES
            row = 0
            for k in range(first, last):
                if k > 0:
                    advance(xc, qc, t[k - 1], t[k] - t[k - 1], steps[k - 1], u, slope, k - 1)
                if measured[k]:
                    observe(xc, qc, t[k], input_at(u, slope, k, 0.0), yhat)
                    correct(xc, qc, yhat, errors, y, weight, gain, cross, moving, k)
                    for i in range(N_OUTPUTS):
                        for lane in range(LANES):
                            rows[row + i, offset + lane] = (
                                yhat[np.uint64(i) * LANES + lane] * weight[k, i]
                            )
                    row += N_OUTPUTS
        for s in range(starts):
            add_gram(out[s], rows, targets, n_rows, s * width, width, columns)
        first = last
