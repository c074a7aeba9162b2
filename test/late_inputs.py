"""Plants on which an input acts late that does not act linearly, or is measured at once."""

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from obs_ros import Model, Record, Variable
from obs_ros.core.typing import Array

INTERVAL = 0.05
TRUTH = (5.0, 0.6)


def valve_dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any]:
    """A vessel filled through a valve that lets nothing be negative."""
    return ((p[0] * np.sqrt(u[0]) - x[0]) / p[1],)


def drag_dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any]:
    return (p[0] * u[0] - p[1] * x[0],)


def plant(dynamics: Callable[..., Any], output: Callable[..., Any], outputs: int) -> Model:
    return Model(
        name='late_input',
        states=(Variable('x', lower=-50.0, upper=50.0),),
        inputs=(Variable('u', delay=(0.0, 8.0 * INTERVAL)),),
        outputs=tuple(Variable(f'y{i}') for i in range(outputs)),
        parameters=(Variable('k', lower=0.1, upper=20.0), Variable('c', lower=0.1, upper=5.0)),
        dynamics=dynamics,
        output=output,
        max_step=INTERVAL,
    )


VALVE = plant(valve_dynamics, lambda t, x, u, p: (x[0],), 1)
# A cart with an accelerometer: the force is measured as soon as it acts.
CART = plant(
    drag_dynamics, lambda t, x, u, p: (p[0] * u[0] - p[1] * x[0], x[0]), 2
)  # fmt: skip


def steps_of_input(rng: np.random.Generator, count: int) -> Array:
    """Levels of the input, each held for 2 to 8 samples, a third of them zero."""
    levels = rng.uniform(-0.5, 1.0, count).clip(0.0)
    return np.repeat(levels, rng.integers(2, 9, count))[:count]


def exact(model: Model, t: Array, u: Array, delay: float, x0: float = 1.0) -> Array:
    """Outputs (K, r) at times t (K,) under inputs (K,) that act late, integrated from leap to leap.

    A leap at the very time of a sample shows in it.
    """
    acts, x = t + delay, np.array([x0])
    cuts, y = np.unique(np.concatenate([t, acts[(acts > t[0]) & (acts < t[-1])]])), []
    for begin, end in zip(cuts, np.append(cuts[1:], np.inf), strict=True):
        now = u[max(int(np.searchsorted(acts, begin + 1e-9, side='right')) - 1, 0)]
        if begin in t:
            y.append(model.output(begin, tuple(x), (now,), TRUTH))
        if end - begin > 1e-9 and np.isfinite(end):
            x = _integrated(model, x, now, begin, end)
    return np.array(y)


def _integrated(model: Model, x: Array, u: float, begin: float, end: float) -> Array:
    def rates(t: float, x: Array) -> Any:
        return model.dynamics(t, x, (u,), TRUTH)

    found = solve_ivp(rates, (begin, end), x, rtol=1e-10, atol=1e-12)
    return np.asarray(found.y[:, -1])


def measured(model: Model, intervals: float, seed: int, samples: int = 250) -> tuple[Record, Array]:
    """A window at 40 dB, whose input is known for ten samples before it, and the noise."""
    rng = np.random.default_rng(seed)
    t = INTERVAL * np.arange(-10, samples)
    u = steps_of_input(rng, t.size)
    y = exact(model, t, u, intervals * INTERVAL)
    sigma = 0.01 * y.std(axis=0)
    y += sigma * rng.standard_normal(y.shape)
    y[:10] = np.nan
    return Record(t, u, y), sigma
