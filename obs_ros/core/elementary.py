"""Elementary functions that compiled lanes compute themselves, by their names in NumPy."""

from collections.abc import Callable
from typing import Any

from obs_ros.core.exponentials import exp, exp2, expm1, log, log1p, log2, log10, power
from obs_ros.core.hyperbolic import arccosh, arcsinh, arctanh, cosh, sinh, tanh
from obs_ros.core.trigonometry import arccos, arcsin, arctan, arctan2, cos, hypot, sin, tan

ELEMENTARY: dict[str, Callable[..., Any]] = {
    each.__name__: each
    for each in (
        exp, exp2, expm1, log, log2, log10, log1p, power, sinh, cosh, tanh, arcsinh, arccosh,
        arctanh, sin, cos, tan, arcsin, arccos, arctan, arctan2, hypot,
    )
}  # fmt: skip
