# ruff: noqa: F821
# mypy: ignore-errors
"""The compiled kernels of candidates that take steps of their own, as a text; see `own_steps.py`.

All lanes of a chunk try a step at once, each from its own time; those that have arrived stand still
beside the others. Where each was at the nodes is kept, and its outputs are computed from that.
"""


@jit
def load_lane(sets, number, chunk, lane, p):
    """Copy the parameters of one lane of a chunk out of one of the sets (S, q, lanes)."""
    for i in range(N_PARAMETERS):
        p[i * N_LANES + lane] = sets[number, i, chunk * N_LANES + lane]


@jit
def follow(
    x, p, sets, along, chunk, t, fresh, u, slope, last, lead, limits, work, track, counts
):  # fmt: skip
    """Follow the candidates in x from node 0 to `last`; write track (K, n, lanes) and counts.

    Of the sets of parameters (S, q, lanes) the one along[k] (K,) holds in interval k; in p they are
    those of where each candidate is.
    """
    load(sets[along[0]], chunk, p)
    tolerance, floor, longest, budget = limits
    y, e, now, step, h, left, error, u0, u2, node, taken, new, stages = work
    track[:] = np.nan
    for lane in range(N_LANES):
        store(track, 0, lane, x)
        node[lane], taken[lane], new[lane] = 0, 0, fresh[0]
        h[lane], left[lane] = t[t.size - 1] - t[0], t[1] - t[0]
    going = N_LANES if last > 0 else 0
    while going > 0:
        starting = False
        for lane in range(N_LANES):
            k = min(node[lane], last - 1)
            s = t[k + 1] - t[k] - left[lane]
            now[lane] = t[k] + s
            scatter_u(u0, lane, input_at(u, slope, k, s))
            starting |= new[lane] and node[lane] < last
        if starting:
            for lane in range(LANES):
                xs = gather_x(x, lane)
                rates = dynamics(now[lane], xs, gather_u(u0, lane), gather_p(p, lane))
                error[lane] = FIRST / max(speed_of(rates, xs, floor), TINY)
            for lane in range(N_LANES):
                if new[lane] and node[lane] < last:
                    h[lane], new[lane] = min(h[lane], error[lead[lane]]), False
        for lane in range(N_LANES):
            k, rest = min(node[lane], last - 1), left[lane]
            one = min(h[lane], longest)
            one = rest if rest <= 1.01 * one else (0.5 * rest if rest < 2.0 * one else one)
            step[lane] = one if node[lane] < last else 1.0
            scatter_u(u2, lane, input_at(u, slope, k, t[k + 1] - t[k] - rest + step[lane]))
        try_lanes(x, p, now, step, u0, u2, y, e, stages)
        for lane in range(LANES):
            size = size_of(gather_x(e, lane), gather_x(x, lane), gather_x(y, lane), floor)
            error[lane] = size / tolerance
        for lane in range(N_LANES):
            k = node[lane]
            if k >= last:
                continue
            taken[lane] += 1
            counts[k, lane] += 1
            excess, lost = error[lead[lane]], False
            root = np.sqrt(max(excess, LOW))
            if excess <= 1.0:
                longer = step[lane] * min(LONGER, SAFETY / np.sqrt(root))
                h[lane] = max(longer, h[lane]) if step[lane] < h[lane] else longer
                left[lane] -= step[lane]
                copy_x(x, y, lane)
                if not left[lane] > 0.0:
                    store(track, k + 1, lane, x)
                    node[lane] = k + 1
                    if k + 1 < last:
                        left[lane], new[lane] = t[k + 2] - t[k + 1], fresh[k + 1]
                        if along[k + 1] != along[k]:
                            load_lane(sets, along[k + 1], chunk, lane, p)
                            new[lane] = True
                else:
                    lost = taken[lane] >= budget
            else:
                h[lane] = step[lane] * (max(SHORTER, SAFETY / root) if excess < inf else SHORTER)
                lost = taken[lane] >= budget or not h[lane] > STALLED * (t[k + 1] - t[k])
            if lost:
                node[lane] = last
            going -= node[lane] >= last


@jit
def working():
    """Return arrays for `follow`."""
    n, m = N_STATES * N_LANES, max(1, N_INPUTS) * N_LANES
    numbers = np.empty(N_LANES), np.empty(N_LANES), np.empty(N_LANES), np.ones(N_LANES)
    places = np.empty(N_LANES, np.int64), np.empty(N_LANES, np.int64), np.empty(N_LANES, np.bool_)
    error, stages = np.empty(N_LANES), workspace(LANES)
    return np.empty(n), np.empty(n), *numbers, error, np.empty(m), np.empty(m), *places, stages


@entry
def squares_own(
    t, fresh, u, slope, y, weight, measured, period, prefixes, x0, sets, along, lead, tolerance,
    floor, longest, budget, out,
):  # fmt: skip
    """As `squares`, over the candidates' own steps."""
    x = np.empty(N_STATES * N_LANES)
    q = np.empty(max(1, N_PARAMETERS) * N_LANES)
    total = np.empty(N_OUTPUTS * N_LANES)
    work, limits = working(), (tolerance, floor, longest, budget)
    nodes = prefixes[prefixes.size - 1]
    track = np.empty((nodes, N_STATES, N_LANES))
    counts = np.zeros((nodes, N_LANES), np.int64)
    for chunk in range(x0.shape[1] // N_LANES):
        load(x0, chunk, x)
        follow(
            x, q, sets, along, chunk, t, fresh, u, slope, nodes - 1, lead[chunk], limits, work,
            track, counts,
        )  # fmt: skip
        k = 0
        for g in range(prefixes.size):
            total[:] = 0.0
            while k < prefixes[g]:
                if measured[k]:
                    load(track[k], np.int64(0), x)
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
def trajectories_own(
    t, fresh, u, slope, x0, sets, along, there, lead, tolerance, floor, longest, budget, states,
    outputs, counts,
):  # fmt: skip
    """As `trajectories`, over the candidates' own steps; counts (K - 1, lanes) are these."""
    x = np.empty(N_STATES * N_LANES)
    q = np.empty(max(1, N_PARAMETERS) * N_LANES)
    work, limits = working(), (tolerance, floor, longest, budget)
    track = np.empty((t.size, N_STATES, N_LANES))
    taken = np.empty((t.size, N_LANES), np.int64)
    for chunk in range(x0.shape[1] // N_LANES):
        load(x0, chunk, x)
        taken[:] = 0
        follow(
            x, q, sets, along, chunk, t, fresh, u, slope, t.size - 1, lead[chunk], limits, work,
            track, taken,
        )  # fmt: skip
        number = there[0]
        load(sets[number], chunk, q)
        for k in range(t.size):
            load(track[k], np.int64(0), x)
            if there[k] != number:
                number = there[k]
                load(sets[number], chunk, q)
            uk = input_at(u, slope, k, 0.0)
            for lane in range(LANES):
                xs = gather_x(x, lane)
                put_x(states, k, np.uint64(chunk) * LANES + lane, xs)
                yk = output(t[k], xs, uk, gather_p(q, lane))
                put_y(outputs, k, np.uint64(chunk) * LANES + lane, yk)
            if k > 0:
                for lane in range(N_LANES):
                    counts[k - 1, chunk * N_LANES + lane] = taken[k - 1, lane]


@entry
def grams_own(
    t, fresh, u, slope, y, weight, measured, period, nodes, x0, sets, along, lead, place,
    tolerance, floor, longest, budget, out,
):  # fmt: skip
    """As `grams`, over the own steps of each start's base point; place (B,) are its lanes."""
    starts, width = out.shape[0], out.shape[1]
    x = np.empty(N_STATES * N_LANES)
    q = np.empty(max(1, N_PARAMETERS) * N_LANES)
    work, limits = working(), (tolerance, floor, longest, budget)
    track = np.empty((nodes, N_STATES, N_LANES))
    counts = np.zeros((nodes, N_LANES), np.int64)
    rows = np.empty((nodes * N_OUTPUTS, x0.shape[1]))
    targets, turns = np.empty(nodes * N_OUTPUTS), np.empty(nodes * N_OUTPUTS)
    n_rows = aim(y, weight, measured, period, np.int64(0), nodes, targets, turns)
    for chunk in range(x0.shape[1] // N_LANES):
        load(x0, chunk, x)
        follow(
            x, q, sets, along, chunk, t, fresh, u, slope, nodes - 1, lead[chunk], limits, work,
            track, counts,
        )  # fmt: skip
        row = 0
        for k in range(nodes):
            if measured[k]:
                load(track[k], np.int64(0), x)
                uk = input_at(u, slope, k, 0.0)
                for lane in range(LANES):
                    yk = output(t[k], gather_x(x, lane), uk, gather_p(q, lane))
                    yk = shown(yk, y, k)
                    put_rows(rows, row, np.uint64(chunk) * LANES + lane, yk, weight, k)
                row += N_OUTPUTS
    own, columns = np.empty((n_rows, width)), np.zeros((width + MORE_COLUMNS, n_rows))
    out[:] = 0.0
    for s in range(starts):
        for row in range(n_rows):
            for j in range(width):
                own[row, j] = rows[row, place[s * width + j]]
        add_gram(out[s], own, targets, turns, n_rows, np.int64(0), width, columns)
