"""Tests of obs_ros.horizon.scatter."""

import numpy as np
import pytest
from plants import LAG, lag_outputs, square_wave, window_of

from obs_ros import Record
from obs_ros.core.deadline import Deadline
from obs_ros.core.prior_knowledge import with_knowledge
from obs_ros.horizon.scatter import SCATTER, Alone, Scatter, raised, widened
from obs_ros.inference.assessment.informed_subspace import marginal_information
from obs_ros.inference.assessment.interval import Interval
from obs_ros.inference.assessment.uncertainty import Uncertainty
from obs_ros.inference.jumps.hypothesis import hypothesis_at
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.inference.prior import Posterior, Prior
from obs_ros.optimization.levenberg_marquardt import levenberg_marquardt

T = 0.1 * np.arange(300)


def alone(k: int, spread: float, rng: np.random.Generator, step: float = 1.0) -> Alone:
    """A window of one second, the k-th, whose mean is off by `spread` of its deviations."""
    return Alone(
        step * k, step * k + 1.0, 0.5 + 0.01 * spread * rng.standard_normal(2), np.full(2, 0.01)
    )


def uncertainty(prior: Prior | None = None) -> Uncertainty:
    u = square_wave(T)
    y = lag_outputs(T, u, 1.0, np.tile([1.2, 3.0], (T.size, 1))).reshape(-1, 1)
    y += 0.02 * np.random.default_rng(0).standard_normal(y.shape)
    objective = window_of(LAG, Record(T, u, y), 0.02)
    prior = prior or Prior.box(objective.unknowns)
    start = objective.unknowns.point({'x': 1.0, 'k': 1.2, 'tau': 3.0})
    solved = levenberg_marquardt(Posterior(objective, prior), start[None], T.size, 60, Deadline())
    best = hypothesis_at(PiecewiseProblem(objective, prior), solved.z[0])
    return Uncertainty(best, best.covariance, marginal_information(best, 1))


def test_a_window_alone_is_what_it_would_be_without_its_prior() -> None:
    free = uncertainty()
    unknowns = free.hypothesis.problem.objective.unknowns
    mean = free.hypothesis.point[1:] + 3.0 * np.sqrt(np.diagonal(free.covariance)[1:])
    prior = Prior.of(unknowns, mean, 2.0 * free.covariance[1:, 1:])
    pulled = uncertainty(prior)
    shift = pulled.hypothesis.point[1:] - free.hypothesis.point[1:]
    assert (np.abs(shift) > 0.5 * np.sqrt(np.diagonal(free.covariance)[1:])).any()
    expected, found = Alone.of(free, 1.0), Alone.of(pulled, 1.0)
    assert (found.start, found.end) == (T[0], T[-1])
    np.testing.assert_allclose(found.deviation, expected.deviation, rtol=0.05)
    assert (np.abs(found.mean - expected.mean) < 0.3 * expected.deviation).all()


def test_colour_widens_a_window_alone() -> None:
    found = uncertainty()
    ratio = Alone.of(found, 4.0).deviation / Alone.of(found, 1.0).deviation
    np.testing.assert_allclose(ratio, 2.0)


@pytest.mark.parametrize('spread', [1.0, 3.0])
def test_the_factor_is_how_much_more_windows_scatter_than_they_say(spread: float) -> None:
    found = []
    for seed in range(100):
        rng, scatter = np.random.default_rng([seed, 1]), Scatter()
        for k in range(25):
            scatter.add(alone(k, spread, rng))
        factors = scatter.factors()
        assert factors is not None
        found.append(factors)
    assert np.sqrt(np.mean(np.square(found))) == pytest.approx(spread, rel=0.05)


def test_windows_that_overlap_count_once() -> None:
    """Of windows a quarter of their length apart, every fourth is compared."""
    rng, scatter = np.random.default_rng(0), Scatter()
    windows = [alone(k, 1.0, rng, step=0.25) for k in range(4 * (SCATTER.fewest - 1))]
    for window in windows:
        scatter.add(window)
    assert scatter.factors() is None
    last = alone(len(windows), 1.0, rng, step=0.25)
    scatter.add(last)
    means = np.array([one.mean for one in (*windows[::4], last)])
    # Of an even number of like weights the lower one of both in the middle.
    middle = np.sort(means, axis=0)[(len(means) - 1) // 2]
    expected = np.sqrt(np.sum((means - middle) ** 2, axis=0) / (len(means) - 1)) / 0.01
    np.testing.assert_allclose(scatter.factors(), expected)


def test_a_window_far_off_counts_for_three_deviations_only() -> None:
    rng, scatter = np.random.default_rng(4), Scatter()
    for k in range(12):
        scatter.add(alone(k, 1.0, rng))
    usual = scatter.factors()
    scatter.add(Alone(12.0, 13.0, np.array([0.9, 0.5]), np.full(2, 0.01)))  # 40 deviations off
    factors = scatter.factors()
    assert usual is not None and factors is not None
    assert usual[0] < factors[0] < np.sqrt(usual[0] ** 2 + 1.6)


def test_parameters_that_too_few_windows_determine_have_no_factor() -> None:
    rng, scatter = np.random.default_rng(0), Scatter()
    for k in range(SCATTER.fewest):
        one = alone(k, 1.0, rng)
        if k == 1:
            one.mean[1] = one.deviation[1] = np.nan
        scatter.add(one)
    factors = scatter.factors()
    assert factors is not None
    assert np.isfinite(factors[0]) and np.isnan(factors[1])


def test_a_jump_makes_windows_before_it_count_no_more() -> None:
    rng, scatter = np.random.default_rng(0), Scatter()
    for k in range(10):
        scatter.add(alone(k, 1.0, rng))
    scatter.forget()
    assert scatter.factors() is None


def test_deviations_are_raised_and_never_lowered() -> None:
    covariance = np.array([[1.0, 0.5, 0.1], [0.5, 4.0, 0.2], [0.1, 0.2, 9.0]])
    assert raised(covariance, np.array([1, 2]), None) is covariance
    found = raised(covariance, np.array([1, 2]), np.array([3.0, 0.2]))
    np.testing.assert_allclose(np.sqrt(np.diagonal(found)), [1.0, 6.0, 3.0])
    assert found[0, 1] == 1.5 and found[1, 2] == pytest.approx(0.6)
    nothing = raised(covariance, np.array([1, 2]), np.array([np.nan, 2.0]))
    np.testing.assert_allclose(np.sqrt(np.diagonal(nothing)), [1.0, 2.0, 6.0])


def test_a_window_alone_is_without_given_priors_too() -> None:
    free = uncertainty()
    model = with_knowledge(LAG, None, {'k': (1.25, 0.02), 'tau': (2.9, 0.05)})
    pulled = uncertainty(Prior.known(Unknowns.of(model), start=True))
    deviations = np.sqrt(np.diagonal(free.covariance)[1:])
    assert (np.sqrt(np.diagonal(pulled.covariance)[1:]) < 0.99 * deviations).any()
    expected, found = Alone.of(free, 1.0), Alone.of(pulled, 1.0)
    np.testing.assert_allclose(found.deviation, expected.deviation, rtol=0.05)
    assert (np.abs(found.mean - expected.mean) < 0.3 * expected.deviation).all()


def test_intervals_widen_with_the_scatter_and_never_shrink() -> None:
    lower, middle, upper = np.array([[0.2, 0.3, 0.5], [0.1, 0.5, 0.9], [0.3, 0.4, 0.6]]).T
    interval = Interval(lower, middle, upper, np.zeros((2, 1)))
    found = widened(interval, np.array([2.0, 0.5, np.nan]))
    assert found is not None
    np.testing.assert_allclose(found.lower, [0.1, 0.1, 0.3])
    np.testing.assert_allclose(found.upper, [0.7, 0.9, 0.6])
    assert widened(interval, None) is interval
    assert widened(None, np.ones(3)) is None
