"""The kinds of windows: a plant, how long it is watched, and how its truth is drawn."""

import functools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from benchmarks.zoo.duffing import DOUBLE_WELL, DUFFING, PERIOD
from benchmarks.zoo.glycolysis import GLYCOLYSIS
from benchmarks.zoo.jet import JET
from benchmarks.zoo.lorenz63 import LORENZ63
from benchmarks.zoo.lotka_volterra import LOTKA_VOLTERRA
from benchmarks.zoo.networks import STEP, masses, rooms
from benchmarks.zoo.pendulum import PENDULUM
from benchmarks.zoo.quarter_car import QUARTER_CAR
from benchmarks.zoo.tank_chain import tank_chain
from obs_ros import Model, load_model
from obs_ros.core.typing import Array

Inputs = Callable[[np.random.Generator, Array], Array]
THREE_TANK = load_model('three_tank')


@dataclass(frozen=True)
class Case:
    """Windows of `samples` samples, `period` s apart, with noise at `snr_db`.

    The truth is uniform in the `inner` part of every unknown's box, and has run for `settle` s
    before the window starts. `inputs` returns u (K, m) at times t (K,). `unit_power`: the noise is
    counted against one unit of the output instead of the output's own standard deviation.
    """

    name: str
    model: Model
    samples: int
    period: float
    snr_db: float
    inner: tuple[float, float] = (0.2, 0.8)
    settle: float = 0.0
    inputs: Inputs = lambda rng, t: np.empty((t.size, 0))
    unit_power: bool = False


def steady(*values: float) -> Inputs:
    """Inputs that stay as they are."""
    return lambda rng, t: np.tile(values, (t.size, 1))


def wander(deviation: float, time_constant: float) -> Inputs:
    """One input that wanders about zero: first-order filtered white noise."""

    def inputs(rng: np.random.Generator, t: Array) -> Array:
        share = np.exp(-(t[1] - t[0]) / time_constant)
        pushes = rng.standard_normal(t.size) * deviation * np.sqrt(1.0 - share**2)
        u = np.empty(t.size)
        u[0] = deviation * rng.standard_normal()
        for k in range(1, t.size):
            u[k] = share * u[k - 1] + pushes[k]
        return u[:, None]

    return inputs


def cosines(rng: np.random.Generator, t: Array) -> Array:
    """Return the feed of Porter & Passino's glycolytic oscillator (K, 1)."""
    return (0.999 + 0.42 * np.cos(1.75 * t) + 0.32 * np.cos(4.5 * t))[:, None]


def tanks(name: str, samples: int, snr_db: float) -> Case:
    """Three tanks, sampled every second."""
    return Case(name, THREE_TANK, samples, 1.0, snr_db, inputs=steady(30.0, 30.0), unit_power=True)


@functools.cache
def chain(n: int) -> Case:
    """Tanks in a row, sampled every second."""
    model = tank_chain(n)
    return Case(f'chain of {n}', model, 1000, 1.0, 20.0, inputs=steady(30.0), unit_power=True)


def lorenz(units: int) -> Case:
    """Lorenz's convection for so many time units, on its attractor."""
    return Case(
        f'Lorenz {units}', LORENZ63, 100 * units, 0.01, 40.0, inner=(0.3, 0.7), settle=10.0
    )  # fmt: skip


def duffing(periods: int) -> Case:
    """The Duffing oscillator for so many periods of its force."""
    return Case(f'Duffing {periods}', DUFFING, 1000, periods * PERIOD / 1000, 40.0)


CASES = {
    case.name: case
    for case in (
        tanks('three tanks 1000, 40 dB', 1000, 40.0),
        tanks('three tanks 1000, 20 dB', 1000, 20.0),
        tanks('three tanks 1000, 0 dB', 1000, 0.0),
        tanks('three tanks 50, 20 dB', 50, 20.0),
        duffing(30),
        duffing(80),
        duffing(200),
        Case('double well 30', DOUBLE_WELL, 1000, 30 * PERIOD / 1000, 40.0),
        lorenz(2),
        lorenz(5),
        lorenz(10),
        chain(4),
        chain(8),
        Case('glycolysis', GLYCOLYSIS, 1000, 0.02, 40.0, inputs=cosines),
        # The throttle wanders about 1.4, where the compressor is stable.
        Case('jet', JET, 1000, 0.02, 20.0, inputs=lambda rng, t: 1.4 + wander(0.3, 2.0)(rng, t)),
        Case('Lotka-Volterra', LOTKA_VOLTERRA, 1000, 0.03, 40.0),
        Case('pendulum', PENDULUM, 300, 0.04, 40.0, inputs=wander(1.0, 0.5)),
        # Pushed over the top now and then, where a hair decides to which side it falls.
        Case('tumbling pendulum', PENDULUM, 500, 0.04, 40.0, inputs=wander(3.0, 0.5)),
        Case('quarter car', QUARTER_CAR, 1000, 0.005, 40.0, inputs=wander(0.3, 0.02)),
    )
}


def pushed(unknowns: int) -> Case:
    """Masses in a row, of so many unknowns, for 10 s."""
    return Case(
        f'masses, {unknowns} unknowns', masses(unknowns // 4), 500, STEP, 40.0, NEAR_MIDDLE,
        inputs=wander(10.0, 0.2), unit_power=True,
    )  # fmt: skip


def heated(unknowns: int) -> Case:
    """Rooms in a row, of so many unknowns, for 500 s."""

    def inputs(rng: np.random.Generator, t: Array) -> Array:
        return 1.0 + np.hstack([wander(0.5, 20.0)(rng, t) for _ in range(2)])

    return Case(
        f'rooms, {unknowns} unknowns', rooms(unknowns // 2), 500, 1.0, 20.0, NEAR_MIDDLE,
        inputs=inputs, unit_power=True,
    )  # fmt: skip


# Nothing leaves its bounds within the window.
NEAR_MIDDLE = (0.35, 0.65)
MANY_UNKNOWNS = {
    case.name: case for count in (20, 40, 60) for case in (pushed(count), heated(count))
}
