"""Tests of obs_ros.horizon.solver."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from plants import LAG, lag_outputs, square_wave

from obs_ros import Record
from obs_ros.core.deadline import Deadline
from obs_ros.core.rng import random_generator
from obs_ros.horizon.cleaning import rescaled_to_residuals
from obs_ros.horizon.settings import EstimationSettings
from obs_ros.horizon.solver import Solver
from obs_ros.horizon.unsolvable import TooFewSamples
from obs_ros.inference.prior import Prior

T = 0.1 * np.arange(200)
U = square_wave(T)
TRUTH = lag_outputs(T, U, 0.5, np.tile([1.2, 3.0], (199, 1)))


def record(sigma: float = 0.05, nodes: int = 200) -> Record:
    noise = sigma * np.random.default_rng(1).standard_normal(TRUTH.shape)
    return Record(T[:nodes], U[:nodes], (TRUTH + noise)[:nodes])


def solver(**settings: object) -> Solver:
    return Solver.of(LAG, EstimationSettings(backend='numpy', **settings))  # type: ignore[arg-type]


def test_a_posed_window_is_in_units_of_its_scale_and_has_the_prior_that_is_given() -> None:
    plain = solver()
    window = plain.pose(record(), np.array([0.05]), noise_known=True)
    assert window.objective.grid.scale == 0.05
    np.testing.assert_array_equal(window.prior.mean, Prior.box(plain.unknowns).mean)
    narrow = Prior(np.full(3, 0.2), np.eye(3), gap=0.5)
    assert plain.pose(record(), prior=narrow, noise_known=False).prior is narrow


@pytest.mark.parametrize(('noise_known', 'needed'), [(True, 3), (False, 12)])
def test_a_window_needs_values_for_its_unknowns(noise_known: bool, needed: int) -> None:
    plain = solver()
    assert plain.pose(record(nodes=needed), noise_known=noise_known).objective.nodes == needed
    with pytest.raises(TooFewSamples, match=f'{needed - 1} measured values for 3 unknowns, at lea'):
        plain.pose(record(nodes=needed - 1), noise_known=noise_known)


def test_a_fit_leaves_the_window_that_it_was_given_as_it_is() -> None:
    plain = solver()
    window = plain.pose(record(), noise_known=False)
    scale = window.objective.grid.scale.copy()
    fitted, found = plain.fit(window, window.posterior, random_generator(1), Deadline(), None)
    rescaled, other = rescaled_to_residuals(fitted, found)
    np.testing.assert_array_equal(window.objective.grid.scale, scale)
    assert rescaled.objective.grid.scale == pytest.approx(0.05, rel=0.15)
    # In units of what it leaves the squares are the degrees of freedom.
    assert other.cost == pytest.approx(197.0, rel=1e-9)
    np.testing.assert_array_equal(other.z, found.z)
    assert rescaled.objective.evaluations == window.objective.evaluations


def test_a_start_comes_from_the_previous_estimate_or_the_initial_values() -> None:
    plain, given = solver(), solver(initial={'k': 1.0})
    assert plain.warm_start(record(), None) is None
    start = given.warm_start(record(), None)
    assert start is not None
    place = given.unknowns.names.index('k')
    assert given.unknowns.scale.values(start)[place] == pytest.approx(1.0)
    estimate = plain.solve(record(), random_generator(1), Deadline())
    warm = plain.warm_start(record(), estimate)
    assert warm is not None
    found = dict(zip(plain.unknowns.names, plain.unknowns.scale.values(warm), strict=True))
    assert found['k'] == pytest.approx(estimate.parameters['k'])


def test_walks_and_priors_take_the_place_of_the_models() -> None:
    given = solver(walks={'x': 0.1}, priors={'tau': (4.0, 0.5)}, process_noise='given')
    assert [v.walk for v in given.model.variables] == [0.1, None, None]
    assert [v.prior for v in given.model.variables] == [None, None, (4.0, 0.5)]
    assert given.kernels.model == given.model and solver().model is LAG
    start = given.warm_start(record(), None)
    assert start is not None
    assert given.unknowns.scale.values(start)[2] == pytest.approx(4.0)
    window = given.pose(record(), noise_known=True)
    assert window.prior.given is not None and window.prior.given[2] > 0.0
    with pytest.raises(ValueError, match="give a state of model 'lag' a walk"):
        solver(walks={'k': 0.1}, process_noise='given')


SOLVES = Path(__file__).parents[1] / 'prepared_windows.py'


@pytest.mark.slow
@pytest.mark.parametrize('model', ['plants:LAG', 'stiff_plants:MOTOR', 'three_tank'])
def test_after_preparing_no_window_compiles_or_imports_anything(model: str, tmp_path: Path) -> None:
    """Beside a node's load the first window took 20 s when its loops were compiled there."""
    pytest.importorskip('numba')
    done = subprocess.run(
        [sys.executable, str(SOLVES), model], env={**os.environ, 'OBS_ROS_CACHE': str(tmp_path)},
        stdout=subprocess.PIPE, text=True, check=True,
    )  # fmt: skip
    prepared, later, imported = json.loads(done.stdout)
    assert {'squares', 'grams', 'trajectories', 'damped_steps'} <= {*prepared}
    assert later == [] and imported == []
