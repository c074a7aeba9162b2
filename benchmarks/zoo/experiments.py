"""Plants under poor and rich inputs: exact models, white noise, boxes as wide as a user's.

A poor input moves once in a window, late and little; a rich one often and far.
"""

import zlib
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from benchmarks.zoo.compartments import COMPARTMENTS
from benchmarks.zoo.dc_motor import DC_MOTOR
from benchmarks.zoo.heated_cells import HEATED_CELLS
from benchmarks.zoo.lag import LAG
from benchmarks.zoo.lotka_volterra import LOTKA_VOLTERRA
from benchmarks.zoo.monod import MONOD
from benchmarks.zoo.pendulum import PENDULUM
from benchmarks.zoo.quarter_car import QUARTER_CAR
from benchmarks.zoo.tank_chain import tank_chain
from benchmarks.zoo.van_der_pol import VAN_DER_POL
from obs_ros import Model, Record
from obs_ros.core.typing import Array
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid
from obs_ros.models.heat_exchanger import DIAPHRAGM_AREA, HEAT_EXCHANGER_REDUCED
from obs_ros.models.three_tank import THREE_TANK

FINER = 20  # steps of the true plant in one of the model
LATE = (0.55, 0.85)  # share of a window at which a poor input moves
OFTEN = 12  # moves of a rich input in a window

Draw = Callable[[np.random.Generator, Array, bool], tuple[Array, Array, Array]]


class Experiment(NamedTuple):
    """A plant and its windows of `samples`, `interval` s apart, with noise (r,) on its outputs.

    `draw(rng, t, rich)` returns initial state (n,), parameters (q,) and inputs (K, m) at times
    t (K,), which begin at 0 and may last for several windows.
    """

    model: Model
    samples: int
    interval: float
    noise: tuple[float, ...]
    draw: Draw

    def times(self, windows: int = 1) -> Array:
        """Return the sample times (K,) of so many windows, one after the other."""
        return np.asarray(self.interval * np.arange(self.samples * windows))


class Drawn(NamedTuple):
    """A run with its truth: record, parameters (q,), states (K, n)."""

    record: Record
    p: Array
    x: Array

    def window(self, first: int, samples: int) -> 'Drawn':
        """Return the window of so many samples from number `first` on."""
        part = slice(first, first + samples)
        record = Record(self.record.t[part], self.record.u[part], self.record.y[part])
        return Drawn(record, self.p, self.x[part])


def run(experiment: Experiment, seed: int, rich: bool, windows: int = 1) -> Drawn:
    """Return the run of that seed, of so many windows that abut."""
    # Plants and inputs have noise of their own: their windows are counted together.
    stream = zlib.crc32(f'{experiment.model.name} {rich}'.encode())
    rng = np.random.default_rng([seed, stream, windows])
    t = experiment.times(windows)
    x0, p, u = experiment.draw(rng, t, rich)
    x, y = trajectory(experiment.model, t, u, x0, p)
    y = y + np.array(experiment.noise) * rng.standard_normal(y.shape)
    return Drawn(Record(t, u, y), p, x)


def trajectory(model: Model, t: Array, u: Array, x0: Array, p: Array) -> tuple[Array, Array]:
    """Return true states (K, n) and outputs (K, r) at t (K,), by steps much finer than a model's.

    A test holds them against an integrator of eighth order.
    """
    fine = replace(model, max_step=min(model.max_step, float(np.diff(t).min())) / FINER)
    outputs = len(model.outputs)
    grid = Grid.of(fine, Record(t, u, np.zeros((t.size, outputs))), np.ones(outputs))
    x, y = kernels_for(fine).trajectories(grid, x0[:, None], p[:, None])
    return x[..., 0], y[..., 0]


def moves(
    rng: np.random.Generator, t: Array, window: float, rich: bool,
    between: tuple[float, float], rest: float, least: float,
) -> Array:  # fmt: skip
    """Return an input (K,) that is held in between, at times t (K,) of windows of `window` s.

    A rich one is uniform `between` two levels after each move; a poor one goes back and forth
    between `rest` and `rest + least`.
    """
    if rich:
        place = (t / window * OFTEN + rng.uniform()).astype(int)
        return np.asarray(rng.uniform(*between, place[-1] + 1)[place])
    windows = round(float(t[-1]) / window) + 1
    at = window * (np.arange(windows) + rng.uniform(*LATE, windows))
    return np.asarray(rest + least * (np.searchsorted(at, t, side='right') % 2))


def cells(rng: np.random.Generator, t: Array, rich: bool) -> tuple[Array, Array, Array]:
    """Heaters of some W; a poor window is nearly at rest."""
    p = rng.uniform((0.4, 0.4, 0.4, 0.05, 20.0, 20.0), (1.5, 1.5, 1.5, 0.2, 60.0, 60.0))
    spread = 15.0 if rich else 0.5
    x0 = rng.uniform(22.0, 30.0) + rng.uniform(0.0, spread, 6)
    first = moves(rng, t, 300.0, rich, (0.0, 14.0), 1.0, 1.0)
    fourth = moves(rng, t, 300.0, rich, (0.0, 14.0), 0.5, 0.0)
    return x0, p, np.column_stack([first, fourth])


def reactor(rng: np.random.Generator, t: Array, rich: bool) -> tuple[Array, Array, Array]:
    """Dilution below wash-out."""
    p = rng.uniform((0.3, 0.1, 0.3), (0.7, 1.0, 0.6))
    u = moves(rng, t, 20.0, rich, (0.0, 0.5), 0.12, 0.06)
    x0 = rng.uniform((1.0, 0.5), (3.0, 4.0)) if rich else rng.uniform((2.0, 0.1), (4.0, 1.0))
    return x0, p, u[:, None]


def drug(rng: np.random.Generator, t: Array, rich: bool) -> tuple[Array, Array, Array]:
    """Infusions of some mg/h."""
    p = rng.uniform((0.2, 0.4, 0.4, 0.1, 0.03), (0.6, 1.2, 1.2, 0.3, 0.08))
    u = moves(rng, t, 60.0, rich, (0.0, 6.0), 0.3, 0.2)
    rest = u[0] / p[0] * np.array([1.0, p[1] / p[2], p[3] / p[4]])
    x0 = rng.uniform(0.0, 3.0, 3) if rich else rest * rng.uniform(0.95, 1.05, 3)
    return x0, p, u[:, None]


def motor(rng: np.random.Generator, t: Array, rich: bool) -> tuple[Array, Array, Array]:
    """Voltages to both sides; a poor window runs at some speed."""
    p = rng.uniform((0.6, 15.0, 0.06, 1.0, 0.3), (2.0, 50.0, 0.2, 4.0, 2.0))
    u = moves(rng, t, 1.0, rich, (-12.0, 12.0), 6.0, 0.3)
    current = u[0, None] / (p[0] + 1e3 * p[2] ** 2 / p[4])
    rest = np.append(current, 1e3 * p[2] * current / p[4])
    x0 = rest * rng.uniform(*((0.2, 1.0) if rich else (0.97, 1.03)), 2)
    return x0, p, u[:, None]


def oscillator(rng: np.random.Generator, t: Array, rich: bool) -> tuple[Array, Array, Array]:
    """Forces; a poor window begins with a small swing."""
    p = rng.uniform((0.2, 0.5, 0.3), (1.0, 2.0, 1.5))
    u = moves(rng, t, 15.0, rich, (-1.5, 1.5), 0.0, 0.1)
    return rng.uniform(-1.0, 1.0, 2) * (1.5 if rich else 0.3), p, u[:, None]


def tanks(rng: np.random.Generator, t: Array, rich: bool) -> tuple[Array, Array, Array]:
    """Feeds of two pumps."""
    u = [moves(rng, t, 300.0, rich, (5.0, 40.0), rest, least) for rest, least in ((20, 2), (25, 0))]
    x0 = rng.uniform(20.0, 60.0, 3) if rich else rng.uniform(30.0, 40.0) + rng.uniform(-1, 1, 3)
    return x0, rng.uniform(0.4, 0.95, 3), np.column_stack(u)


def lag(rng: np.random.Generator, t: Array, rich: bool) -> tuple[Array, Array, Array]:
    """Voltages to both sides."""
    u = moves(rng, t, 30.0, rich, (-1.0, 1.0), 0.5, 0.05)
    p = rng.uniform((0.5, 1.5), (2.0, 8.0))
    x0 = rng.uniform(-1.0, 1.0, 1) if rich else p[:1] * rng.uniform(0.47, 0.53)
    return x0, p, u[:, None]


def exchanger(rng: np.random.Generator, t: Array, rich: bool) -> tuple[Array, Array, Array]:
    """Pressures in the chambers of two valves."""
    p = rng.uniform((3e5, 3e4, 4500.0, 4500.0), (8e5, 8e4, 8000.0, 8000.0))
    u = np.column_stack([
        moves(rng, t, 30.0, rich, (0.6e6, 1.6e6), 1.0e6, 5e4),
        moves(rng, t, 30.0, rich, (0.6e6, 1.6e6), 1.2e6, 5e4),
    ])  # fmt: skip
    spread = 0.3 if rich else 0.03
    openings = DIAPHRAGM_AREA * u[0] / p[2:] * rng.uniform(1.0 - spread, 1.0 + spread, 2)
    return np.array([*rng.uniform(30.0, 40.0, 2), *openings]), p, u


def chain(rng: np.random.Generator, t: Array, rich: bool) -> tuple[Array, Array, Array]:
    """Feeds of the first of four tanks."""
    u = moves(rng, t, 300.0, rich, (8.0, 35.0), 15.0, 2.0)
    first = rng.uniform(30.0, 40.0)
    x0 = rng.uniform(15.0, 50.0, 4) if rich else first - np.arange(4.0) + rng.uniform(-0.5, 0.5, 4)
    return x0, rng.uniform(0.4, 0.9, 4), u[:, None]


def prey(rng: np.random.Generator, t: Array, rich: bool) -> tuple[Array, Array, Array]:
    """No input; a poor window stays near the equilibrium."""
    birth, growth, death = p = rng.uniform(0.6, 1.4, 3)
    rest = np.array([death / growth, birth])
    spread = (0.5, 1.6) if rich else (0.92, 1.08)
    return rest * rng.uniform(*spread, 2), p, np.empty((t.size, 0))


def car(rng: np.random.Generator, t: Array, rich: bool) -> tuple[Array, Array, Array]:
    """Speeds of the road."""
    p = rng.uniform((10.0, 0.6, 120.0), (25.0, 1.8, 220.0))
    u = moves(rng, t, 2.0, rich, (-0.2, 0.2), 0.0, 0.02)
    size = np.array([0.02, 0.1, 0.005, 0.2]) * (1.0 if rich else 0.03)
    return rng.uniform(-1.0, 1.0, 4) * size, p, u[:, None]


def swing(rng: np.random.Generator, t: Array, rich: bool) -> tuple[Array, Array, Array]:
    """Torques; a poor window hangs nearly still."""
    p = rng.uniform((5.0, 0.1, 0.5), (14.0, 0.5, 2.0))
    u = moves(rng, t, 9.0, rich, (-0.8, 0.8), 0.0, 0.05)
    return rng.uniform(-1.0, 1.0, 2) * (0.5 if rich else 0.02), p, u[:, None]


HELD_EXCHANGER, HELD_CAR, HELD_PENDULUM = (
    replace(model, inputs=[replace(v, interpolation='hold') for v in model.inputs])
    for model in (HEAT_EXCHANGER_REDUCED, QUARTER_CAR, PENDULUM)
)
EXPERIMENTS = {
    'cells': Experiment(HEATED_CELLS, 300, 1.0, (0.1,) * 3, cells),
    'Monod': Experiment(MONOD, 200, 0.1, (0.05,), reactor),
    'compartments': Experiment(COMPARTMENTS, 300, 0.2, (0.02,), drug),
    'motor': Experiment(DC_MOTOR, 400, 0.0025, (0.05, 0.5), motor),
    'van der Pol': Experiment(VAN_DER_POL, 300, 0.05, (0.05,), oscillator),
    'tanks': Experiment(THREE_TANK, 300, 1.0, (0.1, 0.1), tanks),
    'lag': Experiment(LAG, 300, 0.1, (0.02,), lag),
    'exchanger': Experiment(HELD_EXCHANGER, 300, 0.1, (0.05, 0.05), exchanger),
    'chain': Experiment(tank_chain(4), 300, 1.0, (0.1, 0.1), chain),
    'Lotka-Volterra': Experiment(LOTKA_VOLTERRA, 300, 0.05, (0.02,), prey),
    'quarter car': Experiment(HELD_CAR, 400, 0.005, (5e-4, 0.1), car),
    'pendulum': Experiment(HELD_PENDULUM, 300, 0.03, (0.01,), swing),
}
