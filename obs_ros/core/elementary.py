"""Elementary functions of one candidate: neither branches nor calls, so that lanes stay vectorised.

Compilers call the C library for them lane by lane, which costs ten times a plain step. Arguments
are reduced as in Cody & Waite 1980; the polynomials are minimax (Remez exchange). Errors are a
few units in the last place on machines that fuse products with sums, as all with AVX2 or NEON do.
A step waits for one operation after the other: short ways through a polynomial, by its even and odd
terms (Estrin), count for more than few operations.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

# Added to a number below 2**51, it leaves the nearest whole one in the last bits.
ROUND = 1.5 * 2.0**52
ONE = 0x3FF0000000000000  # bits of 1.0
SIGN = -0x8000000000000000  # the bit of the sign
MANTISSA = 0xFFFFFFFFFFFFF
HALF_ROOT = 0x3FE6A09E667F3BCD  # bits of the square root of 1/2
UPPER = -0x8000000  # the upper 26 bits of a mantissa, whose products are exact

LOG2E = 1.4426950408889634
LN2, LN2_REST = 0.6931471803691238, 1.9082149292705877e-10  # the first with 21 zeros at its end
PI, PI_REST = 3.141592653589793, 1.2246467991473532e-16
PI_LAST = -2.9947698097183397e-33
HUGE = 2.0**48
OVERFLOW, UNDERFLOW = 709.782712893384, -745.1332191019412


def bits(x: Any) -> Any:
    """Return the bits of a float as a whole number."""
    return np.float64(x).view(np.int64)


def number(i: Any) -> Any:
    """Return the float of these bits."""
    return np.int64(i).view(np.float64)


def power_of_two(k: Any) -> Any:
    """Return 2**k of a whole float k, -1022 to 1023."""
    return number((bits(k + ROUND) << 52) + ONE)


def grown(r: Any) -> Any:
    """Return exp(r) - 1 for |r| up to ln(2) / 2."""
    z = r * r
    a = 0.5000000000000012 + r * 0.166666666666667
    b = 0.04166666666651542 + r * 0.008333333333307148
    c = 0.0013888888947016199 + r * 0.00019841269917509537
    d = 2.480148994142492e-05 + r * 2.7557216193028082e-06
    e = 2.763128072396285e-07 + r * 2.5117893222151122e-08
    y = z * z
    return r + z * ((a + z * b) + y * ((c + z * d) + y * e))


def scaled(r: Any, k: Any, x: Any) -> Any:
    """Return exp(r) * 2**k, which is exp(x)."""
    half = (k * 0.5 + ROUND) - ROUND  # 2**1024 is no number
    s = power_of_two(half)
    found = (s + s * grown(r)) * power_of_two(k - half)
    return math.inf if x > OVERFLOW else (0.0 if x < UNDERFLOW else found)


def exp(x: Any) -> Any:
    """Compute np.exp(x)."""
    k = (x * LOG2E + ROUND) - ROUND
    return scaled((x - k * LN2) - k * LN2_REST, k, x)


def expm1(x: Any) -> Any:
    """Compute np.expm1(x)."""
    k = (x * LOG2E + ROUND) - ROUND
    r = (x - k * LN2) - k * LN2_REST
    s = power_of_two(k - 1.0)
    found = 2.0 * (s * grown(r) + (s - 0.5))
    found = x if np.abs(x) < 1e-17 else found
    return math.inf if x > OVERFLOW else (-1.0 if x < -40.0 else found)


def tanh(x: Any) -> Any:
    """Compute np.tanh(x)."""
    z = 2.0 * x
    k = (z * LOG2E + ROUND) - ROUND
    r = (z - k * LN2) - k * LN2_REST
    s = power_of_two(k)
    e = s * grown(r) + (s - 1.0)
    found = e / (e + 2.0)
    return 1.0 if x > 20.0 else (-1.0 if x < -20.0 else found)


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


def log(x: Any) -> Any:
    """Compute np.log(x)."""
    m, k = split(x)
    f = m - 1.0
    s = f / (f + 2.0)
    z = s * s
    half = 0.5 * f * f
    rest = s * (half + z * atanh_series(z)) + k * LN2_REST
    found = k * LN2 + (f - (half - rest))
    return special_log(x, found)


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


def sine(r: Any) -> Any:
    """Return sin(r) for |r| up to pi / 2."""
    z = r * r
    y = z * z
    a = -0.16666666666666666 + z * 0.008333333333333193
    b = -0.00019841269841208844 + z * 2.7557319211071427e-06
    c = -2.5052106866630427e-08 + z * 1.6058939388709893e-10
    d = -7.642983060215164e-13 + z * 2.721084434032425e-15
    return r + (r * z) * ((a + y * b) + (y * y) * (c + y * d))


def turned(t: Any, found: Any) -> Any:
    """Return found, or its negative where the whole number in the last bits of t is odd."""
    return number(bits(found) ^ (bits(t) << 63))


def sin(x: Any) -> Any:
    """Compute np.sin(x); NaN of angles beyond 2**48, which a float knows to 0.06 only."""
    t = x * (1.0 / math.pi) + ROUND
    k = t - ROUND
    found = turned(t, sine(((x - k * PI) - k * PI_REST) - k * PI_LAST))
    return found if np.abs(x) < HUGE else math.nan


def cos(x: Any) -> Any:
    """Compute np.cos(x); NaN as of `sin`."""
    t = (x * (1.0 / math.pi) - 0.5) + ROUND
    k = (t - ROUND) + 0.5
    found = turned(t, -sine(((x - k * PI) - k * PI_REST) - k * PI_LAST))
    return found if np.abs(x) < HUGE else math.nan


def tan(x: Any) -> Any:
    """Compute np.tan(x), of twice half the angle; NaN as of `sin`."""
    t = x * (2.0 / math.pi) + ROUND
    k = t - ROUND
    h = 0.5 * (((x - k * (PI / 2)) - k * (PI_REST / 2)) - k * (PI_LAST / 2))
    z = h * h
    y = z * z
    w = y * y
    v = w * w
    a = 0.3333333333333354 + z * 0.13333333333280264
    b = 0.05396825401451359 + z * 0.02186948656153321
    c = 0.00886328311579258 + z * 0.0035914377653219233
    d = 0.0014619659879584375 + z * 0.0005576020940811595
    series = ((a + y * b) + w * (c + y * d)) + v * 0.00033103326462622577
    s = h + (h * z) * series
    up, down = 2.0 * s, 1.0 - s * s
    odd = (bits(t) & 1) == 1
    found = (-down if odd else up) / (up if odd else down)
    found = x if np.abs(x) < 1e-17 else found
    return found if np.abs(x) < HUGE else math.nan


def arc(q: Any) -> Any:
    """Return arctan(q) for q from 0 to 1."""
    z = q * q
    y = z * z
    w = y * y
    v = w * w
    u = v * v
    a = -0.33333333333333093 + z * 0.19999999999955445
    b = -0.14285714282802758 + z * 0.11111111013665372
    c = -0.09090907119490019 + z * 0.07692281189219294
    d = -0.0666641501548277 + z * 0.05880592650995345
    e = -0.05253805943633238 + z * 0.047232945707721234
    f = -0.0422172069598065 + z * 0.03669357943935558
    g = -0.029985642642050135 + z * 0.022085228034490912
    h = -0.013995051969191756 + z * 0.007263400687615255
    i = -0.0029193634016293417 + z * 0.0008434921797846589
    j = -0.00015479872079606857 + z * 1.3489451018699888e-05
    series = (((a + y * b) + w * (c + y * d)) + v * ((e + y * f) + w * (g + y * h))) + u * (
        i + y * j
    )
    return q + (q * z) * series


def arctan2(y: Any, x: Any) -> Any:
    """Compute np.arctan2(y, x)."""
    a, b = np.abs(y), np.abs(x)
    steep, back = a > b, bits(x) < 0
    low, high = (b if steep else a), (a if steep else b)
    found = arc(low / high if a != b else (0.0 if a == 0.0 else 1.0))
    corner = (0.5 * PI) if steep else (PI if back else 0.0)
    rest = (0.5 * PI_REST) if steep else (PI_REST if back else 0.0)
    found = corner + (rest + (-found if steep != back else found))
    return number((bits(found) & ~SIGN) | (bits(y) & SIGN))


def arctan(x: Any) -> Any:
    """Compute np.arctan(x)."""
    return arctan2(x, 1.0)


def arcsin(x: Any) -> Any:
    """Compute np.arcsin(x)."""
    return arctan2(x, np.sqrt((1.0 - x) * (1.0 + x)))


def arccos(x: Any) -> Any:
    """Compute np.arccos(x)."""
    return 2.0 * arctan2(np.sqrt(1.0 - x), np.sqrt(1.0 + x))


def power(x: Any, y: Any) -> Any:
    """Compute np.power(x, y) of floats: exp(y * log(abs(x))), the logarithm in two parts.

    The first of these, and of y, has 26 bits, so that the product of both is exact.
    """
    size = np.abs(x)
    m, k = split(size)
    f, d = m - 1.0, m + 1.0
    s = f / d
    z = s * s
    lost = ((f - s * d) - s * (m - (d - 1.0))) / d  # by the rounding of s
    twice, further, main = 2.0 * s, (s * z) * atanh_series(z), k * LN2
    part = twice + further
    whole = main + part
    upper = number(bits(whole) & UPPER)
    lost = ((twice - part) + further) + (2.0 * lost + k * LN2_REST)
    lower = (whole - upper) + ((part - (whole - main)) + lost)
    upper = special_log(size, upper)
    first = number(bits(y) & UPPER) if np.abs(y) > 1e-290 else y
    product = first * upper
    rest = first * lower + (y - first) * (upper + lower)
    k = (product * LOG2E + ROUND) - ROUND
    found = scaled((product - k * LN2) - (k * LN2_REST - rest), k, product)
    return signed_power(x, y, size, found)


def signed_power(x: Any, y: Any, size: Any, found: Any) -> Any:
    """Return x ** y, of which found is the absolute value wherever that needs a logarithm."""
    one = (y == 0.0) | (x == 1.0) | ((size == 1.0) & (np.abs(y) == math.inf))
    found = 1.0 if one else found
    whole = np.floor(y) == y
    odd = whole & (np.floor(0.5 * y) * 2.0 != y)
    found = -found if (bits(x) < 0) & odd else found
    return math.nan if (x < 0.0) & (x > -math.inf) & ~whole else found


def hypot(x1: Any, x2: Any) -> Any:
    """Compute np.hypot(x1, x2)."""
    a, b = np.abs(x1), np.abs(x2)
    large, small = (a > 2.0**500) | (b > 2.0**500), (a < 2.0**-500) & (b < 2.0**-500)
    there = 2.0**-600 if large else (2.0**600 if small else 1.0)
    back = 2.0**600 if large else (2.0**-600 if small else 1.0)
    a, b = a * there, b * there
    found = np.sqrt(a * a + b * b) * back
    return math.inf if (a == math.inf) | (b == math.inf) else found


# By their names in NumPy: those that lanes would call the C library for.
ELEMENTARY: dict[str, Callable[..., Any]] = {
    each.__name__: each
    for each in (
        exp, expm1, log, log1p, sin, cos, tan, arcsin, arccos, arctan, arctan2, tanh, power, hypot,
    )
}  # fmt: skip
