"""Tests of obs_ros.horizon.stages."""

from dataclasses import replace

import numpy as np
import pytest
from plants import LAG, lag_outputs, square_wave

from obs_ros import Record
from obs_ros.core.deadline import Deadline
from obs_ros.core.prior_knowledge import with_knowledge
from obs_ros.core.rng import random_generator
from obs_ros.horizon import stages
from obs_ros.horizon.found_jumps import Explained
from obs_ros.horizon.solver import Solver
from obs_ros.inference.assessment.contradiction import contradictions
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.inference.prior import Prior
from obs_ros.inference.window_state import WindowState
from obs_ros.optimization.acceptance import Acceptance

T = 0.1 * np.arange(400)
SIGMA = 0.05
JUMP = 200  # node
SOLVER = Solver.of(LAG)
K = SOLVER.unknowns.names.index('k')


def window(*, moving: bool = True, jump: float = 0.0, prior: Prior | None = None) -> WindowState:
    u = square_wave(T) if moving else np.zeros(T.size)
    p = np.tile([1.2, 3.0], (T.size - 1, 1))
    p[JUMP:, 0] += jump
    y = lag_outputs(T, u, 0.5 if moving else 0.0, p)
    y += SIGMA * np.random.default_rng(3).standard_normal(y.shape)
    return SOLVER.pose(Record(T, u, y), np.array([SIGMA]), prior, noise_known=True)


def fitted(posed: WindowState, warm: np.ndarray | None = None):
    return stages.fit(posed, SOLVER, warm, None, random_generator(1), Deadline())[:2]


def test_a_warm_start_that_explains_the_window_spares_the_search() -> None:
    posed, found = fitted(window())
    spent = posed.objective.evaluations
    again, warm = fitted(window(), found.z)
    assert warm.accepted is Acceptance.LIKE_NOISE
    np.testing.assert_allclose(warm.z, found.z, atol=1e-4)
    assert again.objective.evaluations < 0.3 * spent


def test_jumps_are_found_and_carry_over_to_a_window_that_holds_them_too() -> None:
    posed, found = fitted(window(jump=0.6))
    _, explanation = stages.explain(posed, found, None, Deadline())
    best = explanation.hypothesis
    assert explanation.finished and best.problem.events == ((K,),)
    shifted = Record(posed.record.t[50:], posed.record.u[50:], posed.record.y[50:])
    later = SOLVER.pose(shifted, np.array([SIGMA]), noise_known=True)
    warm = SOLVER.unknowns.point({'x': 0.0, 'k': 1.2, 'tau': 3.0})
    known = stages.continued_jumps(later, Explained.by(best), warm, Deadline())
    assert known is not None and known.problem.events == ((K,),)
    time = known.point[known.layout.times[0]]
    assert time == pytest.approx((T[JUMP] - T[50]) / (T[-1] - T[50]), abs=0.01)
    before = SOLVER.pose(
        Record(T[:100], posed.record.u[:100], posed.record.y[:100]), np.array([SIGMA]),
        noise_known=True,
    )  # fmt: skip
    assert stages.continued_jumps(before, Explained.by(best), warm, Deadline()) is None


def test_a_window_at_rest_is_uninformative_and_keeps_its_prior() -> None:
    # Near the truth: a prior that the window contradicts is explained by a jump at its begin.
    mean, covariance = np.array([0.105, 0.205]), np.diag([1e-4, 4e-4])
    prior = Prior.of(SOLVER.unknowns, mean, covariance)
    informed = []
    for moving in (True, False):
        posed, found = fitted(window(moving=moving, prior=prior))
        _, explanation = stages.explain(posed, found, None, Deadline())
        uncertainty = stages.uncertainty_of(explanation.hypothesis)
        none = np.zeros(2, dtype=np.bool_)
        alone = stages.determined_alone(uncertainty, none, Deadline())
        informed.append((stages.is_uninformative(uncertainty), alone))
        if not moving:
            np.testing.assert_allclose(uncertainty.hypothesis.point[1:], mean, atol=1e-3)
            np.testing.assert_allclose(np.diag(uncertainty.covariance)[1:], [1e-4, 4e-4], rtol=0.05)
    assert not informed[0][0] and informed[0][1].all()
    assert informed[1][0] and not informed[1][1].any()


def test_a_more_informative_prior_is_recalled_where_it_fits() -> None:
    mean = np.array([0.3, 0.6])
    wide = Prior.of(SOLVER.unknowns, mean, np.diag([1e-2, 1e-2]))
    posed, found = fitted(window(moving=False, prior=wide))
    _, explanation = stages.explain(posed, found, None, Deadline())
    uncertainty = stages.uncertainty_of(explanation.hypothesis)
    sharp = Prior.of(SOLVER.unknowns, np.array([0.35, 0.55]), np.diag([1e-5, 1e-5]))
    recalled = stages.recall(uncertainty, sharp, Deadline())
    np.testing.assert_allclose(recalled.hypothesis.point[1:], [0.35, 0.55], atol=2e-3)
    assert stages.recall(uncertainty, None, Deadline()) is uncertainty
    contradicted = replace(uncertainty.hypothesis, cost=-1e9)
    kept = replace(uncertainty, hypothesis=contradicted)
    assert stages.recall(kept, sharp, Deadline()) is kept


def test_a_wrong_prior_is_no_jump_and_a_jump_is_one_beside_it() -> None:
    """Searched without the prior, weighed with it."""
    unknowns = Unknowns.of(with_knowledge(LAG, None, {'tau': (2.5, 0.05)}))
    prior = Prior.known(unknowns, start=True)
    for size, events in ((0.0, ()), (0.6, ((K,),))):
        posed = replace(window(jump=size), prior=prior)
        posed = replace(posed, objective=replace(posed.objective, unknowns=unknowns))
        found = fitted(posed)[1]
        _, explanation = stages.explain(posed, found, None, Deadline())
        best = explanation.hypothesis
        assert best.problem.events == events
        assert best.problem.prior is prior
        places = [found.place for found in contradictions(best)]
        assert places == [unknowns.names.index('tau')]
