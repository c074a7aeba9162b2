"""How fast a plant moves about a state: the eigenvalues of df/dx."""

import math

import numpy as np
from numpy.typing import NDArray

from obs_ros.core.model import Model
from obs_ros.core.typing import Array
from obs_ros.integration.filter_pass import sizes

ComplexArray = NDArray[np.complex128]

ROUNDING = 1e-9  # of the fastest mode: slower ones are constants of motion
DIFFERENCE = 6e-6  # of a size, in central differences: eps^(1/3)


def modes(model: Model, t: float, x: Array, u: Array, p: Array) -> ComplexArray:
    """Return the eigenvalues (n,) of df/dx in 1/s; none where derivatives are not finite.

    The model is linearised at time t (s), states x (n,), inputs u (m,) and parameters p (q,).
    """
    n = x.size
    steps = DIFFERENCE * np.maximum(np.abs(x), sizes(model)[0, :n])
    moved = np.repeat(x[:, None], 2 * n, axis=1)
    moved[:, :n] += np.diag(steps)
    moved[:, n:] -= np.diag(steps)
    with np.errstate(all='ignore'):
        f = model.dynamics(t, tuple(moved), tuple(u), tuple(p))
        ends = np.array([np.broadcast_to(rate, 2 * n) for rate in f])
        J = (ends[:, :n] - ends[:, n:]) / (2.0 * steps)
    return (
        np.linalg.eigvals(J).astype(np.complex128) if np.isfinite(J).all() else np.empty(0, complex)
    )


def fastest_decay(modes: ComplexArray) -> float:
    """Return the rate in 1/s at which the fastest of some modes decays; 0 where none does."""
    return float((-modes.real).max(initial=0.0))


def shortest_time(modes: ComplexArray) -> float:
    """Return the time (s) that the fastest of some modes takes, to decay, grow or swing."""
    fastest = float(np.abs(modes).max(initial=0.0))
    return 1.0 / fastest if fastest > 0.0 else math.inf


def is_stiff(modes: ComplexArray, ratio: float) -> bool:
    """Whether one mode decays so many times faster than another moves."""
    speeds, fastest = np.abs(modes), fastest_decay(modes)
    moving = speeds > ROUNDING * speeds.max(initial=0.0)
    return bool((speeds[moving] * ratio < fastest).any())
