# ruff: noqa: F821
# mypy: ignore-errors
"""The compiled kernel of models whose delays are estimated, as a text; see `kernels.py`."""


@jit
def advance_late(x, p, start, t, steps, u, slope, f, first):
    """Propagate the candidates in x over step f; each has times and inputs of its own."""
    for j in range(steps):
        for lane in range(LANES):
            place = first + lane
            h = (t[f + 1, place] - t[f, place]) / steps
            s = j * h
            u0 = late_input(u, slope, f, place, s)
            u1 = late_input(u, slope, f, place, s + 0.5 * h)
            u2 = late_input(u, slope, f, place, s + h)
            now = start + t[f, place] + s
            scatter_x(x, lane, step(now, h, gather_x(x, lane), u0, u1, u2, gather_p(p, lane)))


@jit
def shown_input(t, u, slope, f, place, s, slack):
    """Inputs of a candidate as an output shows them, s seconds into step f; see `Delayed`."""
    at = t[f, place] + s
    chosen = f
    while chosen + 1 < len(t) and t[chosen + 1, place] < at + slack:
        chosen += 1
    while chosen > 0 and t[chosen, place] > at + slack:
        chosen -= 1
    return late_input(u, slope, chosen, place, at - t[chosen, place])


@entry
def delayed(
    start, t, steps, at, u, slope, along, there, offset, late, wanted, slack, x0, p, states, outputs
):
    """States (K, n, lanes), outputs (S, K, r, lanes) of candidates with delays; see `Delayed`."""
    x = np.empty(N_STATES * N_LANES)
    q = np.empty((len(p), max(1, N_PARAMETERS) * N_LANES))
    track = np.empty((len(t), N_STATES, N_LANES))
    begin = np.empty((len(t) - 1, N_STATES, N_LANES))
    end = np.empty((len(t) - 1, N_STATES, N_LANES))
    for chunk in range(x0.shape[1] // N_LANES):
        load(x0, chunk, x)
        for one in range(len(p)):
            load(p[one], chunk, q[one])
        first = np.uint64(chunk) * LANES
        for lane in range(LANES):
            put_x(track, 0, lane, gather_x(x, lane))
        for f in range(len(t) - 1):
            qf = q[along[f]]
            for lane in range(LANES):
                now = late_input(u, slope, f, first + lane, 0.0)
                time = start + t[f, first + lane]
                put_x(begin, f, lane, dynamics(time, gather_x(x, lane), now, gather_p(qf, lane)))
            advance_late(x, qf, start, t, steps[f], u, slope, f, first)
            for lane in range(LANES):
                xs = gather_x(x, lane)
                put_x(track, f + 1, lane, xs)
                place = first + lane
                last = late_input(u, slope, f, place, t[f + 1, place] - t[f, place])
                time = start + t[f + 1, place]
                put_x(end, f, lane, dynamics(time, xs, last, gather_p(qf, lane)))
        for side in range(slack.size):
            look_on(
                start,
                t,
                at,
                u,
                slope,
                there,
                late,
                wanted,
                slack[side],
                track,
                q,
                first,
                states,
                outputs[side],
            )
            for i in range(N_OUTPUTS):
                if late[i]:
                    for lane in range(LANES):
                        look_back(
                            start,
                            t,
                            at,
                            u,
                            slope,
                            along,
                            offset[i, first + lane],
                            wanted,
                            slack[side],
                            track,
                            begin,
                            end,
                            q,
                            i,
                            lane,
                            first + lane,
                            outputs[side],
                        )


@jit
def look_on(start, t, at, u, slope, there, late, wanted, slack, track, q, first, states, outputs):
    """Write states at the nodes, and the outputs that are in time."""
    for k in range(at.size):
        qk = q[there[k]]
        for lane in range(LANES):
            xs = track_at(track, at[k], lane)
            put_x(states, k, first + lane, xs)
            now = shown_input(t, u, slope, at[k], first + lane, 0.0, slack)
            yk = output(start + t[at[k], first + lane], xs, now, gather_p(qk, lane))
            for i in range(N_OUTPUTS):
                if wanted[k, i] and not late[i]:
                    put_entry(outputs, k, i, first + lane, yk)


@jit
def look_back(
    start,
    t,
    at,
    u,
    slope,
    along,
    offset,
    wanted,
    slack,
    track,
    begin,
    end,
    q,
    i,
    lane,
    place,
    outputs,
):
    """Write output i of a candidate, `offset` s before each node."""
    f = 0
    for k in range(at.size):
        if wanted[k, i]:
            tau = t[at[k], place] - offset
            while f < len(t) - 2 and t[f + 1, place] <= tau:
                f += 1
            s, h = tau - t[f, place], t[f + 1, place] - t[f, place]
            a = min(max(s / h, 0.0), 1.0)
            b = 1.0 - a
            xs = hermite_at(
                track,
                begin,
                end,
                f,
                lane,
                b * b * (1.0 + 2.0 * a),
                a * a * (1.0 + 2.0 * b),
                b * b * a * h + min(s, 0.0),
                max(s - h, 0.0) - a * a * b * h,
            )
            now, qf = shown_input(t, u, slope, f, place, s, slack), q[along[f]]
            put_entry(outputs, k, i, place, output(start + tau, xs, now, gather_p(qf, lane)))
