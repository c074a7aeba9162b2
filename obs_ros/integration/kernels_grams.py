# ruff: noqa: F821
# mypy: ignore-errors
"""The compiled kernel of Gram matrices, as a text that goes below `kernels.py`."""


@entry
def grams(t, steps, u, slope, y, weight, measured, period, nodes, x0, p, out):
    """Gram matrices of residuals and output differences: out (starts, 1 + d, 1 + d).

    Each start owns 1 + d neighbouring lanes: its base point, then one perturbed point per unknown.
    Row and column 0 stand for the base point's scaled residuals, j for the scaled outputs of its
    lane j less those of the base. As many starts as there are lanes in a chunk go together: they
    fill their chunks.
    """
    starts, width = out.shape[0], out.shape[1]
    most = chunks_of(min(starts, N_LANES), width)
    x = np.empty((most, N_STATES * N_LANES))
    q = np.empty((most, max(1, N_PARAMETERS) * N_LANES))
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
                        for lane in range(LANES):
                            yk = output(t[k], gather_x(xc, lane), uk, gather_p(qc, lane))
                            yk = shown(yk, y, k)
                            put_rows(rows, row, offset + lane, yk, weight, k)
                        row += N_OUTPUTS
            for s in range(begin, end):
                lane = (s - begin) * width
                add_gram(out[s], rows, targets, turns, n_rows, lane, width, columns)
            first = last


@jit
def nodes_of_block(width):
    """Return how many nodes are taken at once: long sums are fast, short ones stay in the cache."""
    fit = BLOCK_VALUES // (width * N_LANES * N_OUTPUTS)
    return max(fit, (LEAST_ROWS + N_OUTPUTS - 1) // N_OUTPUTS)


@jit
def chunks_of(starts, width):
    """Return how many chunks so many starts fill."""
    return (starts * width + N_LANES - 1) // N_LANES


@jit
def aim(y, weight, measured, period, first, last, targets, turns):
    """Write what the rows of a block should be, and their periods; return how many rows it has."""
    n_rows = np.int64(0)
    for k in range(first, last):
        if measured[k]:
            for i in range(N_OUTPUTS):
                targets[n_rows + i] = y[k, i] * weight[k, i]
                turns[n_rows + i] = period[i] * weight[k, i]
            n_rows += N_OUTPUTS
    return n_rows


@jit_sum
def add_gram(gram, rows, targets, turns, n_rows, lane, width, columns):
    """Add the block's rows of one start to its Gram matrix; turns are their periods.

    Of the columns (width + MORE_COLUMNS, rows) the last ones are zero.
    """
    for row in range(n_rows):
        base = rows[row, lane]
        columns[0, row] = base - targets[row]
        for j in range(1, width):
            columns[j, row] = rows[row, lane + j] - base
    if PERIODIC:
        for j in range(width):
            for row in range(n_rows):
                columns[j, row] = shortest(columns[j, row], turns[row])
    for i in range(0, width, 2):
        for j in range(i, width, 4):
            add_products(gram, columns, n_rows, i, j, width - 1)
    for i in range(width):
        for j in range(i):
            gram[i, j] = gram[j, i]


@jit_sum
def add_products(gram, columns, n_rows, i, j, last):
    """Add the products of two columns from i on with four from j on: each is read for several."""
    a, b = columns[i], columns[i + 1]
    c, d, e, f = columns[j], columns[j + 1], columns[j + 2], columns[j + 3]
    ac = ad = ae = af = bc = bd = be = bf = 0.0
    for row in range(n_rows):
        ac += a[row] * c[row]
        ad += a[row] * d[row]
        ae += a[row] * e[row]
        af += a[row] * f[row]
        bc += b[row] * c[row]
        bd += b[row] * d[row]
        be += b[row] * e[row]
        bf += b[row] * f[row]
    # Beyond the last one columns are zero, and add nothing to its entries.
    i1, j1, j2, j3 = min(i + 1, last), min(j + 1, last), min(j + 2, last), min(j + 3, last)
    gram[i, j] += ac
    gram[i, j1] += ad
    gram[i, j2] += ae
    gram[i, j3] += af
    gram[i1, j] += bc
    gram[i1, j1] += bd
    gram[i1, j2] += be
    gram[i1, j3] += bf
