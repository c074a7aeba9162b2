"""Windows of overflowing tanks in sequence, beside the same windows alone."""

from typing import Any, NamedTuple

import numpy as np

from benchmarks.mismatch.plants import FULL_TANKS, TANKS, overflowing
from obs_ros import Model, Record, solve_window
from obs_ros.core.deadline import Deadline
from obs_ros.core.rng import random_generator
from obs_ros.core.typing import Array
from obs_ros.horizon.moving_horizon import MovingHorizon
from obs_ros.horizon.settings import EstimationSettings
from obs_ros.horizon.solver import Solver

DURATION = 200  # samples of a window
WINDOWS = 40  # of a sequence
SPACINGS = {'a quarter': DURATION // 4, 'a window': DURATION}  # samples from window to window
MODES = ('off', 'auto')


class Scene(NamedTuple):
    """A model of the tanks, and how much these overflow."""

    model: Model
    flood: str


SCENES = {
    '3 parameters, some overflow': Scene(TANKS, 'some'),
    '3 parameters, much overflow': Scene(TANKS, 'much'),
    '6 parameters, much overflow': Scene(FULL_TANKS, 'much'),
}


class Followed(NamedTuple):
    """Windows W in sequence and alone: values and deviations (W, q) of parameters, outcomes."""

    values: Array
    sd: Array
    alone: Array
    alone_sd: Array
    outcomes: list[str]
    alone_outcomes: list[str]


def followed(scene: str, spacing: str, mode: Any, seed: int, windows: int) -> Followed:
    """Solve a sequence of windows, and each of them alone, in a mode of process noise."""
    (model, flood), apart = SCENES[scene], SPACINGS[spacing]
    record, _ = overflowing(seed, DURATION + apart * (windows - 1), flood=flood)
    solver = Solver.of(model, EstimationSettings(process_noise=mode))
    solver.prepare()
    horizon = MovingHorizon(solver)
    names = [variable.name for variable in model.parameters]
    pairs = []
    for i in range(windows):
        part = slice(i * apart, i * apart + DURATION)
        window = Record(record.t[part], record.u[part], record.y[part])
        pairs.append((
            horizon.solve(window, random_generator(seed, i), Deadline()),
            solve_window(model, window, seed=seed, process_noise=mode),
        ))  # fmt: skip
    values, alone = (np.array([[e.parameters[v] for v in names] for e in each])
                     for each in zip(*pairs, strict=True))  # fmt: skip
    sd, alone_sd = (np.array([[e.stddev[v] for v in names] for e in each])
                    for each in zip(*pairs, strict=True))  # fmt: skip
    outcomes, alone_outcomes = ([e.outcome.value for e in each]
                                for each in zip(*pairs, strict=True))  # fmt: skip
    return Followed(values, sd, alone, alone_sd, outcomes, alone_outcomes)
