# ruff: noqa: F821
# mypy: ignore-errors
"""The compiled linearly implicit step of models with a large Jacobian, as a text; see `kernels.py`.

Here all lanes go through each part of a step together, so that loops over rows and columns have
the lanes innermost. It stands in the place of `advance` and `advance_late` for these models.
Short loops over lanes count them by an array: of constant length they would be unrolled before the
compiler vectorises.
"""


@jit
def advance(x, p, t, dt, steps, u, slope, k):
    """Propagate the candidates in x over the interval from node k to the next."""
    h = dt / steps
    first, last = np.empty(max(1, N_INPUTS) * N_LANES), np.empty(max(1, N_INPUTS) * N_LANES)
    work = workspace()
    for j in range(steps):
        s = j * h
        u0, u2 = input_at(u, slope, k, s), input_at(u, slope, k, s + h)
        for lane in range(LANES):
            scatter_u(first, lane, u0)
            scatter_u(last, lane, u2)
        step_lanes(x, p, t + s, h, first, last, work)


@jit
def advance_late(x, p, t, dt, steps, u, slope, f, begin):
    """Propagate the candidates in x over step f; each has inputs of its own."""
    h = dt / steps
    first, last = np.empty(max(1, N_INPUTS) * N_LANES), np.empty(max(1, N_INPUTS) * N_LANES)
    work = workspace()
    for j in range(steps):
        s = j * h
        for lane in range(LANES):
            scatter_u(first, lane, late_input(u, slope, f, begin + lane, s))
            scatter_u(last, lane, late_input(u, slope, f, begin + lane, s + h))
        step_lanes(x, p, t + s, h, first, last, work)


@jit
def workspace():
    """Return arrays: the matrix, one of its rows and one entry, three stages, and states."""
    n = N_STATES * N_LANES
    row, low = np.empty(n), np.empty(N_LANES)
    return np.empty(N_STATES * n), row, low, np.empty(n), np.empty(n), np.empty(n), np.empty(n)


@jit
def step_lanes(x, p, t, h, u0, u2, work):
    """Advance all lanes by h seconds; `steps.rosenbrock` has the method."""
    W, row, low, k1, k2, k3, y = work
    inverse = 1.0 / h
    for lane in range(LANES):
        a, b = gather_u(u0, lane), gather_u(u2, lane)
        slope = slopes(a, b, inverse)
        found = linearised(t, h, gather_x(x, lane), a, slope, gather_p(p, lane))
        put_matrix(W, lane, found, 2.0 * inverse)
        scatter_x(k1, lane, first_stage(found, 0.5 * h))
        scatter_x(k2, lane, first_stage(found, 1.5 * h))
    factor(W, row, low)
    solve(W, k1, low)
    add(k2, 4.0 * inverse, k1, k2)
    solve(W, k2, low)
    add(x, 2.0, k1, y)
    for lane in range(LANES):
        f = dynamics(t + h, gather_x(y, lane), gather_u(u2, lane), gather_p(p, lane))
        scatter_x(k3, lane, third_stage(f, inverse, gather_x(k1, lane), gather_x(k2, lane)))
    solve(W, k3, low)
    add(y, 1.0, k3, y)
    for lane in range(LANES):
        f = dynamics(t + h, gather_x(y, lane), gather_u(u2, lane), gather_p(p, lane))
        a, b, c = gather_x(k1, lane), gather_x(k2, lane), gather_x(k3, lane)
        scatter_x(k3, lane, fourth_stage(f, inverse, a, b, c))
    solve(W, k3, low)
    add(y, 1.0, k3, x)


@jit
def add(x, a, k, out):
    """Write x + a k."""
    for i in range(x.size):
        out[i] = x[i] + a * k[i]


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
