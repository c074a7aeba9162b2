# ruff: noqa: F821
# mypy: ignore-errors
"""The compiled extended Kalman filter, as a text that goes below `kernels.py`.

Its module is made for one number N_JOINT of states and moving parameters, so that loops over them
unroll. `filter_pass.py` has the equations, `Differences` the lanes, `filter_step.py` the filter
that goes from output to output.
"""


@entry
def filter_pass(
    t, steps, u, slope, y, known, measured, period, x0, p, variances, noise, prior, moving, size,
    low, high, transition, sensitivity, gain, cross, S, innovations, means, covariances,
):  # fmt: skip
    """Fill in the arrays of a `FilterPass`; variances (d,) are the walks', noise (r,) outputs'."""
    x = np.empty((N_CHUNKS, N_STATES * N_LANES))
    q = np.empty((N_CHUNKS, max(1, N_PARAMETERS) * N_LANES))
    yhat = np.empty((N_CHUNKS, N_OUTPUTS * N_LANES))
    z, inverse = np.empty(N_JOINT), np.empty(N_JOINT)
    K, PC = np.empty(N_JOINT), np.empty(N_JOINT)
    P, FP = np.empty((N_JOINT, N_JOINT)), np.empty((N_STATES, N_JOINT))
    for a in range(N_JOINT):  # assigning arrays compiles a message on their shapes, for seconds
        for b in range(N_JOINT):
            P[a, b] = prior[a, b]
    begin(x0, p, moving, z, q)
    spread(z, moving, size, low, high, x, q, inverse)
    for k in range(t.size):
        if k > 0:
            dt = t[k] - t[k - 1]
            for chunk in range(N_CHUNKS):
                used = count_of(N_POINTS, chunk)
                advance(x[chunk], q[chunk], used, t[k - 1], dt, steps[k - 1], u, slope, k - 1)
            for s in range(N_STATES):
                z[s] = x[0, s * N_LANES]
                differentiate(x, s, inverse, transition[k - 1, s], 0.0)
            predict(transition[k - 1], dt, variances, P, FP)
            spread(z, moving, size, low, high, x, q, inverse)
        if measured[k]:
            observe(x, q, t[k], input_at(u, slope, k, 0.0), yhat)
            for i in range(N_OUTPUTS):
                if known[k, i]:
                    differentiate(yhat, i, inverse, sensitivity[k, i], period[i])
            for i in range(N_OUTPUTS):
                if known[k, i]:
                    S[k, i] = gain_of(sensitivity[k, i], noise[i], P, PC, K)
                    h = yhat[0, i * N_LANES]
                    for j in range(i):
                        if known[k, j]:
                            h += cross[k, i, j] * innovations[k, j]
                    if RANGED and beyond(i, h, y[k, i]):
                        known[k, i] = False
                        continue
                    joseph(sensitivity[k, i], noise[i], P, PC, K)
                    innovations[k, i] = shortest(y[k, i] - h, period[i])
                    for a in range(N_JOINT):
                        z[a] += K[a] * innovations[k, i]
                    report(K, i, moving, known[k], sensitivity[k], gain[k, i], cross[k])
            spread(z, moving, size, low, high, x, q, inverse)
        for a in range(N_JOINT):
            means[k, a] = z[a]
            for b in range(N_JOINT):
                covariances[k, a, b] = P[a, b]


@entry
def filter_step(
    t, dt, steps, u, slope, pieces, y, x, p, P, variances, noise, moving, corrected, size, low,
    high, innovation, S,
):  # fmt: skip
    """Take a `LiveFilter` through one path, and correct it by the outputs y (r,) at the end.

    An output of which a saturated sensor says no more than the filter counts as not measured.
    """
    lanes = np.empty((N_CHUNKS, N_STATES * N_LANES))
    q = np.empty((N_CHUNKS, max(1, N_PARAMETERS) * N_LANES))
    yhat = np.empty((N_CHUNKS, N_OUTPUTS * N_LANES))
    z, inverse, shift = np.empty(N_JOINT), np.empty(N_JOINT), np.zeros(N_JOINT)
    K, PC, C = np.empty(N_JOINT), np.empty(N_JOINT), np.empty((N_OUTPUTS, N_JOINT))
    F, FP = np.empty((N_STATES, N_JOINT)), np.empty((N_STATES, N_JOINT))
    known = np.empty(N_OUTPUTS, np.bool_)
    begin(x, p, moving, z, q)
    for k in range(pieces):
        spread(z, moving, size, low, high, lanes, q, inverse)
        for chunk in range(N_CHUNKS):
            used = count_of(N_POINTS, chunk)
            advance(lanes[chunk], q[chunk], used, t[k], dt[k], steps[k], u, slope, k)
        for s in range(N_STATES):
            z[s] = lanes[0, s * N_LANES]
            differentiate(lanes, s, inverse, F[s], 0.0)
        predict(F, dt[k], variances, P, FP)
    spread(z, moving, size, low, high, lanes, q, inverse)
    observe(lanes, q, t[pieces], input_at(u, slope, pieces, 0.0), yhat)
    for i in range(N_OUTPUTS):
        differentiate(yhat, i, inverse, C[i], PERIODS[i])
        known[i] = not (np.isnan(y[i]) or (RANGED and beyond(i, yhat[0, i * N_LANES], y[i])))
        innovation[i] = shortest(y[i] - yhat[0, i * N_LANES], PERIODS[i]) if known[i] else np.nan
        S[i] = gain_of(C[i], noise[i], P, PC, K) if known[i] else np.nan
    for i in range(N_OUTPUTS):
        if known[i]:
            gain_of(C[i], noise[i], P, PC, K)
            e = innovation[i]
            for a in range(N_JOINT):
                K[a] *= corrected[a]
                e -= C[i, a] * shift[a]
            joseph(C[i], noise[i], P, PC, K)
            for a in range(N_JOINT):
                shift[a] += K[a] * e
    for s in range(N_STATES):
        x[s] = z[s] + shift[s]
    for m in range(N_JOINT - N_STATES):
        p[moving[m]] = z[N_STATES + m] + shift[N_STATES + m]


@jit
def begin(x0, p, moving, z, q):
    """Put the candidate into z, and its parameters into all lanes."""
    for s in range(N_STATES):
        z[s] = x0[s]
    for m in range(N_JOINT - N_STATES):
        z[N_STATES + m] = p[moving[m]]
    for chunk in range(N_CHUNKS):
        for s in range(N_PARAMETERS):
            for lane in range(N_LANES):
                q[chunk, s * N_LANES + lane] = p[s]


@jit
def beyond(i, h, y):
    """Whether output i is at or beyond the end of its range that the sensor shows."""
    return (y >= HIGH[i] and h >= HIGH[i]) or (y <= LOW[i] and h <= LOW[i])


@jit
def observe(x, q, t, uk, yhat):
    """Write the outputs (chunks, outputs * N_LANES) of all lanes."""
    for chunk in range(N_CHUNKS):
        for lane in range(LANES):
            yk = output(t, gather_x(x[chunk], lane), uk, gather_p(q[chunk], lane))
            scatter_y(yhat[chunk], lane, yk)


@jit
def report(K, i, moving, known, sensitivity, gain, cross):
    """Write the gain (n + q,) of output i, and its effect on the outputs that follow."""
    for a in range(N_STATES):
        gain[a] = K[a]
    for m in range(N_JOINT - N_STATES):
        gain[N_STATES + moving[m]] = K[N_STATES + m]
    for j in range(i + 1, N_OUTPUTS):
        if known[j]:
            total = 0.0
            for a in range(N_JOINT):
                total += sensitivity[j, a] * K[a]
            cross[j, i] = total


@jit
def spread(z, moving, size, low, high, x, q, inverse):
    """Lay z in all lanes, and z off in one variable in its own lanes, as `Differences`.

    inverse (d,) becomes one over the distances between the points compared.
    """
    for chunk in range(N_CHUNKS):
        for s in range(N_STATES):
            for lane in range(LANES):
                x[chunk, np.uint64(s) * LANES + lane] = z[s]
        for m in range(N_JOINT - N_STATES):
            for lane in range(LANES):
                q[chunk, np.uint64(moving[m]) * LANES + lane] = z[N_STATES + m]
    for j in range(N_JOINT):
        reach = DIFFERENCE * max(abs(z[j]), size[j])
        above, below = z[j] + reach, z[j] - reach
        inner, outer = min(low[j], z[j]), max(high[j], z[j])
        if CENTRAL:
            above, below = min(above, outer), max(below, inner)
        else:
            above, below = above if above <= outer else below, z[j]
        inverse[j] = 1.0 / (above - below)
        put(x, q, moving, j, 1 + j, above)
        if CENTRAL:
            put(x, q, moving, j, 1 + N_JOINT + j, below)


@jit
def put(x, q, moving, j, lane, value):
    """Write variable j of one lane."""
    if j < N_STATES:
        x[lane // N_LANES, j * N_LANES + lane % N_LANES] = value
    else:
        q[lane // N_LANES, moving[j - N_STATES] * N_LANES + lane % N_LANES] = value


@jit
def differentiate(values, row, inverse, out, period):
    """Write the derivatives (d,) of one row of values (chunks, rows * N_LANES)."""
    for j in range(N_JOINT):
        above, below = 1 + j, (1 + N_JOINT + j) if CENTRAL else 0
        difference = (
            values[above // N_LANES, row * N_LANES + above % N_LANES]
            - values[below // N_LANES, row * N_LANES + below % N_LANES]
        )
        out[j] = shortest(difference, period) * inverse[j]


@jit
def predict(F, dt, Q, P, FP):
    """Turn P into F (P + dt/3 Q) F' + dt/3 Q + dt/6 (F Q + Q F'): Simpson's rule, multiplied out.

    Of a discrete model it is F P F' + dt Q. F (n, d) has the rows of a unit matrix below it.
    """
    first, last, all_later, across = dt / 3.0, dt / 3.0, 2.0 / 3.0 * dt, dt / 6.0
    if DISCRETE:
        first, last, all_later, across = 0.0, dt, dt, 0.0
    for a in range(N_JOINT):
        P[a, a] += first * Q[a]
    for a in range(N_STATES):
        for b in range(N_JOINT):
            total = 0.0
            for c in range(N_JOINT):
                total += F[a, c] * P[c, b]
            FP[a, b] = total
    for a in range(N_STATES):
        for b in range(a + 1):
            total = across * (F[a, b] * Q[b] + F[b, a] * Q[a])
            for c in range(N_JOINT):
                total += FP[a, c] * F[b, c]
            P[a, b] = total
            P[b, a] = total
        for b in range(N_STATES, N_JOINT):
            total = FP[a, b] + across * F[a, b] * Q[b]
            P[a, b] = total
            P[b, a] = total
        P[a, a] += last * Q[a]
    for a in range(N_STATES, N_JOINT):
        P[a, a] += all_later * Q[a]


@jit
def gain_of(C, R, P, PC, K):
    """Write P C' and the optimal gain K (d,) for an output of derivatives C (d,) and variance R.

    Returns the innovation's variance S.
    """
    S = R
    for a in range(N_JOINT):
        total = 0.0
        for b in range(N_JOINT):
            total += P[a, b] * C[b]
        PC[a] = total
        S += C[a] * total
    inverse = 1.0 / S
    for a in range(N_JOINT):
        K[a] = PC[a] * inverse
    return S


@jit
def joseph(C, R, P, PC, K):
    """Correct P, which is symmetric, by an output with gain K (d,); Joseph's form, for any gain."""
    for a in range(N_JOINT):
        along = 0.0
        for b in range(N_JOINT):
            P[a, b] -= K[a] * PC[b]
            along += P[a, b] * C[b]
        for b in range(a + 1):
            total = P[a, b] + (R * K[a] - along) * K[b]
            P[a, b] = total
            P[b, a] = total
