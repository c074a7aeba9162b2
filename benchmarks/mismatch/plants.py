"""Two tanks, one above the other, that overflow, and models that know nothing of it.

After the cascaded tanks of Schoukens, Mattsson, Wigren & Noël 2016: a pump fills the upper tank,
which runs out into the lower one. Both levels are measured, in volts: of the lower one alone, two
tanks that change places are told apart by little. The excess above TOP is lost.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from obs_ros import Model, Record, Variable
from obs_ros.core.typing import Array

INTERVAL = 4.0  # s, from sample to sample
STEP = 0.5  # s, of the simulated plant
NOISE = 0.02  # V
TOP = 10.0  # V
LEAST_PUMP = 1.0  # V, of the voltages drawn
HELD = (5, 40)  # samples that a voltage stays
OUTLETS = (0.04, 0.06)  # root of V per s, of k1 and k3


class Flood(NamedTuple):
    """How much the upper tank overflows: most voltage (V), range of k4 / k1 in 1 / root of V."""

    most: float
    fill: tuple[float, float]


FLOODS = {'some': Flood(5.0, (0.7, 0.8)), 'much': Flood(6.0, (0.75, 0.85))}


def pump_dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any]:
    """Return the rates of the levels, with the outlets' and the pump's constants."""
    k1, k3, k4 = p
    out = k1 * np.sqrt(np.maximum(x[0], 0.0))
    return k4 * u[0] - out, out - k3 * np.sqrt(np.maximum(x[1], 0.0))


def full_dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any]:
    """Return the rates of the levels, with tanks of two areas and a pump's dead voltage."""
    k1, k2, k3, k4, dead, _ = p
    root = np.sqrt(np.maximum(x[0], 0.0))
    return k4 * (u[0] - dead) - k1 * root, k2 * root - k3 * np.sqrt(np.maximum(x[1], 0.0))


def levels(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any]:
    """Return both levels."""
    return x[0], x[1]


def shifted_levels(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any]:
    """Return both levels, the lower one with its sensor's offset."""
    return x[0], x[1] + p[5]


def constant(name: str) -> Variable:
    """Return a constant of an outlet or of the pump."""
    return Variable(name, 'root of V/s' if name != 'k4' else '1/s', lower=0.005, upper=0.3)


LEVELS = tuple(Variable(name, 'V', lower=0.0, upper=20.0) for name in ('x1', 'x2'))
TANKS = Model(
    name='two_tanks',
    states=LEVELS,
    inputs=(Variable('pump', 'V'),),
    outputs=(Variable('y1', 'V'), Variable('y2', 'V')),
    parameters=tuple(constant(name) for name in ('k1', 'k3', 'k4')),
    dynamics=pump_dynamics,
    output=levels,
    max_step=INTERVAL,
)
# Eight unknowns.
FULL_TANKS = Model(
    name='two_tanks_full',
    states=LEVELS,
    inputs=(Variable('pump', 'V'),),
    outputs=(Variable('y1', 'V'), Variable('y2', 'V')),
    parameters=(
        *(constant(name) for name in ('k1', 'k2', 'k3', 'k4')),
        Variable('dead', 'V', lower=-1.0, upper=1.0),
        Variable('offset', 'V', lower=-1.0, upper=1.0),
    ),
    dynamics=full_dynamics,
    output=shifted_levels,
    max_step=INTERVAL,
)


def overflowing(
    seed: int, samples: int, top: float = TOP, flood: str = 'some'
) -> tuple[Record, Array]:
    """Return a record of the tanks, with fresh constants (3,), and these."""
    rng = np.random.default_rng([seed, samples])
    k1, k3 = rng.uniform(*OUTLETS, 2).tolist()
    most, fill = FLOODS[flood]
    k4 = k1 * rng.uniform(*fill)
    lengths = rng.integers(*HELD, samples)
    u = np.repeat(rng.uniform(LEAST_PUMP, most, samples), lengths)[:samples]
    level, below = np.minimum(rng.uniform(1.0, 0.8 * TOP, 2), top).tolist()
    y = np.empty((samples, 2))
    for k in range(samples):
        y[k] = level, below
        for _ in range(round(INTERVAL / STEP)):  # by the midpoint rule
            out, drain = k1 * math.sqrt(level), k3 * math.sqrt(below)
            middle = max(level + 0.5 * STEP * (k4 * u[k] - out), 0.0)
            lower = max(below + 0.5 * STEP * (out - drain), 0.0)
            out, drain = k1 * math.sqrt(middle), k3 * math.sqrt(lower)
            level = min(max(level + STEP * (k4 * u[k] - out), 0.0), top)
            below = min(max(below + STEP * (out - drain), 0.0), top)
    t = INTERVAL * np.arange(samples)
    return Record(t, u[:, None], y + NOISE * rng.standard_normal(y.shape)), np.array([k1, k3, k4])
