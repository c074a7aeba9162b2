"""Recorded plants and their windows; models as a user writes them first, forecasts.

Bounds cut no optimum off, but for the ball's friction, which cannot be negative.
"""

import functools
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benchmarks.runner import ROOT
from obs_ros import Estimate, Model, Record, Variable
from obs_ros.core.typing import Array
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid

FOLDER = ROOT.parent / 'shared' / 'data'  # where recordings are sought, beside the repository
OVERLAP = 4  # windows begin in one window's length

AMBIENT, HEAT_CAPACITY, RADIATION = 23.0, 2.0, 0.9 * 5.67e-8 * 1e-3  # degC, J/K, W/K^4
MASS, INERTIA, FRONT, REAR, GRAVITY = 21.76, 1.124, 0.34, 0.23, 9.81  # kg, kg m2, m, m, m/s2


def beam_dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any]:
    """Return the rates of a ball that rolls on a beam."""
    return x[1], p[0] * np.sin(u[0]) - p[1] * x[1] + p[2]


def board_dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any, Any, Any]:
    """Return the rates of two bodies, the first one heated, and of their sensors."""
    t1, t2, s1, s2 = x
    loss, exchange, heater, lag = p
    air = AMBIENT + 273.15
    flow = exchange * (t2 - t1)
    out1 = loss * (AMBIENT - t1) + RADIATION * (air**4 - (t1 + 273.15) ** 4)
    out2 = loss * (AMBIENT - t2) + RADIATION * (air**4 - (t2 + 273.15) ** 4)
    return (
        (heater * u[0] + out1 + flow) / HEAT_CAPACITY,
        (out2 - flow) / HEAT_CAPACITY,
        (t1 - s1) / lag,
        (t2 - s2) / lag,
    )


def cell_dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any]:
    """Return the rates of the open-circuit voltage and of the voltage over one RC pair."""
    return -u[0] / (3600.0 * p[0]), (1e-3 * p[2] * u[0] - x[1]) / p[3]


def cell_output(t: Any, x: Any, u: Any, p: Any) -> tuple[Any]:
    """Return the terminal voltage."""
    return (x[0] - 1e-3 * p[1] * u[0] - x[1],)


def car_dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any]:
    """Return the rates of a single-track model with saturating tyres."""
    vy, rate = x
    steer, vx = u
    front, rear, mu, offset = p
    most_front = mu * MASS * GRAVITY * REAR / (FRONT + REAR)
    most_rear = mu * MASS * GRAVITY * FRONT / (FRONT + REAR)
    slip_front = steer + offset - (vy + FRONT * rate) / vx
    slip_rear = -(vy - REAR * rate) / vx
    force_front = most_front * np.tanh(100.0 * front * slip_front / most_front)
    force_rear = most_rear * np.tanh(100.0 * rear * slip_rear / most_rear)
    return (
        (force_front + force_rear) / MASS - vx * rate,
        (FRONT * force_front - REAR * force_rear) / INERTIA,
    )


def first(t: Any, x: Any, u: Any, p: Any) -> tuple[Any]:
    """Return the first state."""
    return (x[0],)


def sensors(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any]:
    """Return what the board's sensors show."""
    return x[2], x[3]


def both(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any]:
    """Return both states."""
    return x[0], x[1]


class Plant(NamedTuple):
    """A recorded plant: file, model, columns of inputs and outputs, window and sample in s."""

    file: str
    model: Model
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    window: float
    interval: float | None = None  # where the recording has no column of times


BALL = Model(
    name='recorded_ball',
    states=(Variable('r', 'm', lower=-1.0, upper=1.0), Variable('v', 'm/s', lower=-2.0, upper=2.0)),
    inputs=(Variable('u', 'rad', interpolation='linear'),),
    outputs=(Variable('y', 'm'),),
    parameters=(
        Variable('a', 'm/s2', lower=0.0, upper=15.0),
        Variable('b', '1/s', lower=0.0, upper=5.0, physical='lower'),
        Variable('c', 'm/s2', lower=-1.0, upper=1.0),
    ),
    dynamics=beam_dynamics,
    output=first,
    max_step=0.05,
)

BOARD = Model(
    name='recorded_board',
    states=tuple(
        Variable(name, 'degC', lower=0.0, upper=120.0) for name in ('t1', 't2', 's1', 's2')
    ),
    inputs=(Variable('heat', '%'),),
    outputs=(Variable('y1', 'degC'), Variable('y2', 'degC')),
    parameters=(
        Variable('loss', 'W/K', lower=0.0, upper=0.2, physical='lower'),
        Variable('exchange', 'W/K', lower=0.0, upper=0.2, physical='lower'),
        Variable('heater', 'W/%', lower=0.001, upper=0.05),
        Variable('lag', 's', lower=1.0, upper=200.0),
    ),
    dynamics=board_dynamics,
    output=sensors,
    max_step=2.5,
)

CELL = Model(
    name='recorded_cell',
    states=(
        Variable('open', 'V', lower=2.0, upper=4.5),
        Variable('pair', 'V', lower=-0.5, upper=0.5),
    ),
    inputs=(Variable('current', 'A'),),
    outputs=(Variable('volt', 'V'),),
    parameters=(
        Variable('charge', 'Ah/V', lower=0.2, upper=1000.0),
        Variable('r0', 'mOhm', lower=0.01, upper=100.0),
        Variable('r1', 'mOhm', lower=0.01, upper=100.0),
        Variable('tau', 's', lower=1.0, upper=200.0),
    ),
    dynamics=cell_dynamics,
    output=cell_output,
    max_step=0.25,
)

CAR = Model(
    name='recorded_car',
    states=(
        Variable('vy', 'm/s', lower=-5.0, upper=5.0),
        Variable('rate', 'rad/s', lower=-6.0, upper=6.0),
    ),
    inputs=(Variable('steer', 'rad'), Variable('vx', 'm/s')),
    outputs=(Variable('lateral', 'm/s'), Variable('turn', 'rad/s')),
    parameters=(
        Variable('front', '100 N/rad', lower=0.5, upper=30.0),
        Variable('rear', '100 N/rad', lower=0.5, upper=30.0),
        Variable('mu', lower=0.1, upper=2.0),
        Variable('offset', 'rad', lower=-0.2, upper=0.2),
    ),
    dynamics=car_dynamics,
    output=both,
    max_step=0.01,
)

PLANTS = {
    'ball and beam': Plant('ball_and_beam.csv', BALL, ('u',), ('y',), 20.0, 0.1),
    'heater board': Plant('tclab.csv', BOARD, ('heat',), ('t1', 't2'), 1000.0),
    'battery': Plant('battery.csv', CELL, ('cur',), ('volt',), 300.0),
    'car': Plant('car.csv', CAR, ('steer', 'vx'), ('vy', 'rate'), 3.0),
}


@functools.cache  # once in each process, not for each window
def recorded(name: str, folder: Path) -> Record:
    """Return the whole recording of a plant."""
    plant = PLANTS[name]
    rows = np.genfromtxt(folder / plant.file, delimiter=',', names=True)
    t = rows['t'] if plant.interval is None else plant.interval * np.arange(rows.size)
    u, y = (
        np.column_stack([rows[name] for name in group]) for group in (plant.inputs, plant.outputs)
    )
    return Record(t, u, y)


def starts(plant: Plant, record: Record) -> list[float]:
    """Return the times (s) at which windows begin, the first of four disjoint from the fifth."""
    last = record.t[-1] - plant.window
    return np.arange(record.t[0], last, plant.window / OVERLAP).tolist()


def part(whole: Record, first: float, last: float, *, closed: bool = False) -> Record:
    """Return the samples in [first, last), or [first, last]."""
    inside = (whole.t >= first - 1e-9) & (whole.t < last + (1e-9 if closed else -1e-9))
    return Record(whole.t[inside], whole.u[inside], whole.y[inside])


def forecast(model: Model, found: Estimate, ahead: Record) -> Array:
    """Return the outputs (K, r) that an estimate foretells for times (K,) from its end on."""
    x, p = (
        np.array([[values[variable.name]] for variable in variables])
        for values, variables in ((found.state, model.states), (found.parameters, model.parameters))
    )
    grid = Grid.of(model, ahead, np.ones(len(model.outputs)))
    return np.asarray(kernels_for(model).trajectories(grid, x, p)[1][..., 0])
