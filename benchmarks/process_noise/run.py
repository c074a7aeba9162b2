"""Windows of plants whose states are pushed about: simulated, and solved with and without walks."""

import time
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from obs_ros import Model, Record, Variable, load_model, solve_window
from obs_ros.core.typing import Array

STEPS = 10  # of the simulation, from sample to sample


def spring_dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any]:
    """Return the rates of a mass of 1 kg on a spring, pulled by a force."""
    return x[1], u[0] - p[0] * x[0] - p[1] * x[1]


def spring_output(t: Any, x: Any, u: Any, p: Any) -> tuple[Any]:
    """Return the position."""
    return (x[0],)


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
    output=spring_output,
    max_step=0.02,
)


class Plant(NamedTuple):
    """A plant to simulate: samples, s between them, noise, which states walk, draws of a window."""

    model: Model
    samples: int
    interval: float
    noise: float
    walking: tuple[int, ...]
    draw: Callable[[np.random.Generator, Array], tuple[Array, Array, Array]]


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


PLANTS = {
    'spring': Plant(SPRING, 500, 0.02, 0.01, (1,), spring_window),
    'tanks': Plant(load_model('three_tank'), 500, 1.0, 0.1, (0, 1, 2), tanks_window),
}
WALKS = {'spring': (0.0, 0.1, 0.3), 'tanks': (0.0, 0.05, 0.2)}  # per root of a second


def simulated(plant: Plant, walk: float, seed: int) -> tuple[Record, Array, Array]:
    """Return a window's record, its parameters (q,) and its state at the end (n,)."""
    rng = np.random.default_rng([seed, plant.samples])
    t = plant.interval * np.arange(plant.samples)
    x, p, u = plant.draw(rng, t)
    h, push = plant.interval / STEPS, np.zeros(x.size)
    push[list(plant.walking)] = walk
    f = plant.model.dynamics
    outputs = []
    for k in range(plant.samples):
        outputs.append(plant.model.output(t[k], x, u[k], p))
        for _ in range(STEPS if k < plant.samples - 1 else 0):
            k1 = np.array(f(t[k], x, u[k], p))
            k2 = np.array(f(t[k], x + 0.5 * h * k1, u[k], p))
            k3 = np.array(f(t[k], x + 0.5 * h * k2, u[k], p))
            k4 = np.array(f(t[k], x + h * k3, u[k], p))
            x = x + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
            x = x + push * np.sqrt(h) * rng.standard_normal(x.size)
    y = np.array(outputs)
    return Record(t, u, y + plant.noise * rng.standard_normal(y.shape)), p, x


class Solved(NamedTuple):
    """Errors and deviations of parameters (q,) and end state (n,), outcome, process time (s)."""

    error: Array
    sd: Array
    end_error: Array
    end_sd: Array
    outcome: str
    seconds: float


def solved(name: str, walk: float, mode: Any, seed: int) -> Solved:
    """Solve one window, with its process noise `off` or `auto`."""
    plant = PLANTS[name]
    record, p, x = simulated(plant, walk, seed)
    begin = time.process_time()
    found = solve_window(plant.model, record, seed=seed, process_noise=mode)
    seconds = time.process_time() - begin
    states, parameters = ([v.name for v in g] for g in (plant.model.states, plant.model.parameters))
    return Solved(
        error=np.array([found.parameters[v] for v in parameters]) - p,
        sd=np.array([found.stddev[v] for v in parameters]),
        end_error=np.array([found.state[v] for v in states]) - x,
        end_sd=np.array([found.stddev[v] for v in states]),
        outcome=found.outcome.value,
        seconds=seconds,
    )
