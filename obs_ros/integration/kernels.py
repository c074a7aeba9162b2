# ruff: noqa: F821
# mypy: ignore-errors
"""The compiled kernels, as a text.

`compiled.py` writes it, after a header of the model's own, to a file in the user's cache folder and
imports that. The header binds `dynamics`, `output`, the decorators, and tuple functions unrolled
for the model's dimensions. Candidates lie in lanes: arrays are flat (variable, lane), and the lane
loop is innermost, of constant length and unsigned, which is what makes it vectorise. A candidate
that turns NaN stays NaN and disturbs no other lane.
"""


@jit
def step_rk4(t, h, x, u0, u1, u2, p):
    """Advance one candidate by h seconds; u0, u1, u2 are the inputs at begin, middle and end."""
    k1 = dynamics(t, x, u0, p)
    k2 = dynamics(t + 0.5 * h, axpy(x, 0.5 * h, k1), u1, p)
    k3 = dynamics(t + 0.5 * h, axpy(x, 0.5 * h, k2), u1, p)
    k4 = dynamics(t + h, axpy(x, h, k3), u2, p)
    return rk4_sum(x, h / 6.0, k1, k2, k3, k4)


@jit
def step_euler(t, h, x, u0, u1, u2, p):
    """Advance one candidate by h seconds."""
    return axpy(x, h, dynamics(t, x, u0, p))


@jit
def step_discrete(t, h, x, u0, u1, u2, p):
    """Return the next state of one candidate of a discrete model."""
    return dynamics(t, x, u0, p)


@jit
def advance(x, p, count, t, dt, steps, u, slope, k):
    """Propagate the first `count` candidates in x over the interval from node k to the next.

    They are counted in whole registers: a compiler that knows makes no loop for the rest.
    """
    h = dt / steps
    for j in range(steps):
        s = j * h
        u0 = input_at(u, slope, k, s)
        u1 = input_at(u, slope, k, s + 0.5 * h)
        u2 = input_at(u, slope, k, s + h)
        for lane in range((count + REST) & WHOLE):
            scatter_x(x, lane, step(t + s, h, gather_x(x, lane), u0, u1, u2, gather_p(p, lane)))


@jit
def count_of(candidates, chunk):
    """Return how many of the candidates are in this chunk; others fill up its lanes."""
    return np.uint64(min(N_LANES, candidates - chunk * N_LANES))


@jit
def load(source, chunk, x):
    """Copy the lanes of one chunk out of source (rows, lanes).

    Rows are counted by the array: for each constant number it would be compiled anew.
    """
    for i in range(source.shape[0]):
        for lane in range(LANES):
            x[np.uint64(i) * LANES + lane] = source[i, np.uint64(chunk) * LANES + lane]


@entry
def squares(t, steps, u, slope, y, weight, measured, period, prefixes, candidates, x0, p, out):
    """Sums of squared scaled residuals from prefix to prefix: out (prefixes, outputs, lanes)."""
    x = np.empty(N_STATES * N_LANES)
    q = np.empty(max(1, N_PARAMETERS) * N_LANES)
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
                    for lane in range(LANES):
                        yk = output(t[k], gather_x(x, lane), uk, gather_p(q, lane))
                        yk = shown(yk, y, k)
                        add_squares(total, lane, yk, y, weight, period, k)
                k += 1
            for i in range(N_OUTPUTS):
                for lane in range(N_LANES):
                    out[g, i, chunk * N_LANES + lane] = total[i * N_LANES + lane]


@entry
def trajectories(t, steps, u, slope, candidates, x0, sets, along, there, states, outputs):
    """States (K, n, lanes) and outputs (K, r, lanes) at every node.

    Of the sets of parameters (S, q, lanes) the one along[k] holds between two nodes, that there[k]
    at a node.
    """
    x = np.empty(N_STATES * N_LANES)
    q = np.empty(max(1, N_PARAMETERS) * N_LANES)
    for chunk in range(x0.shape[1] // N_LANES):
        count = count_of(candidates, chunk)
        load(x0, chunk, x)
        number = there[0]
        load(sets[number], chunk, q)
        for k in range(t.size):
            if k > 0:
                if along[k - 1] != number:
                    number = along[k - 1]
                    load(sets[number], chunk, q)
                advance(x, q, count, t[k - 1], t[k] - t[k - 1], steps[k - 1], u, slope, k - 1)
            if there[k] != number:
                number = there[k]
                load(sets[number], chunk, q)
            uk = input_at(u, slope, k, 0.0)
            for lane in range(LANES):
                xs = gather_x(x, lane)
                put_x(states, k, np.uint64(chunk) * LANES + lane, xs)
                yk = output(t[k], xs, uk, gather_p(q, lane))
                put_y(outputs, k, np.uint64(chunk) * LANES + lane, yk)


@entry
def restarted(t, steps, u, slope, candidates, states, p, ends):
    """States (K - 1, n, lanes) where intervals end that begin at states (K, n, lanes)."""
    x = np.empty(N_STATES * N_LANES)
    q = np.empty(max(1, N_PARAMETERS) * N_LANES)
    for chunk in range(states.shape[2] // N_LANES):
        count = count_of(candidates, chunk)
        load(p, chunk, q)
        for k in range(t.size - 1):
            load(states[k], chunk, x)
            advance(x, q, count, t[k], t[k + 1] - t[k], steps[k], u, slope, k)
            for lane in range(LANES):
                put_x(ends, k, np.uint64(chunk) * LANES + lane, gather_x(x, lane))


@entry
def propagate(t, dt, steps, u, slope, pieces, x0, p):
    """Propagate candidates x0 (n, lanes), in place, over the first `pieces` pieces of a path."""
    x = np.empty(N_STATES * N_LANES)
    q = np.empty(max(1, N_PARAMETERS) * N_LANES)
    for chunk in range(x0.shape[1] // N_LANES):
        load(x0, chunk, x)
        load(p, chunk, q)
        for k in range(pieces):
            advance(x, q, LANES, t[k], dt[k], steps[k], u, slope, k)
        for lane in range(LANES):
            put_lane(x0, np.uint64(chunk) * LANES + lane, gather_x(x, lane))


@entry
def measure(t, u, x0, p, y):
    """Outputs y (r, lanes) of the candidates x0 at time t, under the inputs u (m,)."""
    x = np.empty(N_STATES * N_LANES)
    q = np.empty(max(1, N_PARAMETERS) * N_LANES)
    for chunk in range(x0.shape[1] // N_LANES):
        load(x0, chunk, x)
        load(p, chunk, q)
        for lane in range(LANES):
            yhat = output(t, gather_x(x, lane), inputs(u), gather_p(q, lane))
            put_outputs(y, np.uint64(chunk) * LANES + lane, yhat)


@entry
def pursue(t, dt, u, y, known, weight, measured, lower, upper, x0, p, squares, ends):
    """Series-parallel Euler steps of candidates p (q, lanes), all from x0 (n,), along a window.

    Writes the squared scaled errors (lanes,) before each replacement, and the states (n, lanes) at
    the end. See `SeriesParallel`.
    """
    x = np.empty(N_STATES * N_LANES)
    q = np.empty(max(1, N_PARAMETERS) * N_LANES)
    total = np.empty(N_LANES)
    for chunk in range(squares.size // N_LANES):
        # As many as there are lanes: of that number the compiler would make single steps.
        count = count_of(squares.size, chunk)
        load(p, chunk, q)
        for i in range(N_STATES):
            for lane in range(N_LANES):
                x[i * N_LANES + lane] = x0[i]
        total[:] = 0.0
        for k in range(dt.size):
            for i in range(N_OUTPUTS):
                if k > 0 and known[k, i]:
                    row, value = np.uint64(measured[i]) * LANES, y[k, i]
                    for lane in range((count + REST) & WHOLE):
                        x[row + lane] = value
            uk = inputs_at(u, k)
            for lane in range(LANES):
                xs = gather_x(x, lane)
                rates = dynamics(t[k], xs, uk, gather_p(q, lane))
                scatter_x(x, lane, clipped(axpy(xs, dt[k], rates), lower, upper))
            for i in range(N_OUTPUTS):
                if known[k + 1, i]:
                    row, value, scale = np.uint64(measured[i]) * LANES, y[k + 1, i], weight[i]
                    for lane in range((count + REST) & WHOLE):
                        error = scale * (value - x[row + lane])
                        total[lane] += error * error
        for lane in range(LANES):
            squares[np.uint64(chunk) * LANES + lane] = total[lane]
            put_lane(ends, np.uint64(chunk) * LANES + lane, gather_x(x, lane))
