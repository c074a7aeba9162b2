"""Hyperbolic functions and their inverses, of exponentials and logarithms in vector lanes."""

import math
from typing import Any

import numpy as np

from obs_ros.core.exponentials import LN2, LN2_REST, LOG2E, expm1, growth, log1p, scaled
from obs_ros.core.float_bits import ROUND, SIGN, bits, number, power_of_two

WIDE = 1e18  # of so large an x, log1p(x) is log(x), and the root of x**2 + 1 is x


def tanh(x: Any) -> Any:
    """Compute np.tanh(x)."""
    t = x * (2.0 * LOG2E) + ROUND
    k = t - ROUND
    r = (2.0 * x - k * LN2) - k * LN2_REST
    s = power_of_two(bits(t))
    z = r * r
    more = (s * z) * growth(r, z)
    found = ((s * r + (s - 1.0)) + more) / ((s * r + (s + 1.0)) + more)
    end = 1.0 if x > 0.0 else -1.0
    return end if np.abs(x) > 20.0 else found


def half_exp(a: Any) -> Any:
    """Return exp(a) / 2, which is finite beyond the end of exp(a)."""
    t = a * LOG2E + ROUND
    k = t - ROUND
    return scaled((a - k * LN2) - k * LN2_REST, t - 1.0, a - LN2)


def sinh(x: Any) -> Any:
    """Compute np.sinh(x)."""
    a = np.abs(x)
    e, h = expm1(a if a < 1.0 else 1.0), half_exp(a)
    return signed(0.5 * (e + e / (e + 1.0)) if a < 1.0 else h - 0.25 / h, x)


def cosh(x: Any) -> Any:
    """Compute np.cosh(x)."""
    h = half_exp(np.abs(x))
    return h + 0.25 / h


def arcsinh(x: Any) -> Any:
    """Compute np.arcsinh(x)."""
    a = np.abs(x)
    near = a if a < WIDE else WIDE
    square = near * near
    w = near + square / (1.0 + np.sqrt(1.0 + square))
    return signed(log1p(w if a < WIDE else a) + (0.0 if a < WIDE else LN2 + LN2_REST), x)


def arccosh(x: Any) -> Any:
    """Compute np.arccosh(x)."""
    near = (x if x < WIDE else WIDE) - 1.0
    w = near + np.sqrt(near * (near + 2.0))
    found = log1p(w if x < WIDE else x) + (0.0 if x < WIDE else LN2 + LN2_REST)
    return found if x >= 1.0 else math.nan


def arctanh(x: Any) -> Any:
    """Compute np.arctanh(x)."""
    a = np.abs(x)
    return signed(0.5 * log1p(2.0 * a / (1.0 - a)), x)


def signed(found: Any, x: Any) -> Any:
    """Return the positive number found, with the sign of x."""
    return number((bits(found) & ~SIGN) | (bits(x) & SIGN))
