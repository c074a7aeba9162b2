# ruff: noqa: F821
# mypy: ignore-errors
"""The compiled linearly implicit step, as a text that goes below `kernels.py`.

`linearised`, `factored` and `solved` are those of `core/derivatives` and `core/elimination`; the
stages are unrolled by `rosenbrock_source`. `steps.rosenbrock` has the method.
"""


@jit
def step_rosenbrock(t, h, x, u0, u1, u2, p):
    """Advance one candidate by h seconds; u0 and u2 are the inputs at begin and end."""
    inverse = 1.0 / h
    found = linearised(t, h, x, u0, slopes(u0, u2, inverse), p)
    factors = factored(2.0 * inverse, found)
    k1 = solved(factors, first_stage(found, 0.5 * h))
    k2 = solved(factors, second_stage(found, 1.5 * h, 4.0 * inverse, k1))
    y = axpy(x, 2.0, k1)
    k3 = solved(factors, third_stage(dynamics(t + h, y, u2, p), inverse, k1, k2))
    y = axpy(y, 1.0, k3)
    last = fourth_stage(dynamics(t + h, y, u2, p), inverse, k1, k2, k3)
    return axpy(y, 1.0, solved(factors, last))
