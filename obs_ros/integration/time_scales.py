"""How fast a plant moves about a state: the eigenvalues of df/dx."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from obs_ros.core.derivatives import linearisation
from obs_ros.core.linear_algebra import poles
from obs_ros.core.model import Model, inside
from obs_ros.core.typing import Array
from obs_ros.integration.filter_pass import sizes


@dataclass(frozen=True)
class StiffnessSettings:
    """When a model counts as stiff.

    - `points`: random states at which it is looked at; the median counts, as kinks give any rate.
    - `ratio`: of the fastest decay to the slowest motion; below, RK4 costs no more than a linearly
      implicit method where the slow motion is resolved. The three tanks have 17 to 35.
    - `dies`: time constants over a sample interval in which a mode counts as dying out; explicit
      steps of that length are stable up to 2.8.
    - `decay`: in time constants over a step or a sample interval, likewise; RK4 is stable up to
      2.8 a step.
    """

    points: int = 5
    ratio: float = 100.0
    decay: float = 10.0
    dies: float = 2.0


STIFF = StiffnessSettings()
ComplexArray = NDArray[np.complex128]

ROUNDING = 1e-9  # of the fastest mode: slower ones are constants of motion


def jacobians(model: Model, t: float, x: Array, u: Array, p: Array) -> Array:
    """Return df/dx (B, n, n) at time t (s), states x (n, B), inputs u (m,), parameters p (q, B)."""
    (n, count), inputs = x.shape, tuple(u)
    linear = linearisation(model.dynamics, n, len(inputs), len(p))
    with np.errstate(all='ignore'):
        found = linear.function(
            np.float64(t), 1.0, tuple(x), inputs, (0.0,) * len(inputs), tuple(p)
        )  # fmt: skip
    J = np.zeros((count, n, n))
    for (i, j), entry in zip(linear.places, found[n:], strict=False):
        J[:, i, j] = entry
    return J


def modes(model: Model, t: float, x: Array, u: Array, p: Array) -> ComplexArray:
    """Return the eigenvalues (n,) of df/dx in 1/s; none where derivatives are not finite.

    The model is linearised at time t (s), states x (n,), inputs u (m,) and parameters p (q,).
    """
    nothing = np.empty(0, complex)
    if not np.isfinite(x).all():
        return nothing
    found = poles(jacobians(model, t, x[:, None], u, p[:, None])[0])
    return found if np.isfinite(found).all() else nothing


def fastest_decay(modes: ComplexArray) -> float:
    """Return the rate in 1/s at which the fastest of some modes decays; 0 where none does."""
    return float((-modes.real).max(initial=0.0))


def shortest_time(modes: ComplexArray) -> float:
    """Return the time (s) that the fastest of some modes takes, to decay, grow or swing."""
    fastest = float(np.abs(modes).max(initial=0.0))
    return 1.0 / fastest if fastest > 0.0 else math.inf


def stiffness(modes: ComplexArray) -> float:
    """Return how many times faster the fastest mode decays than the slowest one moves."""
    speeds = np.abs(modes)
    moving = speeds[speeds > ROUNDING * speeds.max(initial=0.0)]
    return fastest_decay(modes) / float(moving.min()) if moving.size else 0.0


def may_be_stiff(model: Model, settings: StiffnessSettings = STIFF) -> bool:
    """Whether RK4 is likely to need many steps where the model's modes take one.

    Where the model has a longest step, that shows it; else the modes themselves, over random states
    within their bounds.
    """
    rng = np.random.default_rng(0)
    u, p = (np.array([inside(v) for v in group]) for group in (model.inputs, model.parameters))
    size = 5.0 * sizes(model)[0, : len(model.states)]
    middle = np.array([inside(v) for v in model.states])
    found = [
        modes(model, 0.0, middle + size * rng.uniform(-0.8, 0.8, middle.size), u, p)
        for _ in range(settings.points)
    ]
    if math.isfinite(model.max_step):
        decay = np.median([fastest_decay(each) for each in found])
        return bool(decay * model.max_step > settings.decay)
    return bool(np.median([stiffness(each) for each in found]) > settings.ratio)
