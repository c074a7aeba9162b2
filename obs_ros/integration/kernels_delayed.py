# ruff: noqa: F821
# mypy: ignore-errors
"""The compiled kernel of models whose delays are estimated, as a text; see `kernels.py`."""


@jit
def advance_late(x, p, t, dt, steps, u, slope, f, first):
    """Propagate the candidates in x over step f; each has inputs of its own."""
    h = dt / steps
    for j in range(steps):
        s = j * h
        for lane in range(LANES):
            u0 = late_input(u, slope, f, first + lane, s)
            u1 = late_input(u, slope, f, first + lane, s + 0.5 * h)
            u2 = late_input(u, slope, f, first + lane, s + h)
            scatter_x(x, lane, step(t + s, h, gather_x(x, lane), u0, u1, u2, gather_p(p, lane)))


@entry
def delayed(t, steps, at, u, slope, along, there, offset, late, wanted, x0, p, states, outputs):
    """States (K, n, lanes) and outputs (K, r, lanes) of candidates with delays; see `Delayed`."""
    x = np.empty(N_STATES * N_LANES)
    q = np.empty((len(p), max(1, N_PARAMETERS) * N_LANES))
    track = np.empty((t.size, N_STATES, N_LANES))
    begin = np.empty((t.size - 1, N_STATES, N_LANES))
    end = np.empty((t.size - 1, N_STATES, N_LANES))
    for chunk in range(x0.shape[1] // N_LANES):
        load(x0, chunk, N_STATES, x)
        for one in range(len(p)):
            load(p[one], chunk, N_PARAMETERS, q[one])
        first = np.uint64(chunk) * LANES
        for lane in range(LANES):
            put_x(track, 0, lane, gather_x(x, lane))
        for f in range(t.size - 1):
            dt, qf = t[f + 1] - t[f], q[along[f]]
            for lane in range(LANES):
                now = late_input(u, slope, f, first + lane, 0.0)
                put_x(begin, f, lane, dynamics(t[f], gather_x(x, lane), now, gather_p(qf, lane)))
            advance_late(x, qf, t[f], dt, steps[f], u, slope, f, first)
            for lane in range(LANES):
                xs = gather_x(x, lane)
                put_x(track, f + 1, lane, xs)
                last = late_input(u, slope, f, first + lane, dt)
                put_x(end, f, lane, dynamics(t[f + 1], xs, last, gather_p(qf, lane)))
        for k in range(at.size):
            qk = q[there[k]]
            for lane in range(LANES):
                xs = track_at(track, at[k], lane)
                put_x(states, k, first + lane, xs)
                now = late_input(u, slope, at[k], first + lane, 0.0)
                yk = output(t[at[k]], xs, now, gather_p(qk, lane))
                for i in range(N_OUTPUTS):
                    if wanted[k, i] and not late[i]:
                        put_entry(outputs, k, i, first + lane, yk)
        for i in range(N_OUTPUTS):
            if late[i]:
                for lane in range(LANES):
                    look_back(
                        t,
                        at,
                        u,
                        slope,
                        along,
                        offset[i, first + lane],
                        wanted,
                        track,
                        begin,
                        end,
                        q,
                        i,
                        lane,
                        first + lane,
                        outputs,
                    )


@jit
def look_back(
    t, at, u, slope, along, offset, wanted, track, begin, end, q, i, lane, place, outputs
):
    """Write output i of a candidate, `offset` s before each node."""
    f = 0
    for k in range(at.size):
        if wanted[k, i]:
            tau = t[at[k]] - offset
            while f < t.size - 2 and t[f + 1] <= tau:
                f += 1
            s, h = tau - t[f], t[f + 1] - t[f]
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
            now, qf = late_input(u, slope, f, place, s), q[along[f]]
            put_entry(outputs, k, i, place, output(tau, xs, now, gather_p(qf, lane)))
