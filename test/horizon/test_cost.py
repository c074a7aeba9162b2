"""What a window that nothing explains may cost, in candidate-steps of one that fits."""

from typing import Any

import numpy as np
import pytest
from plants import COARSE_TANKS, LAG, lag_outputs, square_wave, tank_outputs
from scipy.signal import lfilter

from obs_ros import Model, Outcome, Record
from obs_ros.core.deadline import Deadline
from obs_ros.core.rng import random_generator
from obs_ros.core.typing import Array
from obs_ros.horizon.moving_horizon import MovingHorizon
from obs_ros.horizon.settings import EstimationSettings
from obs_ros.horizon.solver import Solver
from obs_ros.integration.backends import Kernels, kernels_for

# Times a window of the same plant that fits. Process noise is one more search, without rounds.
MOST = {'off': 8.0, 'auto': 10.0}
SEEDS = range(5)


class Counting:
    """Kernels that count candidate-steps."""

    def __init__(self, kernels: Kernels) -> None:
        self.kernels, self.name, self.model = kernels, kernels.name, kernels.model
        self.compile_time, self.steps = 0.0, 0

    def squares(self, grid: Any, prefixes: Any, x0: Array, p: Array) -> Any:
        self._count(grid, int(prefixes[-1]), x0)
        return self.kernels.squares(grid, prefixes, x0, p)

    def grams(self, grid: Any, nodes: int, x0: Array, p: Array, width: int) -> Any:
        self._count(grid, nodes, x0)
        return self.kernels.grams(grid, nodes, x0, p, width)

    def trajectories(self, grid: Any, x0: Array, p: Array, width: int = 1) -> Any:
        self._count(grid, grid.t.size, x0)
        return self.kernels.trajectories(grid, x0, p, width)

    def scheduled(self, grid: Any, x0: Array, *rest: Any) -> Any:
        self._count(grid, grid.t.size, x0)
        return self.kernels.scheduled(grid, x0, *rest)

    def paths(self, grid: Any, x0: Array, p: Array) -> Any:
        self._count(grid, grid.t.size, x0)
        return self.kernels.paths(grid, x0, p)

    def one_step(self, grid: Any, *rest: Any) -> Any:
        found = self.kernels.one_step(grid, *rest)
        self._count(grid, grid.t.size, np.empty((1, 1 + found[0].shape[2])))
        return found

    def filter(self, grid: Any, x0: Array, *rest: Any) -> Any:
        found = self.kernels.filter(grid, x0, *rest)
        self._count(grid, grid.t.size, np.empty((1, 1 + 2 * found.index.size)))
        return found

    def _count(self, grid: Any, nodes: int, x0: Array) -> None:
        self.steps += int(grid.steps[: nodes - 1].sum()) * x0.shape[1]


class CountingSolver(Solver):
    """A solver on kernels that count."""

    @property
    def kernels(self) -> Any:
        if 'counting' not in self.__dict__:
            object.__setattr__(self, 'counting', Counting(kernels_for(self.model, 'numba')))
        return self.__dict__['counting']


def lag(seed: int) -> tuple[Record, float]:
    rng = np.random.default_rng([seed, 8])
    t = 0.1 * np.arange(400)
    u = square_wave(t) * np.repeat(rng.uniform(0.5, 1.5, 14), 30)[:400]
    return Record(t, u, lag_outputs(t, u, 1.0, np.tile([1.2, 3.0], (400, 1)))), 0.02


def tanks(seed: int) -> tuple[Record, float]:
    rng = np.random.default_rng([seed, 8])
    t = 5.0 * np.arange(200)
    y = tank_outputs(t, rng.uniform(5.0, 30.0, 3), rng.uniform(0.4, 0.8, 3))
    return Record(t, np.full((200, 2), 30.0), y), 0.1


def misfits(record: Record, rng: np.random.Generator) -> dict[str, Array]:
    """Outputs that the record's plant cannot have, by what is wrong with them."""
    y, spread, k = record.y, record.y.std(axis=0), np.arange(record.t.size)[:, None]
    white = rng.standard_normal((2, *y.shape))
    return {
        'limited': np.minimum(y, np.quantile(y, 0.7, axis=0)),
        'disturbed': y + 0.2 * spread * lfilter([0.44], [1.0, -0.9], white[0], axis=0),
        'slowly disturbed': y + 0.5 * spread * lfilter([0.14], [1.0, -0.99], white[0], axis=0),
        'walk': spread * np.cumsum(white[1], axis=0) / np.sqrt(k.size / 6),
        'square wave': y.mean(axis=0) + 2.0 * spread * (1.0 - 2.0 * (k // 23 % 2)),
        'noise': y.mean(axis=0) + spread * white[1],
        'sine': y + 0.3 * spread * np.sin(0.1 * k),
    }


def steps(model: Model, record: Record, noise: Any, mode: Any) -> int:
    solver = CountingSolver.of(model, EstimationSettings(noise=noise, process_noise=mode))
    estimate = solver.solve(record, random_generator(1), Deadline())
    assert estimate.outcome is not Outcome.DEADLINE
    return int(solver.kernels.steps)


def steps_in_sequence(model: Model, record: Record, noise: Any, mode: Any) -> int:
    """Of six windows, each as long as half of the record."""
    solver = CountingSolver.of(model, EstimationSettings(noise=noise, process_noise=mode))
    windows, half = MovingHorizon(solver), record.t.size // 2
    for i, first in enumerate(np.linspace(0, half, 6).astype(int)):
        part = slice(first, first + half)
        window = Record(record.t[part], record.u[part], record.y[part])
        windows.solve(window, random_generator(1, i), Deadline())
    return int(solver.kernels.steps)


CASES = [(p, m, known) for p, m in ((lag, LAG), (tanks, COARSE_TANKS)) for known in (True, False)]
# Of sequences, the one that comes nearest to the bound is quick; `make check` runs the others.
IN_SEQUENCE = [
    pytest.param(
        steps_in_sequence, *case, marks=[] if case == (lag, LAG, True) else [pytest.mark.slow]
    )
    for case in CASES
]


@pytest.mark.parametrize('mode', MOST)
@pytest.mark.parametrize(
    ('count', 'plant', 'model', 'known'), [*((steps, *c) for c in CASES), *IN_SEQUENCE]
)
def test_a_window_that_nothing_explains_costs_little_more(
    count: Any, plant: Any, model: Model, known: bool, mode: str
) -> None:
    """The median of five windows or runs, for every kind of misfit."""
    pytest.importorskip('numba')
    fitting: list[int] = []
    spent: dict[str, list[int]] = {}
    for seed in SEEDS:
        record, sigma = plant(seed)
        rng = np.random.default_rng([seed, 9])
        noise = sigma * rng.standard_normal(record.y.shape)
        given = {v.name: sigma for v in model.outputs} if known else None
        fitting.append(count(model, record.with_outputs(record.y + noise), given, mode))
        for kind, y in misfits(record, rng).items():
            found = count(model, record.with_outputs(y + noise), given, mode)
            spent.setdefault(kind, []).append(found)
    ratios = {kind: np.median(each) / np.median(fitting) for kind, each in spent.items()}
    assert max(ratios.values()) <= MOST[mode], ratios
