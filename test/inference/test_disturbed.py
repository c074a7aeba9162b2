"""Tests of obs_ros.inference.disturbed."""

from dataclasses import replace

import numpy as np
import pytest
from plants import NAN, window_of
from stiff_plants import truth, van_der_pol

from obs_ros import Model, Record, Variable
from obs_ros.core.deadline import Deadline
from obs_ros.core.typing import Array
from obs_ros.inference.disturbed import (
    disturbed,
    filtered,
    is_lost,
    with_given_walks,
)
from obs_ros.inference.prior import Prior
from obs_ros.inference.process_noise import SETTINGS, ProcessNoise
from obs_ros.inference.window_state import WindowState, criterion_of
from obs_ros.optimization.levenberg_marquardt import levenberg_marquardt

INTERVAL, SIGMA = 0.1, 0.02
TRUTH = {'x': 0.3, 'k': 1.3}


def decay(t: object, x: tuple, u: tuple, p: tuple) -> tuple:
    return (p[0] * (u[0] - x[0]),)


def itself(t: object, x: tuple, u: tuple, p: tuple) -> tuple:
    return (x[0],)


def model(walk: float | None = None) -> Model:
    return Model(
        name='pushed_lag',
        states=(Variable('x', 'V', lower=-5.0, upper=5.0, walk=walk),),
        inputs=(Variable('u', 'V'),),
        outputs=(Variable('y', 'V'),),
        parameters=(Variable('k', '1/s', lower=0.1, upper=5.0),),
        dynamics=decay,
        output=itself,
    )


def window(walk: float, seed: int = 0, of: Model | None = None, nodes: int = 400) -> WindowState:
    """A lag that is exactly stepped: x' = k (u - x) with a walk."""
    rng = np.random.default_rng([seed, 4])
    t = INTERVAL * np.arange(nodes)
    u = np.where((t // 4.0) % 2 == 0, 1.0, -1.0)
    hold = np.exp(-TRUTH['k'] * INTERVAL)
    spread = walk * np.sqrt((1.0 - hold**2) / (2.0 * TRUTH['k']))
    x = np.empty(nodes)
    x[0] = TRUTH['x']
    for k in range(nodes - 1):
        x[k + 1] = u[k] + (x[k] - u[k]) * hold + spread * rng.standard_normal()
    record = Record(t, u, x + SIGMA * rng.standard_normal(nodes))
    objective = window_of(of or model(), record, SIGMA, backend='numba')
    return WindowState(record, objective, Prior.box(objective.unknowns), noise_known=True)


def optimum(posed: WindowState) -> tuple[Array, float]:
    start = posed.objective.unknowns.point(TRUTH)
    nodes = posed.objective.nodes
    solved = levenberg_marquardt(posed.posterior, start[None], nodes, 40, Deadline())
    return solved.z[0], float(solved.squares[0])


FREE, KNOWN = np.array([NAN]), np.array([SIGMA])


@pytest.mark.parametrize('given', [FREE, KNOWN], ids=['noise free', 'noise given'])
@pytest.mark.parametrize('walk', [0.05, 0.15])
def test_the_walk_is_found_and_the_noise_beside_it(walk: float, given: Array) -> None:
    found = []
    for seed in range(12):
        posed = window(walk, seed)
        z, squares = optimum(posed)
        best = disturbed(posed, z, given, None, Deadline())
        assert best is not None
        assert best.criterion < criterion_of(posed, squares)
        found.append(
            (
                best.noise.walks[0],
                best.noise.noise[0],
                best.z[1] - posed.objective.unknowns.point(TRUTH)[1],
            )
        )
        assert best.noise.walks[1] == 0.0  # the parameter's
    walks, noises, errors = np.array(found).T
    assert np.median(walks) == pytest.approx(walk, rel=0.15)
    assert np.median(noises) == pytest.approx(SIGMA, rel=0.25)
    assert np.abs(np.median(errors)) < 0.05


def test_short_windows_do_not_find_walks_too_small_for_what_the_candidate_fits() -> None:
    """Along the candidate the likelihood has its maximum 4 % lower."""
    walks = []
    for seed in range(200):
        posed = window(0.15, seed, nodes=20)
        best = disturbed(posed, optimum(posed)[0], KNOWN, None, Deadline())
        assert best is not None
        walks.append(best.noise.walks[0])
    # With some 18 degrees of freedom in each, the root mean square has a deviation of 1.2 %.
    assert np.sqrt(np.mean(np.square(walks))) == pytest.approx(0.15, rel=0.03)


def test_an_exact_plant_has_none() -> None:
    """Its likelihood gains less than what a walk costs."""
    none = 0
    for seed in range(12):
        posed = window(0.0, seed)
        z, squares = optimum(posed)
        best = disturbed(posed, z, KNOWN, None, Deadline())
        none += best is None or best.criterion >= criterion_of(posed, squares)
    assert none == 12


def test_corrected_rollouts_leave_white_innovations_and_the_end_its_covariance() -> None:
    posed = window(0.15)
    best = disturbed(posed, optimum(posed)[0], FREE, None, Deadline())
    assert best is not None
    residuals = best.window.objective.residuals(best.z)[:, 0]
    assert residuals.std() == pytest.approx(1.0, rel=0.05)
    assert abs(np.corrcoef(residuals[1:], residuals[:-1])[0, 1]) < 0.1
    assert 0.2 * SIGMA < np.sqrt(best.covariance[0, 0]) < best.noise.noise[0]
    # The window that was given is as it was.
    assert posed.objective.grid.injection is None and posed.noise_known


def test_it_starts_from_an_earlier_windows_noise_too() -> None:
    posed = window(0.15)
    z, _ = optimum(posed)
    alone = disturbed(posed, z, FREE, None, Deadline())
    helped = disturbed(posed, z, FREE, ProcessNoise(np.array([0.15, 0.0]), KNOWN), Deadline())
    assert alone is not None and helped is not None
    assert helped.criterion == pytest.approx(alone.criterion, abs=2.0 * SETTINGS.gain)


def test_given_walks_are_taken_as_they_are() -> None:
    posed = window(0.15, of=model(walk=0.15))
    best = with_given_walks(posed, optimum(posed)[0], FREE, Deadline())
    assert best is not None
    assert best.noise.walks.tolist() == [0.15, 0.0]
    assert best.noise.noise[0] == pytest.approx(SIGMA, rel=0.5)


def test_without_time_there_is_none() -> None:
    posed = window(0.15)
    assert disturbed(posed, optimum(posed)[0], FREE, None, Deadline(0.0)) is None


def test_a_filter_is_lost_where_its_deviations_exceed_all_that_was_measured() -> None:
    relaxing = replace(van_der_pol(20.0), integrator='rosenbrock')
    t = np.linspace(0.0, 60.0, 61)
    y = truth(relaxing, t, np.empty((61, 0)), (2.0, -0.03), (20.0,))
    objective = window_of(relaxing, Record(t, None, y), SIGMA, backend='numba')
    grid = objective.grid.stepped(400 * objective.grid.steps)
    objective = replace(objective, grid=grid)
    posed = WindowState(
        Record(t, None, y), objective, Prior.box(objective.unknowns), noise_known=True
    )
    z = objective.unknowns.point({'x': 2.0, 'rate': -0.03, 'mu': 20.0})
    noise = np.array([SIGMA])
    # Where it jumps, a push is multiplied by hundreds within a sample.
    for push, lost in ((1e-6, False), (0.3, True)):
        pushed = ProcessNoise(np.array([push, push, 0.0]), noise)
        assert is_lost(posed, filtered(posed, z, pushed), pushed) is lost
    outputs = window(0.3)
    plain = ProcessNoise(np.array([0.3, 0.0]), noise)
    assert not is_lost(outputs, filtered(outputs, optimum(outputs)[0], plain), plain)
