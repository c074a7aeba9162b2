"""One integration step on tuples of floats or arrays."""

from collections.abc import Callable
from typing import Any

from obs_ros.core.model import PlantFunction

Step = Callable[[PlantFunction, float, float, Any, Any, Any, Any, Any], tuple[Any, ...]]


def rk4(f: PlantFunction, t: float, h: float, x: Any, u0: Any, u1: Any, u2: Any, p: Any) -> Any:
    """Advance x by h seconds with the classical Runge-Kutta method of order 4.

    u0, u1 and u2 are the inputs at the step's begin, middle and end.
    """
    k1 = f(t, x, u0, p)
    k2 = f(t + 0.5 * h, axpy(x, 0.5 * h, k1), u1, p)
    k3 = f(t + 0.5 * h, axpy(x, 0.5 * h, k2), u1, p)
    k4 = f(t + h, axpy(x, h, k3), u2, p)
    return tuple(
        xi + h / 6.0 * (a + 2.0 * (b + c) + d)
        for xi, a, b, c, d in zip(x, k1, k2, k3, k4, strict=True)
    )


def euler(f: PlantFunction, t: float, h: float, x: Any, u0: Any, u1: Any, u2: Any, p: Any) -> Any:
    """Advance x by h seconds with Euler's explicit method."""
    return axpy(x, h, f(t, x, u0, p))


def following(
    f: PlantFunction, t: float, h: float, x: Any, u0: Any, u1: Any, u2: Any, p: Any
) -> Any:
    """Return the next state of a discrete model, h seconds, its period, later."""
    return tuple(f(t, x, u0, p))


def axpy(x: Any, a: float, k: Any) -> tuple[Any, ...]:
    """Return x + a k, entry by entry."""
    return tuple(xi + a * ki for xi, ki in zip(x, k, strict=True))


STEPS: dict[str, Step] = {'rk4': rk4, 'euler': euler, 'discrete': following}
