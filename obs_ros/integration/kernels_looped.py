# ruff: noqa: F821
# mypy: ignore-errors
"""The compiled linearly implicit step of models with a large Jacobian, as a text; see `kernels.py`.

Here all lanes go through each part of a step together, so that loops over rows and columns have
the lanes innermost. It stands in the place of `advance` and `advance_late` for these models.
Loops over lanes count them by an array: of constant length short ones would be unrolled before the
compiler vectorises.
"""


@jit
def advance(x, p, count, t, dt, steps, u, slope, k):
    """Propagate the first `count` candidates in x over the interval from node k to the next."""
    h = dt / steps
    first, last = np.empty(max(1, N_INPUTS) * N_LANES), np.empty(max(1, N_INPUTS) * N_LANES)
    lanes = (count + REST) & WHOLE
    now, every, work = np.empty(lanes), np.empty(lanes), workspace(lanes)
    every[:] = h
    for j in range(steps):
        s = j * h
        u0, u2 = input_at(u, slope, k, s), input_at(u, slope, k, s + h)
        now[:] = t + s
        for lane in range(LANES):
            scatter_u(first, lane, u0)
            scatter_u(last, lane, u2)
        step_lanes(x, p, now, every, first, last, work)


@jit
def advance_late(x, p, start, t, steps, u, slope, f, begin):
    """Propagate the candidates in x over step f; each has times and inputs of its own."""
    first, last = np.empty(max(1, N_INPUTS) * N_LANES), np.empty(max(1, N_INPUTS) * N_LANES)
    now, every, work = np.empty(N_LANES), np.empty(N_LANES), workspace(LANES)
    for j in range(steps):
        for lane in range(LANES):
            place = begin + lane
            h = (t[f + 1, place] - t[f, place]) / steps
            s = j * h
            every[lane] = h
            now[lane] = start + t[f, place] + s
            scatter_u(first, lane, late_input(u, slope, f, place, s))
            scatter_u(last, lane, late_input(u, slope, f, place, s + h))
        step_lanes(x, p, now, every, first, last, work)


@jit
def workspace(lanes):
    """Return arrays of the first lanes: the matrix, a row, two entries, three stages, states."""
    n = N_STATES * N_LANES
    row, low, scale = np.empty(n), np.empty(lanes), np.empty(lanes)
    k1, k2, k3, between = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    return np.empty(N_STATES * n), row, low, scale, k1, k2, k3, between


@jit
def step_lanes(x, p, t, h, u0, u2, work):
    """Advance all lanes, each from its t (lanes,) by its h s; `steps.estimated` has the method."""
    try_lanes(x, p, t, h, u0, u2, x, work[6], work)


@jit
def try_lanes(x, p, t, h, u0, u2, out, k3, work):
    """Advance lanes from x to `out`, with the local errors k3 (n, lanes) of the last stage.

    They are as many as there is work space for.
    """
    W, row, low, scale, k1, k2, _, y = work
    lanes = np.uint64(low.size) & WHOLE
    for lane in range(lanes):
        inverse, step = 1.0 / h[lane], h[lane]
        a, b = gather_u(u0, lane), gather_u(u2, lane)
        slope = slopes(a, b, inverse)
        found = linearised(t[lane], step, gather_x(x, lane), a, slope, gather_p(p, lane))
        put_matrix(W, lane, found, 2.0 * inverse)
        scatter_x(k1, lane, first_stage(found, 0.5 * step))
        scatter_x(k2, lane, first_stage(found, 1.5 * step))
    factor(W, row, low)
    solve(W, k1, low)
    for lane in range(lanes):
        scale[lane] = 4.0 / h[lane]
    add(k2, scale, k1, k2)
    solve(W, k2, low)
    scale[:] = 2.0
    add(x, scale, k1, y)
    for lane in range(lanes):
        f = dynamics(t[lane] + h[lane], gather_x(y, lane), gather_u(u2, lane), gather_p(p, lane))
        inverse = 1.0 / h[lane]
        scatter_x(k3, lane, third_stage(f, inverse, gather_x(k1, lane), gather_x(k2, lane)))
    solve(W, k3, low)
    scale[:] = 1.0
    add(y, scale, k3, y)
    for lane in range(lanes):
        f = dynamics(t[lane] + h[lane], gather_x(y, lane), gather_u(u2, lane), gather_p(p, lane))
        a, b, c = gather_x(k1, lane), gather_x(k2, lane), gather_x(k3, lane)
        scatter_x(k3, lane, fourth_stage(f, 1.0 / h[lane], a, b, c))
    solve(W, k3, low)
    add(y, scale, k3, out)


@jit
def add(x, a, k, out):
    """Write x + a k, with a (lanes,)."""
    count = np.uint64(a.size)
    for i in range(N_STATES):
        row = np.uint64(i) * LANES
        for lane in range(count):
            out[row + lane] = x[row + lane] + a[lane] * k[row + lane]


@jit
def factor(W, row, low):
    """Factorise W (n, n, lanes), flat, in place; the diagonal gets reciprocals.

    row (n, lanes) and low (lanes,) hold what is read again and again, apart from what is written.
    """
    count = np.uint64(low.size)
    for k in range(N_STATES):
        pivot = np.uint64(k * (N_STATES + 1)) * LANES
        for lane in range(count):
            W[pivot + lane] = 1.0 / W[pivot + lane]
        for j in range(k + 1, N_STATES):
            above, to = np.uint64(k * N_STATES + j) * LANES, np.uint64(j) * LANES
            for lane in range(count):
                row[to + lane] = W[above + lane]
        for i in range(k + 1, N_STATES):
            below = np.uint64(i * N_STATES + k) * LANES
            for lane in range(count):
                low[lane] = W[below + lane] * W[pivot + lane]
            for lane in range(count):
                W[below + lane] = low[lane]
            for j in range(k + 1, N_STATES):
                here, above = np.uint64(i * N_STATES + j) * LANES, np.uint64(j) * LANES
                for lane in range(count):
                    W[here + lane] -= low[lane] * row[above + lane]


@jit
def solve(W, k, low):
    """Solve by the factors in W, in place; low (lanes,) holds a sum."""
    count = np.uint64(low.size)
    for i in range(N_STATES):
        subtract(W, k, low, i, 0, i)
        row = np.uint64(i) * LANES
        for lane in range(count):
            k[row + lane] = low[lane]
    for i in range(N_STATES - 1, -1, -1):
        subtract(W, k, low, i, i + 1, N_STATES)
        row, pivot = np.uint64(i) * LANES, np.uint64(i * (N_STATES + 1)) * LANES
        for lane in range(count):
            k[row + lane] = low[lane] * W[pivot + lane]


@jit
def subtract(W, k, low, i, begin, end):
    """Write entry i of k less the products of row i of W with k between two columns."""
    count = np.uint64(low.size)
    row = np.uint64(i) * LANES
    for lane in range(count):
        low[lane] = k[row + lane]
    for j in range(begin, end):
        here, other = np.uint64(i * N_STATES + j) * LANES, np.uint64(j) * LANES
        for lane in range(count):
            low[lane] -= W[here + lane] * k[other + lane]
