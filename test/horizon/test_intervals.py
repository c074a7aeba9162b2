"""Tests of obs_ros.horizon.intervals."""

from dataclasses import replace

import numpy as np
import pytest
from plants import LAG, lag_outputs, square_wave, window_of

from obs_ros import Outcome, Record, solve_window
from obs_ros.core.deadline import Deadline
from obs_ros.core.prior_knowledge import with_knowledge
from obs_ros.horizon.intervals import with_intervals
from obs_ros.horizon.stages import uncertainty_of
from obs_ros.inference.assessment.contradiction import contradictions
from obs_ros.inference.assessment.deviations import Deviations
from obs_ros.inference.assessment.informed_subspace import marginal_information
from obs_ros.inference.assessment.interval import covariance_without_boxes
from obs_ros.inference.assessment.uncertainty import Uncertainty
from obs_ros.inference.jumps.hypothesis import hypothesis_at
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.inference.prior import Prior
from obs_ros.optimization.acceptance import Acceptance
from obs_ros.optimization.levenberg_marquardt import levenberg_marquardt
from obs_ros.optimization.result import Effort, Found

T = 0.2 * np.arange(41)
ACCEPTED = Found(
    np.full(3, 0.5), 1.0, converged=True, accepted=Acceptance.METHOD, effort=Effort(2, 'round')
)


def uncertainty(*, moving: bool, sigma: float, noise: float | None = None) -> Uncertainty:
    """That of a lag whose input moves, or of a step response that is cut off."""
    u = square_wave(T, 2.0) if moving else np.ones(T.size)
    y = lag_outputs(T, u, 0.0, np.tile([1.5, 5.0], (T.size, 1)))
    y += (noise or sigma) * np.random.default_rng(4).standard_normal(T.size)
    objective = window_of(LAG, Record(T, u, y), sigma)
    problem = PiecewiseProblem(objective, Prior.box(objective.unknowns))
    start = objective.unknowns.point({'x': 0.0, 'k': 1.5, 'tau': 5.0})
    found = levenberg_marquardt(problem, start[None], T.size, 100, Deadline())
    return uncertainty_of(hypothesis_at(problem, found.z[0]))


def test_a_rich_window_keeps_its_point_and_has_no_profiles() -> None:
    before = uncertainty(moving=True, sigma=0.01)
    found = with_intervals(before, None, ACCEPTED, Deadline())
    assert found.hypothesis is before.hypothesis and found.interval is None
    assert found.information is before.information and found.finished
    expected = covariance_without_boxes(before.hypothesis)
    np.testing.assert_array_equal(found.covariance, expected)


def test_a_poor_one_has_the_point_without_boxes_and_their_intervals() -> None:
    before = uncertainty(moving=False, sigma=0.3)
    found = with_intervals(before, None, ACCEPTED, Deadline())
    assert found.hypothesis is not before.hypothesis
    assert found.hypothesis.squares < before.hypothesis.squares - 0.1
    assert found.interval is not None and np.isfinite(found.interval.lower[0])
    # What is handed on is about the point that is published.
    expected = marginal_information(found.hypothesis, 1)
    np.testing.assert_allclose(found.information, expected, rtol=1e-9)


def test_one_that_process_noise_explains_has_them_too() -> None:
    """A tyre that nothing moved was told 90 % wrong with a deviation of 5 % without them."""
    before = replace(uncertainty(moving=False, sigma=0.3), skill=0.5)
    found = with_intervals(before, None, ACCEPTED, Deadline())
    assert found.interval is not None and np.isfinite(found.interval.lower[0])


def test_where_deviations_are_withheld_nothing_is_done() -> None:
    before = uncertainty(moving=False, sigma=0.3)
    for one, found in (
        (before, replace(ACCEPTED, accepted=None)),
        (replace(before, finished=False), ACCEPTED),
        (uncertainty(moving=False, sigma=0.01, noise=0.3), ACCEPTED),  # far from noise
    ):
        assert with_intervals(one, None, found, Deadline()) is one


def test_without_time_it_is_not_finished() -> None:
    found = with_intervals(uncertainty(moving=False, sigma=0.3), None, ACCEPTED, Deadline(0.0))
    assert not found.finished


@pytest.mark.parametrize('correlation', [0.0, 0.8])
def test_a_window_that_noise_does_not_explain_has_no_profiles(correlation: float) -> None:
    """Noise that is known as white, and is not, is no likelihood: the covariance stands."""
    draws = np.random.default_rng(6).standard_normal(T.size + 50)
    noise = np.zeros_like(draws)
    for k in range(1, draws.size):
        noise[k] = correlation * noise[k - 1] + np.sqrt(1.0 - correlation**2) * draws[k]
    u = np.ones(T.size)
    y = lag_outputs(T, u, 0.0, np.tile([1.5, 9.0], (T.size, 1))) + 0.02 * noise[50:]
    objective = window_of(LAG, Record(T, u, y), 0.02)
    problem = PiecewiseProblem(objective, Prior.box(objective.unknowns))
    start = objective.unknowns.point({'x': 0.0, 'k': 1.5, 'tau': 9.0})
    z = levenberg_marquardt(problem, start[None], T.size, 100, Deadline()).z[0]
    found = with_intervals(uncertainty_of(hypothesis_at(problem, z)), None, ACCEPTED, Deadline())
    assert (found.fit.enlargement > 1.5) == (correlation > 0.0)
    assert (found.interval is None) == (correlation > 0.0)
    if correlation:
        expected = covariance_without_boxes(found.hypothesis)
        np.testing.assert_array_equal(found.covariance, expected)


def test_at_rest_wide_priors_are_all_that_is_known() -> None:
    """Point and deviations are those of the posterior, whatever noise does to the initial state."""
    unknowns = Unknowns.of(with_knowledge(LAG, None, {'k': (2.0, 1.2), 'tau': (5.0, 4.5)}))
    for seed in range(6):
        y = 0.05 * np.random.default_rng(seed).standard_normal(T.size)
        objective = replace(window_of(LAG, Record(T, np.zeros(T.size), y), 0.05), unknowns=unknowns)
        problem = PiecewiseProblem(objective, Prior.known(unknowns, start=True))
        start = unknowns.point({'x': 0.0, 'k': 2.0, 'tau': 5.0})
        z = levenberg_marquardt(problem, start[None], T.size, 100, Deadline()).z[0]
        before = uncertainty_of(hypothesis_at(problem, z))
        found = with_intervals(before, None, ACCEPTED, Deadline())
        assert found.hypothesis is before.hypothesis  # no box pulls
        x, k, tau = unknowns.scale.values(found.hypothesis.point)
        assert x == pytest.approx(0.0, abs=0.05)
        assert k == pytest.approx(2.0, abs=1e-3)
        assert tau == pytest.approx(5.0, abs=1.5)
        deviations = np.sqrt(np.diagonal(found.covariance))[1:] * unknowns.scale.width[1:]
        assert deviations[0] == pytest.approx(1.2, rel=0.01)
        assert 3.5 < deviations[1] < 8.0
        # Of neither is it told where it lies: both intervals would be wider than the box allows.
        told = Deviations.of(found.hypothesis, found.covariance, 1.0, None, found.interval)
        assert np.isnan(told.parameters).all()
        assert contradictions(found.hypothesis) == []


def test_narrow_priors_at_rest_are_published_as_they_are() -> None:
    priors = {'k': (2.0, 0.2), 'tau': (5.0, 0.5)}
    y = 0.05 * np.random.default_rng(2).standard_normal(T.size)
    found = solve_window(LAG, Record(T, np.zeros(T.size), y), noise={'y': 0.05}, priors=priors)
    assert found.outcome is Outcome.CONVERGED
    for name, (mean, deviation) in priors.items():
        assert found.parameters[name] == pytest.approx(mean, abs=0.1 * deviation)
        assert found.stddev[name] == pytest.approx(deviation, rel=0.02)
        ends = (mean - 1.96 * deviation, mean + 1.96 * deviation)
        assert found.interval[name] == pytest.approx(ends, abs=0.1 * deviation)
