"""Exponentials, logarithms and powers of one candidate: neither branches nor calls.

Compilers call the C library for them lane by lane, which costs ten times a plain step. Arguments
are reduced as in Cody & Waite 1980; the polynomials are minimax (Remez exchange). Errors are a
few units in the last place on machines that fuse products with sums, as all with AVX2 or NEON do.
A step waits for one operation after the other: short ways through a polynomial, by its even and odd
terms (Estrin), count for more than few operations.
"""

import math
from typing import Any

import numpy as np

from obs_ros.core.float_bits import ONE, ROUND, bits, number, power_of_two

MANTISSA = 0xFFFFFFFFFFFFF
HALF_ROOT = 0x3FE6A09E667F3BCD  # bits of the square root of 1/2
UPPER = -0x8000000  # the upper 26 bits of a mantissa, whose products are exact
LOG2E, LOG10E, LOG10_2 = 1.4426950408889634, 0.4342944819032518, 0.3010299956639812
LN2, LN2_REST = 0.6931471803691238, 1.9082149292705877e-10  # the first with 21 zeros at its end
OVERFLOW, UNDERFLOW = 709.782712893384, -745.1332191019412


def growth(r: Any, z: Any) -> Any:
    """Return (exp(r) - 1 - r) / z for |r| up to ln(2) / 2, z being r**2."""
    a = 0.5000000000000012 + r * 0.166666666666667
    b = 0.04166666666651542 + r * 0.008333333333307148
    c = 0.0013888888947016199 + r * 0.00019841269917509537
    d = 2.480148994142492e-05 + r * 2.7557216193028082e-06
    e = 2.763128072396285e-07 + r * 2.5117893222151122e-08
    y = z * z
    return (a + z * b) + y * ((c + z * d) + y * e)


def scaled(r: Any, t: Any, x: Any) -> Any:
    """Return exp(r) * 2**k, which is exp(x), of the whole number k in the last bits of t."""
    half = bits(t) >> 1  # 2**1024 is no number
    s = power_of_two(half)
    z = r * r
    found = ((s + s * r) + (s * z) * growth(r, z)) * power_of_two(bits(t) - half)
    end = math.inf if x > 0.0 else 0.0
    return end if (x > OVERFLOW) | (x < UNDERFLOW) else found


def exp(x: Any) -> Any:
    """Compute np.exp(x)."""
    t = x * LOG2E + ROUND
    k = t - ROUND
    return scaled((x - k * LN2) - k * LN2_REST, t, x)


def exp2(x: Any) -> Any:
    """Compute np.exp2(x)."""
    t = x + ROUND
    return scaled((x - (t - ROUND)) * (LN2 + LN2_REST), t, x * (LN2 + LN2_REST))


def expm1(x: Any) -> Any:
    """Compute np.expm1(x)."""
    t = x * LOG2E + ROUND
    k = t - ROUND
    r = (x - k * LN2) - k * LN2_REST
    s = power_of_two(bits(t) - 1)
    z = r * r
    found = 2.0 * ((s * r + (s - 0.5)) + (s * z) * growth(r, z))
    end = math.inf if x > 1.0 else (-1.0 if x < -1.0 else x)
    return end if (x > OVERFLOW) | (x < -40.0) | (np.abs(x) < 1e-17) else found


def atanh_series(z: Any) -> Any:
    """Return (2 artanh(s) - 2 s) / s**3 of z = s**2, for |s| up to 0.172."""
    y = z * z
    a = 0.6666666666666666 + z * 0.4000000000000625
    b = 0.28571428569085905 + z * 0.22222222646793485
    c = 0.18181775665812205 + z * 0.1538709074258447
    d = 0.1325011850759622 + z * 0.13251325370240505
    return (a + y * b) + (y * y) * (c + y * d)


def split(x: Any) -> Any:
    """Return m and k with x = m * 2**k of a positive x, m from the root of 1/2 to that of 2."""
    tiny = x < 2.2250738585072014e-308
    i = bits(x * 18014398509481984.0 if tiny else x) - HALF_ROOT
    k = number(((i + ONE) >> 52) | 0x4330000000000000) - 4503599627371519.0
    return number((i & MANTISSA) + HALF_ROOT), (k - 54.0 if tiny else k)


def logarithm(m: Any, k: Any) -> Any:
    """Return log(m * 2**k), of what `split` returns."""
    f = m - 1.0
    s = f / (m + 1.0)
    z = s * s
    half = 0.5 * f * f
    main = (k * LN2 + f) - ((half - k * LN2_REST) - s * half)
    return main + (s * z) * atanh_series(z)


def log(x: Any) -> Any:
    """Compute np.log(x)."""
    m, k = split(x)
    return special_log(x, logarithm(m, k))


def log2(x: Any) -> Any:
    """Compute np.log2(x)."""
    m, k = split(x)
    return special_log(x, k + LOG2E * logarithm(m, 0.0))


def log10(x: Any) -> Any:
    """Compute np.log10(x)."""
    m, k = split(x)
    return special_log(x, k * LOG10_2 + LOG10E * logarithm(m, 0.0))


def special_log(x: Any, found: Any) -> Any:
    """Return the logarithm found of a positive number x, and those of others."""
    return found if (x > 0.0) & (x < math.inf) else (
        -math.inf if x == 0.0 else (x if x == math.inf else math.nan)
    )  # fmt: skip


def log1p(x: Any) -> Any:
    """Compute np.log1p(x), by the logarithm of 1 + x and what its rounding lost."""
    w = 1.0 + x
    lost = (x - (w - 1.0)) if x < 1.0 else (1.0 - (w - x))
    found = log(w) + lost / w
    return x if (w == 1.0) | (w == math.inf) else (-math.inf if w == 0.0 else found)


def power(x: Any, y: Any) -> Any:
    """Compute np.power(x, y) of floats: exp(y * log(abs(x))), the logarithm in two parts.

    The first of these, and of y, has 26 bits, so that the product of both is exact.
    """
    size = np.abs(x)
    m, k = split(size)
    f, d = m - 1.0, m + 1.0
    inverse = 1.0 / d
    s = f * inverse
    z = s * s
    lost = ((f - s * d) - s * (m - (d - 1.0))) * inverse  # by the rounding of s
    twice, further, main = 2.0 * s, (s * z) * atanh_series(z), k * LN2
    part = twice + further
    whole = main + part
    upper = number(bits(whole) & UPPER)
    # What s has lost counts by the slope of 2 artanh(s), which is 2 + 2 z + ...
    lost = ((twice - part) + further) + (2.0 * (lost + z * lost) + k * LN2_REST)
    lower = (whole - upper) + ((part - (whole - main)) + lost)
    first = number(bits(y) & UPPER) if np.abs(y) > 1e-290 else y
    product = first * upper
    rest = first * lower + (y - first) * (upper + lower)
    t = product * LOG2E + ROUND
    k = t - ROUND
    found = scaled((product - k * LN2) - (k * LN2_REST - rest), t, product)
    return signed_power(x, y, size, found)


def signed_power(x: Any, y: Any, size: Any, found: Any) -> Any:
    """Return x ** y, of which found is the absolute value wherever that needs a logarithm."""
    one = (y == 0.0) | (x == 1.0) | ((size == 1.0) & (np.abs(y) == math.inf))
    whole = np.floor(y) == y
    odd = whole & (np.floor(0.5 * y) * 2.0 != y)
    none = (size != size) | (y != y) | ((x < 0.0) & (size < math.inf) & ~whole)
    end = 0.0 if (size < 1.0) == (y > 0.0) else math.inf
    end = 1.0 if one else (math.nan if none else end)
    found = end if one | none | (size == 0.0) | (size == math.inf) else found
    return -found if (bits(x) < 0) & odd else found
