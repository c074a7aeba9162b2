"""Functions of angles of one candidate: neither branches nor calls; see `exponentials`.

Where a machine does not fuse products with sums, angles beyond pi / 2 count as if they were off by
their last place.
"""

import math
from typing import Any

import numpy as np

from obs_ros.core.float_bits import ROUND, SIGN, bits, number

PI, PI_REST, PI_LAST = 3.141592653589793, 1.2246467991473532e-16, -2.9947698097183397e-33
HUGE = 2.0**48  # an angle that a float knows to 0.06 only


def sine_series(z: Any) -> Any:
    """Return (sin(r) - r) / r**3 of z = r**2, for |r| up to pi / 2."""
    y = z * z
    a = -0.16666666666666666 + z * 0.008333333333333193
    b = -0.00019841269841208844 + z * 2.7557319211071427e-06
    c = -2.5052106866630427e-08 + z * 1.6058939388709893e-10
    d = -7.642983060215164e-13 + z * 2.721084434032425e-15
    return (a + y * b) + (y * y) * (c + y * d)


def turned(x: Any, k: Any, sign: Any) -> Any:
    """Return sin(x - k * pi), of this sign."""
    r = (x - k * PI) - k * PI_REST
    z = r * r
    main = number(bits(r - k * PI_LAST) ^ (sign << 63))
    main = main if np.abs(x) < HUGE else math.nan
    return main + (main * z) * sine_series(z)


def sin(x: Any) -> Any:
    """Compute np.sin(x); NaN of angles beyond 2**48, which a float knows to 0.06 only."""
    t = x * (1.0 / math.pi) + ROUND
    return turned(x, t - ROUND, bits(t))


def cos(x: Any) -> Any:
    """Compute np.cos(x); NaN as of `sin`."""
    t = (x * (1.0 / math.pi) - 0.5) + ROUND
    return turned(x, (t - ROUND) + 0.5, bits(t) + 1)


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


def arc_series(z: Any) -> Any:
    """Return (arctan(q) - q) / q**3 of z = q**2, for q from 0 to 1."""
    y = z * z
    w = y * y
    v = w * w
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
    lower, upper = (a + y * b) + w * (c + y * d), (e + y * f) + w * (g + y * h)
    return (lower + v * upper) + (v * v) * (i + y * j)


def arctan2(y: Any, x: Any) -> Any:
    """Compute np.arctan2(y, x)."""
    a, b = np.abs(y), np.abs(x)
    steep, back = a > b, bits(x) < 0
    low, high = (b if steep else a), (a if steep else b)
    q = low / high if a != b else (0.0 if a == 0.0 else 1.0)
    z = q * q
    q = -q if steep != back else q
    corner = (0.5 * PI) if steep else (PI if back else 0.0)
    rest = (0.5 * PI_REST) if steep else (PI_REST if back else 0.0)
    found = (corner + (rest + q)) + (q * z) * arc_series(z)
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


def hypot(x1: Any, x2: Any) -> Any:
    """Compute np.hypot(x1, x2)."""
    a, b = np.abs(x1), np.abs(x2)
    large, small = (a > 2.0**500) | (b > 2.0**500), (a < 2.0**-500) & (b < 2.0**-500)
    there = 2.0**-600 if large else (2.0**600 if small else 1.0)
    back = 2.0**600 if large else (2.0**-600 if small else 1.0)
    a, b = a * there, b * there
    found = np.sqrt(a * a + b * b) * back
    return math.inf if (a == math.inf) | (b == math.inf) else found
