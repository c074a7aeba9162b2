"""Windows of a model, solved in a new process: what was compiled before, and loaded meanwhile."""

import json
import sys
from collections.abc import Iterator

import numpy as np
from numba.core.event import Event, Listener, install_listener

from obs_ros import Model, Record, load_model
from obs_ros.core.deadline import Deadline
from obs_ros.core.jit import at_once
from obs_ros.core.model import inside
from obs_ros.core.rng import random_generator
from obs_ros.horizon.moving_horizon import MovingHorizon
from obs_ros.horizon.settings import EstimationSettings
from obs_ros.horizon.solver import Solver
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid
from obs_ros.integration.window_steps import by_method


class Compilations(Listener):
    """The functions that Numba has compiled since the list was empty."""

    def __init__(self) -> None:
        self.names: list[str] = []

    def on_start(self, event: Event) -> None:
        self.names.append(event.data['dispatcher'].py_func.__qualname__)

    def on_end(self, event: Event) -> None:
        pass


def windows_of(model: Model) -> Iterator[Record]:
    """Yield windows of noise, with a jump of the outputs, with spikes, and of 48 samples."""
    step = model.period or min(model.max_step, 0.1)
    exact = model if model.kind == 'discrete' else by_method(model, 'rosenbrock')
    for i, nodes in enumerate((160, 160, 160, 48)):
        rng = np.random.default_rng(i)
        t = step * np.arange(nodes)
        u = np.array([inside(v) for v in model.inputs]) * rng.uniform(0.8, 1.2, (nodes, 1))
        x, p = (np.array([inside(v) for v in group]) for group in (model.states, model.parameters))
        grid = Grid.of(model, Record(t, u, np.zeros((nodes, len(model.outputs)))), np.ones(1))
        _, outputs = kernels_for(exact, 'numpy').trajectories(grid, x[:, None], p[:, None])
        y = outputs[:, :, 0]
        size = np.maximum(np.ptp(y, axis=0), 1e-3)
        y = y + 0.02 * size * rng.standard_normal(y.shape)
        if i == 1:
            y[80:] += 0.5 * size
        if i == 2:
            y[::23] += 10.0 * size
        yield Record(t, u, y)


def main(name: str) -> None:
    """Print as JSON what preparing compiled, what windows compiled, and what they imported."""
    compilations = Compilations()
    with install_listener('numba:compile', compilations):
        solver = Solver.of(load_model(name), EstimationSettings())
        solver.prepare()
        prepared, compilations.names = compilations.names, []
        modules = {*sys.modules}
        windows = MovingHorizon(solver)
        with at_once():
            for i, window in enumerate(windows_of(solver.model)):
                windows.solve(window, random_generator(0, i), Deadline())
    print(json.dumps([prepared, compilations.names, sorted({*sys.modules} - modules)]))


if __name__ == '__main__':
    main(sys.argv[1])
