"""Plants whose states are pushed about, and the windows that are drawn of them."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from benchmarks.zoo.lag import LAG
from benchmarks.zoo.output import first_state
from obs_ros import Model, Variable
from obs_ros.core.typing import Array
from obs_ros.models.heat_exchanger import DIAPHRAGM_AREA, HEAT_EXCHANGER_REDUCED
from obs_ros.models.suspension import KT, SUSPENSION
from obs_ros.models.three_tank import THREE_TANK


def spring_dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any]:
    """Return the rates of a mass of 1 kg on a spring, pulled by a force."""
    return x[1], u[0] - p[0] * x[0] - p[1] * x[1]


SPRING = Model(
    name='pushed_spring',
    states=(
        Variable('x', 'm', lower=-5.0, upper=5.0),
        Variable('v', 'm/s', lower=-10.0, upper=10.0),
    ),
    inputs=(Variable('force', 'N'),),
    outputs=(Variable('y', 'm'),),
    parameters=(
        Variable('k', 'N/m', lower=0.5, upper=8.0),
        Variable('d', 'Ns/m', lower=0.05, upper=2.0),
    ),
    dynamics=spring_dynamics,
    output=first_state,
    max_step=0.02,
)

Draw = Callable[[np.random.Generator, Array], tuple[Array, Array, Array]]


class Plant(NamedTuple):
    """A plant to simulate: samples, s between them, noise (r,), which states walk.

    `draw` returns initial states (n,), parameters (q,) and inputs (K, m); parameters `fixed` are
    given, the others estimated. The walks `told` are of states that are measured or one integration
    away from an output.
    """

    model: Model
    samples: int
    interval: float
    noise: tuple[float, ...]
    walking: tuple[int, ...]
    told: tuple[int, ...]
    draw: Draw
    fixed: Mapping[str, float] = {}

    @property
    def estimated(self) -> list[int]:
        """Places of the parameters that are estimated."""
        return [i for i, v in enumerate(self.model.parameters) if v.name not in self.fixed]


def spring_window(rng: np.random.Generator, t: Array) -> tuple[Array, Array, Array]:
    """Return initial state, parameters and inputs (K, 1) of a spring."""
    p = np.array([rng.uniform(2.0, 5.0), rng.uniform(0.2, 0.8)])
    turns = t / rng.uniform(2.0, 4.0) + rng.uniform(0.0, 1.0)
    return rng.uniform(-0.5, 0.5, 2), p, np.sign(np.sin(2.0 * np.pi * turns))[:, None]


def tanks_window(rng: np.random.Generator, t: Array) -> tuple[Array, Array, Array]:
    """Return initial levels, valve openings and inflows (K, 2) of three tanks."""
    levels = np.sort(rng.uniform((10.0, 20.0, 30.0), (25.0, 45.0, 60.0)))[[2, 0, 1]]
    high = (t // 60.0 + rng.integers(2)) % 2 == 0
    flows = np.column_stack([np.where(high, 20.0, 45.0), np.where(high, 45.0, 20.0)])
    return levels, rng.uniform(0.3, 0.9, 3), flows


def lag_window(rng: np.random.Generator, t: Array) -> tuple[Array, Array, Array]:
    """Return initial state, parameters and inputs (K, 1) of a lag: levels held for 5 s."""
    p = np.array([rng.uniform(0.5, 2.0), rng.uniform(2.0, 6.0)])
    levels = rng.uniform(0.5, 1.5, t.size) * (1.0 - 2.0 * (np.arange(t.size) % 2))
    return rng.uniform(-1.0, 1.0, 1), p, levels[(t // 5.0).astype(int)][:, None]


def suspension_window(rng: np.random.Generator, t: Array) -> tuple[Array, Array, Array]:
    """Return initial state, tyre and load, road and current (K, 2) of a quarter car."""
    p = np.array([rng.uniform(0.5, 1.5) * KT, rng.uniform(-500.0, 500.0)])
    pitches = 2.0 * np.pi * rng.uniform((1.0, 3.0, 8.0), (3.0, 8.0, 14.0))
    waves = np.sin(pitches * t[:, None] + rng.uniform(0.0, 2.0 * np.pi, 3))
    road = waves @ np.array([0.01, 0.005, 0.003])
    current = np.where((t // 0.4 + rng.integers(2)) % 2 == 0, 0.5, 2.0)
    x0 = rng.uniform(-1.0, 1.0, 4) * (0.01, 0.1, 0.01, 0.1)
    return x0, p, np.column_stack([road, current])


def exchanger_window(rng: np.random.Generator, t: Array) -> tuple[Array, Array, Array]:
    """Return temperatures and openings, pressures and springs, chamber pressures (K, 2)."""
    springs = rng.uniform(4500.0, 8000.0, 2)
    held = (t // 4.0).astype(int)
    pressures = rng.uniform((0.6e6, 0.7e6), (1.4e6, 1.7e6), (held[-1] + 1, 2))[held]
    openings = DIAPHRAGM_AREA * pressures[0] / springs * rng.uniform(0.7, 1.3, 2)
    p = np.array([EXCHANGER_FIXED['dP1'], EXCHANGER_FIXED['dP2'], *springs])
    return np.array([*rng.uniform(30.0, 40.0, 2), *openings]), p, pressures


# The simulation holds its inputs.
HELD_EXCHANGER = replace(
    HEAT_EXCHANGER_REDUCED,
    inputs=[replace(v, interpolation='hold') for v in HEAT_EXCHANGER_REDUCED.inputs],
)
EXCHANGER_FIXED = {'dP1': 6.0e5, 'dP2': 6.0e4}

PLANTS = {
    'spring': Plant(SPRING, 500, 0.02, (0.01,), (1,), (1,), spring_window),
    'tanks': Plant(
        THREE_TANK, 500, 1.0, (0.1, 0.1), (0, 1, 2), (0, 1), tanks_window
    ),
    'lag': Plant(LAG, 500, 0.1, (0.02,), (0,), (0,), lag_window),
    'suspension': Plant(
        replace(SUSPENSION, max_step=0.0025), 400, 0.005, (5e-4,) * 3, (1, 3), (1, 3),
        suspension_window,
    ),
    'exchanger': Plant(
        HELD_EXCHANGER, 400, 0.1, (0.05, 0.05), (0, 1), (0, 1),
        exchanger_window, EXCHANGER_FIXED,
    ),
}  # fmt: skip
# Per root of a second.
WALKS = {
    'spring': (0.0, 0.1, 0.3),
    'tanks': (0.0, 0.05, 0.2),
    'lag': (0.0, 0.02, 0.1),
    'suspension': (0.0, 0.02, 0.1),
    'exchanger': (0.0, 0.02, 0.1),
}
