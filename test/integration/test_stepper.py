"""Tests of stepping candidates from output to output: the same as rolling them out."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from plants import BLOW_UP, NAN, OSCILLATOR

from obs_ros import Model, Record
from obs_ros.core.prior_knowledge import with_knowledge
from obs_ros.core.typing import Array
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid
from obs_ros.integration.path import LANES, Path, lanes
from obs_ros.integration.stepper import stepper_for


def candidates(model: Model, count: int) -> tuple[Array, Array]:
    rng = np.random.default_rng(0)
    return tuple(
        np.array([rng.uniform(v.lower, v.upper, count) for v in group]).reshape(-1, count)
        for group in (model.states, model.parameters)
    )


@pytest.mark.parametrize('integrator', ['rk4', 'euler'])
def test_a_path_of_several_pieces_gives_what_a_rollout_gives(backend: str, integrator: Any) -> None:
    model = replace(OSCILLATOR, integrator=integrator)
    t = np.array([0.0, 0.13, 0.2, 0.55])
    u = np.array([[0.3], [-1.0], [2.0], [0.7]])
    grid = Grid.of(model, Record(t, u, np.zeros((4, 2))), np.ones(2))
    x, p = candidates(model, 2 * LANES)
    states, outputs = kernels_for(model, backend).trajectories(grid, x, p)
    stepper = stepper_for(model, backend)
    assert stepper.name == backend
    path = Path(3, t, np.diff(t), grid.steps, u, 0.0 * u)
    stepper.propagate(path, x, p)
    y = np.empty((2, x.shape[1]))
    stepper.measure(t[-1], u[-1], x, p, y)
    np.testing.assert_allclose(x, states[-1], rtol=1e-12)
    np.testing.assert_allclose(y, outputs[-1], rtol=1e-12)


def test_a_plant_without_inputs_and_parameters_and_a_candidate_that_diverges(backend: str) -> None:
    stepper = stepper_for(BLOW_UP, backend)
    x, p = np.full((1, LANES), 0.5), np.empty((0, LANES))
    x[0, 3], x[0, 4] = 4.0, NAN
    empty = np.empty((2, 0))
    stepper.propagate(Path(1, np.zeros(2), np.ones(1), np.array([100]), empty, empty), x, p)
    assert not np.isfinite(x[0, 3:5]).any()
    np.testing.assert_allclose(np.delete(x[0], [3, 4]), 1.0, rtol=1e-6)


def test_lanes_come_in_chunks() -> None:
    assert [lanes(count) for count in (1, 15, 16, 17)] == [16, 16, 16, 32]


def test_models_that_differ_in_walks_and_priors_share_steppers(backend: str) -> None:
    known = with_knowledge(OSCILLATOR, {'push': 0.1}, {'stiffness': (1.0, 0.1)})
    found, plain = stepper_for(known, backend), stepper_for(OSCILLATOR, backend)
    assert found.model == known and {**vars(found), 'model': OSCILLATOR} == vars(plain)
