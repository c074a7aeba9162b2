# ruff: noqa: F821
# mypy: ignore-errors
"""The compiled linearly implicit step, as a text that goes below `kernels.py`.

`linearised`, `factored` and `solved` are those of `core/derivatives` and `core/elimination`; the
stages are unrolled by `rosenbrock_source`. `steps.rosenbrock` has the method.
"""


@jit
def step_rosenbrock(t, h, x, u0, u1, u2, p):
    """Advance one candidate by h seconds; u0 and u2 are the inputs at begin and end."""
    return estimated(t, h, x, u0, u2, p)[0]


@jit
def estimated(t, h, x, u0, u2, p):
    """Return a candidate after h seconds, and the local error that the embedded method shows."""
    inverse = 1.0 / h
    found = linearised(t, h, x, u0, slopes(u0, u2, inverse), p)
    factors = factored(2.0 * inverse, found)
    k1 = solved(factors, first_stage(found, 0.5 * h))
    k2 = solved(factors, second_stage(found, 1.5 * h, 4.0 * inverse, k1))
    y = axpy(x, 2.0, k1)
    k3 = solved(factors, third_stage(dynamics(t + h, y, u2, p), inverse, k1, k2))
    y = axpy(y, 1.0, k3)
    last = fourth_stage(dynamics(t + h, y, u2, p), inverse, k1, k2, k3)
    error = solved(factors, last)
    return axpy(y, 1.0, error), error


@jit
def try_lanes(x, p, t, h, u0, u2, y, error, work):
    """Advance all lanes from x to y, each from its t (lanes,) by its h s, with the local errors."""
    for lane in range(LANES):
        a, b, q = gather_u(u0, lane), gather_u(u2, lane), gather_p(p, lane)
        ys, es = estimated(t[lane], h[lane], gather_x(x, lane), a, b, q)
        scatter_x(y, lane, ys)
        scatter_x(error, lane, es)


@jit
def workspace(lanes):
    """Return nothing: the step needs no arrays."""
    return ()
