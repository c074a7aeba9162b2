"""Rollouts may return anything at any time: windows end with an outcome, without a warning."""

from collections.abc import Iterator
from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np
import pytest
from plants import INTEGRATOR

from obs_ros import Estimate, Outcome, Record
from obs_ros.core.deadline import Deadline
from obs_ros.core.rng import random_generator
from obs_ros.core.typing import Array
from obs_ros.horizon import solver as horizon_solver
from obs_ros.horizon.moving_horizon import MovingHorizon
from obs_ros.horizon.settings import EstimationSettings
from obs_ros.horizon.solver import Solver
from obs_ros.integration.backends import kernels_for

pytestmark = pytest.mark.filterwarnings('error')

ROLLOUTS = ('squares', 'grams', 'trajectories', 'paths', 'filter')
VALUES = (np.nan, np.inf, -np.inf, 1e300, 1e155, 0.0, -1.0, 5e-324)
K = 40


class Faulty:
    """Kernels of which a share of the calls returns numbers that are wrong, in whole or in part."""

    def __init__(self, kernels: Any, rng: np.random.Generator, share: float) -> None:
        self._kernels, self._rng, self._share = kernels, rng, share

    def __getattr__(self, name: str) -> Any:
        found = getattr(self._kernels, name)
        if name not in ROLLOUTS:
            return found
        return lambda *args, **kwargs: self._perhaps_wrong(found(*args, **kwargs))

    def _perhaps_wrong(self, found: Any) -> Any:
        return self._wrong(found) if self._rng.random() < self._share else found

    def _wrong(self, found: Any) -> Any:
        if isinstance(found, np.ndarray):
            return self._corrupted(found)
        if is_dataclass(found) and not isinstance(found, type):
            values = {f.name: getattr(found, f.name) for f in fields(found)}
            arrays = {name: v for name, v in values.items() if isinstance(v, np.ndarray)}
            arrays = {name: a for name, a in arrays.items() if a.dtype.kind == 'f'}
            name = str(self._rng.choice(sorted(arrays)))
            return replace(found, **{name: self._corrupted(arrays[name])})
        parts = list(found)
        i = int(self._rng.integers(len(parts)))
        parts[i] = self._wrong(parts[i])
        return tuple(parts)

    def _corrupted(self, values: Array) -> Array:
        found, wrong = values.copy(), float(self._rng.choice(VALUES))
        if found.size:
            match self._rng.integers(4):
                case 0:
                    found[...] = wrong
                case 1:
                    found[..., self._rng.integers(found.shape[-1])] = wrong
                case 2:
                    found[self._rng.integers(len(found)) :] = wrong
                case _:
                    found[self._rng.random(found.shape) < 0.3] = wrong
        return found


@pytest.fixture
def faulty(monkeypatch: pytest.MonkeyPatch) -> Any:
    """A function that makes every solver's kernels faulty, by a generator and a share."""

    def make(rng: np.random.Generator, share: float) -> None:
        monkeypatch.setattr(
            horizon_solver, 'kernels_for',
            lambda model, backend=None: Faulty(kernels_for(model, backend), rng, share),
        )  # fmt: skip

    return make


def windows(rng: np.random.Generator, count: int) -> Iterator[Record]:
    """Windows of the integrator, now and then with an outlier or a step."""
    for number in range(count):
        t = 0.1 * np.arange(K)
        u = np.sign(np.sin(2.0 * t + number))
        y = 1.0 + np.concatenate([[0.0], np.cumsum(0.1 * (0.8 * u + 0.2))[:-1]])
        y += 0.01 * rng.standard_normal(K)
        y[K // 2 :] += 0.5 * (rng.random() < 0.3)
        y[7] += 50.0 * (rng.random() < 0.3)
        yield Record(t + 0.1 * K * number, u, y)


def sound(estimate: Estimate) -> bool:
    """Whether no number that is published is infinite, nor a deviation below zero."""
    told = np.array([*estimate.stddev.values(), *estimate.initial_stddev.values()])
    ends = np.array([*estimate.interval.values()])
    return not (np.isinf(told).any() or (told < 0.0).any() or np.isinf(ends).any())


@pytest.mark.parametrize('share', [0.03, 0.3])
@pytest.mark.parametrize('noise', [None, {'y': 0.01}])
def test_every_window_ends_with_an_outcome(share: float, noise: Any, faulty: Any) -> None:
    pytest.importorskip('numba')
    outcomes = set()
    for seed in range(6):
        rng = np.random.default_rng(seed)
        faulty(rng, share)
        solver = Solver.of(INTEGRATOR, EstimationSettings(noise=noise))
        horizon = MovingHorizon(solver, learn_noise=bool(seed % 2))
        for record in windows(rng, 3):
            for estimate in (
                horizon.solve(record, random_generator(seed), Deadline(20.0)),
                solver.solve(record, random_generator(seed), Deadline(20.0)),
            ):
                assert isinstance(estimate.outcome, Outcome)
                assert sound(estimate), estimate
                outcomes.add(estimate.outcome)
    assert outcomes - {Outcome.CONVERGED}
