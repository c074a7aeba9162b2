"""The bits of floats, by which elementary functions scale and turn numbers without branches.

Rounding by a sum needs a compiler that keeps the order of sums, as the kernels' options say.
"""

from typing import Any

import numpy as np

# Added to a number below 2**51, it leaves the nearest whole one in the last bits.
ROUND = 1.5 * 2.0**52
ONE = 0x3FF0000000000000  # bits of 1.0
SIGN = -0x8000000000000000  # the bit of the sign


def bits(x: Any) -> Any:
    """Return the bits of a float as a whole number."""
    return np.float64(x).view(np.int64)


def number(i: Any) -> Any:
    """Return the float of these bits."""
    return np.int64(i).view(np.float64)


def power_of_two(i: Any) -> Any:
    """Return 2**k, -1022 to 1023, of the whole number k in the last bits of i."""
    return number((i << 52) + ONE)
