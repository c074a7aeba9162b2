"""One integration step on tuples of floats or arrays."""

from collections.abc import Callable
from typing import Any

from obs_ros.core.derivatives import linearisation
from obs_ros.core.elimination import elimination
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


def rosenbrock(
    f: PlantFunction, t: float, h: float, x: Any, u0: Any, u1: Any, u2: Any, p: Any
) -> Any:
    """Advance x by h seconds with RODAS3; inputs run straight from u0 to u2. See `estimated`."""
    return estimated(f, t, h, x, u0, u2, p)[0]


def estimated(
    f: PlantFunction, t: Any, h: Any, x: Any, u0: Any, u2: Any, p: Any
) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    """Return x after h seconds of RODAS3, and how far a method of order 2 is from it.

    Stages solve linear systems in c I - df/dx. Order 3, L-stable and stiffly accurate: Sandu et al.
    1997, "Benchmarking stiff ODE solvers for atmospheric chemistry problems II: Rosenbrock
    solvers", in the form without products with df/dx (Hairer & Wanner 1996, section IV.7). The last
    stage is the difference from the embedded method.
    """
    n = len(x)
    linear = linearisation(f, n, len(u0), len(p))
    system = elimination(n, linear.places, n)
    v = tuple((b - a) / h for a, b in zip(u0, u2, strict=True))
    found = linear.function(t, h, x, u0, v, p)
    rates = found[:n]
    driven = dict(zip(linear.moving, found[n + len(linear.places) :], strict=True))
    g = tuple(driven.get(i, 0.0) for i in range(n))
    factors = system.factored(2.0 / h, found)
    k1 = system.solved(factors, axpy(rates, 0.5 * h, g))
    k2 = system.solved(factors, axpy(axpy(rates, 1.5 * h, g), 4.0 / h, k1))
    y = axpy(x, 2.0, k1)
    both = axpy(k1, -1.0, k2)
    k3 = system.solved(factors, axpy(f(t + h, y, u2, p), 1.0 / h, both))
    y = axpy(y, 1.0, k3)
    last = axpy(axpy(f(t + h, y, u2, p), 1.0 / h, both), -8.0 / (3.0 * h), k3)
    error = system.solved(factors, last)
    return axpy(y, 1.0, error), error


def following(
    f: PlantFunction, t: float, h: float, x: Any, u0: Any, u1: Any, u2: Any, p: Any
) -> Any:
    """Return the next state of a discrete model, h seconds, its period, later."""
    return tuple(f(t, x, u0, p))


def axpy(x: Any, a: float, k: Any) -> tuple[Any, ...]:
    """Return x + a k, entry by entry."""
    return tuple(xi + a * ki for xi, ki in zip(x, k, strict=True))


STEPS: dict[str, Step] = {
    'rk4': rk4, 'euler': euler, 'rosenbrock': rosenbrock, 'discrete': following
}  # fmt: skip
