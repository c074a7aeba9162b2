"""Tests of obs_ros.horizon.solution, by way of windows in sequence."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from plants import LAG, square_wave

from obs_ros import Model, Outcome, Record
from obs_ros.core.deadline import Deadline
from obs_ros.core.estimate import Estimate
from obs_ros.core.rng import random_generator
from obs_ros.core.typing import Array
from obs_ros.horizon.comparison import by_forecasts
from obs_ros.horizon.earlier import Earlier, contradicts_prior
from obs_ros.horizon.forecasts import Basis, Ends, Forecasts
from obs_ros.horizon.moving_horizon import MovingHorizon
from obs_ros.horizon.settings import EstimationSettings
from obs_ros.horizon.solution import DROPPED, solved
from obs_ros.horizon.solver import Solver
from obs_ros.inference.jumps.hypothesis import hypothesis_at
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.prior import Prior

K, TAU, SIGMA, WALK, INTERVAL, NODES = 1.2, 3.0, 0.02, 0.1, 0.1, 300


def pushed(nodes: int, seed: int, gains: Array | float = K, walk: Array | float = WALK) -> Record:
    """A lag that is exactly stepped, its state pushed about."""
    rng = np.random.default_rng([seed, 7])
    t = INTERVAL * np.arange(nodes)
    u = square_wave(t) * np.repeat(rng.uniform(0.5, 1.5, nodes // 30 + 1), 30)[:nodes]
    hold = np.exp(-INTERVAL / TAU)
    push = np.broadcast_to(walk * np.sqrt(0.5 * TAU * (1.0 - hold**2)), nodes)
    gains = np.broadcast_to(gains, nodes)
    x = np.empty(nodes)
    x[0] = 0.5
    for k in range(nodes - 1):
        end = gains[k] * u[k]
        x[k + 1] = end + (x[k] - end) * hold + push[k] * rng.standard_normal()
    return Record(t, u, x + SIGMA * rng.standard_normal(nodes))


def in_sequence(record: Record, model: Model = LAG, step: int = NODES) -> list[Estimate]:
    solver = Solver.of(model, EstimationSettings())
    solver.prepare()
    windows = MovingHorizon(solver)
    found = []
    for i, first in enumerate(range(0, record.t.size - NODES + 1, step)):
        part = slice(first, first + NODES)
        window = Record(record.t[part], record.u[part], record.y[part])
        found.append(windows.solve(window, random_generator(0, i), Deadline()))
    return found


def test_windows_that_follow_one_with_process_noise_are_not_searched_again() -> None:
    found = in_sequence(pushed(6 * NODES, seed=1))
    assert {one.outcome for one in found} == {Outcome.CONVERGED}
    searched, *rest = [one.evaluations for one in found]
    assert max(rest) < searched / 3


def test_a_jump_beside_process_noise_is_found_and_no_window_is_far_off() -> None:
    """Soon after it, a jump of the gain and one of the time constant look much alike."""
    fault = 4.5 * NODES
    gains = np.where(np.arange(7 * NODES) < fault, K, 2.0 * K)
    far = 0
    for seed in range(3):
        found = in_sequence(pushed(7 * NODES, seed, gains), step=NODES // 2)
        (jump,) = [jump for one in found for jump in one.jumps if jump.new]
        assert jump.time == pytest.approx(fault * INTERVAL, abs=1.0)
        assert {'k', 'tau'} & set(jump.sizes)
        for one in found:
            truth = gains[round(one.t1 / INTERVAL)]
            far += abs(one.parameters['k'] - truth) > 4.0 * one.stddev['k']
    assert far <= 1  # of 39: between a jump and its first sign nobody can know


@pytest.mark.parametrize('seed', range(2))
def test_a_jump_after_pushes_have_ceased_does_not_pass_for_another_push(seed: int) -> None:
    """Windows with process noise are many here, and yet the one before the jump has none."""
    nodes, ceased, fault = 6 * NODES, 3.2 * NODES, 4.4 * NODES
    k = np.arange(nodes)
    gains = np.where(k < fault, K, 1.1 * K)
    record = pushed(nodes, seed, gains, np.where(k < ceased, WALK, 0.0))
    found = in_sequence(record, step=NODES // 6)
    (jump,) = [jump for one in found for jump in one.jumps if jump.new]
    assert jump.sizes.keys() == {'k'}
    assert jump.time == pytest.approx(fault * INTERVAL, abs=1.0)
    for one in found:
        truth = gains[round(one.t1 / INTERVAL)]
        assert not abs(one.parameters['k'] - truth) > 4.0 * one.stddev['k']


class Overheard(Forecasts):
    """Forecasts that keep what they were begun with."""

    def begin(self, ends: Mapping[Basis, Ends], *rest: Any) -> None:
        self.ends = ends
        super().begin(ends, *rest)


@pytest.mark.parametrize(('walk', 'given'), [(0.02, np.nan), (WALK, SIGMA)])
def test_where_jumps_are_less_likely_than_process_noise_forecasts_may_choose_output_error(
    walk: float, given: float
) -> None:
    """Such jumps stand for pushes, and the optimum without them may foretell best of all."""
    solver, known = Solver.of(LAG, EstimationSettings()), np.isfinite(given)
    scale = np.array([given])
    record = pushed(NODES, seed=2, walk=walk)
    posed = solver.pose(record, scale if known else None, noise_known=bool(known))
    nothing = Earlier(None, None, None)
    found = solved(posed, solver, nothing, scale, random_generator(0, 2), Deadline())
    assert found is not None and found.disturbed is not None
    assert found.plain.problem.events
    assert found.still is not None and not found.still.problem.events
    forecasts = Overheard()
    by_forecasts(forecasts, found.posed, found)
    assert forecasts.ends.keys() == {*Basis}


def test_a_parameter_that_walks_is_no_basis_among_others() -> None:
    """It stands in the place of jumps, which belong to one hypothesis alone."""
    solver, scale = Solver.of(LAG, EstimationSettings()), np.array([SIGMA])
    record = pushed(2 * NODES, 3, np.linspace(1.5, 1.0, 2 * NODES), walk=0.0)
    posed = solver.pose(record, scale, noise_known=True)
    nothing = Earlier(None, None, None)
    found = solved(posed, solver, nothing, scale, random_generator(0), Deadline())
    assert found is not None and found.disturbed is not None and found.plain.jumps
    assert found.disturbed.noise.drifting(LAG) == ('k',)
    forecasts = Overheard()
    by_forecasts(forecasts, found.posed, found)
    assert forecasts.ends.keys() == {Basis.PROCESS_NOISE}


def test_a_prior_that_a_window_contradicts_is_dropped_and_that_is_said() -> None:
    """The gain doubles in a pause that no window covers."""
    record = pushed(8 * NODES, 2, np.where(np.arange(8 * NODES) < 4 * NODES, K, 2.0 * K))
    found = in_sequence(record)
    said = [DROPPED in one.message or bool(one.jumps) for one in found]
    assert any(said[4:6])
    assert found[-1].parameters['k'] == pytest.approx(2.0 * K, abs=4.0 * found[-1].stddev['k'])


def test_a_prior_contradicts_a_window_as_seldom_as_it_should() -> None:
    solver = Solver.of(LAG, EstimationSettings(noise={'y': SIGMA}))
    posed = solver.pose(pushed(NODES, 0, walk=0.0), np.array([SIGMA]), noise_known=True)
    point = solver.unknowns.point({'x': 0.5, 'k': K, 'tau': TAU})
    box = hypothesis_at(PiecewiseProblem(posed.objective, Prior.box(solver.unknowns)), point)
    assert not contradicts_prior(box)
    spread = box.covariance[1:, 1:]
    for off, contradicted in ((2.0, False), (8.0, True)):
        mean = point[1:] + off * np.sqrt(np.diagonal(spread))
        problem = replace(box.problem, prior=Prior.of(solver.unknowns, mean, spread))
        # The optimum lies half-way between what prior and window say.
        middle = np.array([point[0], *(0.5 * (point[1:] + mean))])
        assert contradicts_prior(hypothesis_at(problem, middle)) is contradicted


def test_a_prior_that_is_given_is_not_one_of_earlier_windows() -> None:
    """However wrong, it stays; and where one of earlier windows is dropped, it remains."""
    settings = EstimationSettings(noise={'y': SIGMA}, priors={'tau': (5.0, 0.01)})
    solver = Solver.of(LAG, settings)
    posed = solver.pose(pushed(NODES, 0, walk=0.0), np.array([SIGMA]), noise_known=True)
    point = solver.unknowns.point({'x': 0.5, 'k': K, 'tau': TAU})
    best = hypothesis_at(PiecewiseProblem(posed.objective, posed.prior), point)
    assert contradicts_prior(best) and not contradicts_prior(best, posed.prior)
    sharp = Prior.of(solver.unknowns, point[1:] + 0.1, 1e-6 * np.eye(2))
    other = hypothesis_at(PiecewiseProblem(posed.objective, sharp), point)
    assert contradicts_prior(other, posed.prior)


@pytest.mark.parametrize('seed', range(3))
def test_process_noise_that_earlier_windows_had_not_is_told_without_deviations(seed: int) -> None:
    """It may be a jump that was not found: only once half of the windows have it, it is usual."""
    exact = 4
    walk = np.where(np.arange(12 * NODES) < exact * NODES, 0.0, WALK)
    found = in_sequence(pushed(12 * NODES, seed, walk=walk))
    told = [np.isfinite(list(one.stddev.values())).all() for one in found]
    had = [any(size > 0.0 for size in one.walks.values()) for one in found]
    assert all(told[:exact]) and not any(had[:exact])
    assert all(had[exact:]) and not any(told[exact : exact + 2]) and all(told[-4:])
    assert all('earlier ones did not have' in one.message for one in found[exact : exact + 2])
    for one in np.array(found)[told]:
        assert abs(one.parameters['k'] - K) < 5.0 * one.stddev['k']
