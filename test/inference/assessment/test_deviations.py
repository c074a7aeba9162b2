"""Tests of obs_ros.inference.assessment.deviations."""

from dataclasses import replace

import numpy as np
import pytest
from plants import INTEGRATOR, LAG, integrator_design, lag_outputs, square_wave, window_of

from obs_ros import Outcome, Record, solve_window
from obs_ros.core.residual_tests import inflation_by
from obs_ros.inference.assessment.deviations import Deviations
from obs_ros.inference.assessment.interval import Interval
from obs_ros.inference.assessment.uncertainty import AtEnd
from obs_ros.inference.jumps.hypothesis import Hypothesis, hypothesis_at
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.prior import Prior

T = 0.1 * np.arange(61)
U = square_wave(T, 0.9)
SIGMA = 0.05
TRUTH = {'x': 1.0, 'gain': 1.3, 'drift': -0.4}


def record(seed: int = 0) -> Record:
    y = integrator_design(T, U) @ list(TRUTH.values())
    return Record(T, U, y + SIGMA * np.random.default_rng([seed, 4]).standard_normal(T.size))


def hypothesis(*events: tuple[int, ...], **settings: object) -> Hypothesis:
    objective = window_of(INTEGRATOR, record(), SIGMA, **settings)
    point = [*objective.unknowns.point(TRUTH), *[v for e in events for v in (0.5, *[0.6] * len(e))]]
    problem = PiecewiseProblem(objective, Prior.box(objective.unknowns), events)
    return hypothesis_at(problem, np.array(point))


def test_units_and_propagation_to_the_end() -> None:
    covariance = np.diag([0.01, 0.02, 0.03]) ** 2
    covariance[0, 1] = covariance[1, 0] = 1e-4
    found = Deviations.of(hypothesis(), covariance, 1.0)
    np.testing.assert_allclose(found.initial, [0.2])
    np.testing.assert_allclose(found.parameters, [0.04, 0.06])
    # x(end) is the last row of the design.
    g = integrator_design(T, U)[-1] * [20.0, 2.0, 2.0]
    np.testing.assert_allclose(found.state, np.sqrt(g @ covariance @ g), rtol=1e-6)
    doubled = Deviations.of(hypothesis(), covariance, 4.0)
    np.testing.assert_allclose(doubled.state, 2.0 * found.state)
    np.testing.assert_allclose(doubled.parameters, 2.0 * found.parameters)


COVARIANCE = np.diag([0.01, 0.02, 0.03]) ** 2
END = float(integrator_design(T, U)[-1] @ list(TRUTH.values()))


def interval(
    gain: tuple[float, float, float] = (0.62, 0.65, 0.7),
    drift: tuple[float, float, float] = (0.25, 0.3, 0.36),
    states: tuple[float, float] = (END - 0.2, END + 0.1),
) -> Interval:
    """Lower end, middle and upper end of gain and drift, in boxes; the truth is in the middle."""
    lower, middle, upper = np.array([gain, drift]).T
    return Interval(lower, middle, upper, np.array(states)[:, None])


class TestIntervals:
    def test_without_profiles_they_are_those_of_the_deviations(self) -> None:
        found = Deviations.of(hypothesis(), COVARIANCE, 1.0)
        middle = np.array([END, 1.3, -0.4])
        sd = np.concatenate([found.state, found.parameters])
        np.testing.assert_allclose(found.lower, middle - 1.96 * sd, rtol=1e-3, atol=1e-6)
        np.testing.assert_allclose(found.upper, middle + 1.96 * sd, rtol=1e-3, atol=1e-6)
        assert found.interval(1) == (found.lower[1], found.upper[1])

    def test_they_end_at_the_box(self) -> None:
        best = hypothesis()
        best.point[1] = 0.99
        found = Deviations.of(best, COVARIANCE, 1.0)
        assert found.upper[1] == 2.0
        assert found.lower[1] == pytest.approx(1.98 - 1.96 * 0.04, abs=1e-3)

    def test_with_profiles_the_larger_half_tells_the_deviation(self) -> None:
        found = Deviations.of(hypothesis(), COVARIANCE, 1.0, interval=interval())
        np.testing.assert_allclose(found.lower[1:], [1.24, -0.5])
        np.testing.assert_allclose(found.upper[1:], [1.4, -0.28])
        np.testing.assert_allclose(found.parameters, [0.1 / 1.96, 0.12 / 1.96], rtol=1e-4)
        # In them the growth of the cost has counted already.
        again = Deviations.of(hypothesis(), COVARIANCE, 4.0, interval=interval())
        np.testing.assert_allclose(again.parameters, found.parameters)

    def test_the_diagonal_of_the_joint_covariance_is_theirs(self) -> None:
        correlated = COVARIANCE.copy()
        correlated[1, 2] = correlated[2, 1] = 3e-4
        best = hypothesis()
        found = Deviations.of(best, correlated, 1.0, interval=interval())
        sd = np.concatenate([found.state, found.parameters])
        np.testing.assert_allclose(np.diagonal(found.joint), sd**2, rtol=1e-9)
        # Correlations stay those of the linear sum.
        plain = best.covariance[1:, 1:]
        expected = plain[0, 1] / np.sqrt(plain[0, 0] * plain[1, 1])
        assert found.joint[1, 2] / (sd[1] * sd[2]) == pytest.approx(expected, rel=1e-6)
        assert np.linalg.eigvalsh(found.joint)[0] > -1e-12

    def test_lower_and_upper_ends_lie_around_the_value(self) -> None:
        """Random intervals, seeds 0 to 19."""
        for seed in range(20):
            off = np.random.default_rng(seed).uniform(0.0, 0.1, 4)
            given = interval(
                (0.65 - off[0], 0.65, 0.65 + off[1]), (0.3 - off[2], 0.3, 0.3 + off[3])
            )
            found = Deviations.of(hypothesis(), COVARIANCE, 1.0, interval=given)
            value = np.array([END, 1.3, -0.4])
            assert (found.lower <= value + 1e-6).all() and (value <= found.upper + 1e-6).all()

    def test_where_a_profile_has_no_end_nothing_is_told(self) -> None:
        given = interval(gain=(np.nan, 0.65, 0.7))
        found = Deviations.of(hypothesis(), COVARIANCE, 1.0, interval=given)
        np.testing.assert_allclose(found.parameters, [np.nan, 0.12 / 1.96], rtol=1e-4)
        assert np.isnan(found.interval(1)).all()
        assert found.interval(2) == pytest.approx((-0.5, -0.28))

    def test_wider_than_four_tenths_of_the_box_neither(self) -> None:
        for half, told in ((0.19, True), (0.2, False)):
            given = interval(gain=(0.65 - half, 0.65, 0.65 + half))
            found = Deviations.of(hypothesis(), COVARIANCE, 1.0, interval=given)
            assert np.isfinite(found.parameters[0]) == told
            assert np.isfinite(found.interval(1)).all() == told

    def test_states_lie_between_those_at_the_ends(self) -> None:
        best = hypothesis()
        narrow = Deviations.of(best, COVARIANCE, 1.0, interval=interval(states=(END, END)))
        plain = 1.96 * np.sqrt(
            best.linearisation.state_jacobian[0] @ best.covariance
            @ best.linearisation.state_jacobian[0]
        )  # fmt: skip
        # No less than what noise alone leaves there.
        assert narrow.upper[0] - END == pytest.approx(plain, rel=1e-3)
        wide = Deviations.of(
            best, COVARIANCE, 1.0, interval=interval(states=(END - 0.1, END + 0.7))
        )
        assert wide.interval(0) == pytest.approx((END - max(plain, 0.1), END + 0.7), abs=1e-3)
        assert wide.state[0] == pytest.approx(0.7 / 1.96, rel=1e-3)
        assert wide.joint[0, 0] == pytest.approx(wide.state[0] ** 2, rel=1e-9)

    def test_what_pushes_at_the_end_is_added_to_that(self) -> None:
        end = AtEnd(np.diag([0.09, 0.0, 0.0]))
        given = interval(states=(END - 1.0, END + 1.0))
        found = Deviations.of(hypothesis(), COVARIANCE, 1.0, end, given)
        expected = np.sqrt(1.0 + 1.96**2 * 0.09)
        assert found.upper[0] - END == pytest.approx(expected, rel=1e-3)
        assert END - found.lower[0] == pytest.approx(expected, rel=1e-3)

    def test_on_a_log_scale_they_are_ratios(self) -> None:
        gain = replace(INTEGRATOR.parameters[0], lower=0.2, upper=5.0, scale='log')
        model = replace(INTEGRATOR, parameters=(gain, INTEGRATOR.parameters[1]))
        objective = window_of(model, record(), SIGMA)
        problem = PiecewiseProblem(objective, Prior.box(objective.unknowns))
        best = hypothesis_at(problem, objective.unknowns.point(TRUTH))
        middle = float(best.point[1])
        given = interval(gain=(middle - 0.05, middle, middle + 0.05))
        for one in (given, None):
            covariance = np.diag([0.01, 0.05 / 1.96, 0.03]) ** 2
            found = Deviations.of(best, covariance, 1.0, interval=one)
            ratio = 25.0**0.05
            assert found.interval(1) == pytest.approx((1.3 / ratio, 1.3 * ratio), rel=1e-4)
            assert found.parameters[0] == pytest.approx(1.3 * (ratio - 1.0) / 1.96, rel=1e-3)

    def test_what_is_given_has_no_length(self) -> None:
        best = hypothesis(fixed={'gain': 1.3})
        given = Interval(np.array([0.25]), np.array([0.3]), np.array([0.36]), np.zeros((2, 1)))
        found = Deviations.of(best, np.diag([1e-4, 9e-4]), 1.0, interval=given)
        assert found.interval(1) == (1.3, 1.3)
        assert found.parameters[0] == 0.0
        np.testing.assert_array_equal(found.joint[1], 0.0)


def test_after_a_jump_it_is_the_value_at_the_end_that_counts() -> None:
    covariance = np.diag([0.01, 0.02, 0.03, 0.01, 0.005]) ** 2
    found = Deviations.of(hypothesis((2,)), covariance, 1.0)
    np.testing.assert_allclose(found.parameters, [0.04, 0.01])
    np.testing.assert_allclose(np.diagonal(found.joint)[1:], [0.04**2, 0.01**2])


def test_the_joint_covariance_is_that_of_end_state_and_parameters() -> None:
    rng = np.random.default_rng(5)
    root = 0.01 * rng.standard_normal((3, 3))
    covariance, end = root @ root.T, AtEnd(np.diag([0.04, 0.0, 0.0]))
    found = Deviations.of(hypothesis(), covariance, 2.0, end)
    # End state, gain and drift by (x(0), gain, drift) in boxes, by the last row of the design.
    rows = np.vstack([integrator_design(T, U)[-1], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    rows = rows * [20.0, 2.0, 2.0]
    expected = rows @ covariance @ rows.T
    expected[0, 0] += 0.04
    np.testing.assert_allclose(found.joint, 2.0 * expected, rtol=1e-6, atol=1e-12)
    deviations = np.concatenate([found.state, found.parameters])
    np.testing.assert_allclose(deviations, np.sqrt(np.diagonal(found.joint)), rtol=1e-12)


def test_parameters_that_walk_are_those_at_the_end() -> None:
    covariance = np.diag([0.01, 0.02, 0.03]) ** 2
    jacobian = np.array([[0.1, 0.4, 0.0], [0.0, 0.0, 2.0]])
    end = AtEnd(np.diag([0.0, 0.01, 0.0]), np.array([1.0, 0.2]), jacobian)
    found = Deviations.of(hypothesis(), covariance, 1.0, end)
    rows = jacobian @ covariance @ jacobian.T + end.covariance[1:, 1:]
    np.testing.assert_allclose(found.joint[1:, 1:], rows)
    np.testing.assert_allclose(found.parameters, np.sqrt(np.diagonal(rows)))
    # No interval leads beyond a bound; the longer side is the deviation's.
    near = replace(end, parameters=np.array([1.99, 0.2]))
    found = Deviations.of(hypothesis(), covariance, 1.0, near)
    assert found.upper[1] == 2.0 and found.lower[1] < 1.98
    np.testing.assert_allclose(found.parameters, np.sqrt(np.diagonal(rows)))


def test_above_a_tenth_of_the_box_it_is_withheld() -> None:
    found = Deviations.of(hypothesis(), np.diag([0.0999, 0.1001, 0.0999]) ** 2, 1.0)
    np.testing.assert_allclose(found.initial, [1.998])
    np.testing.assert_allclose(found.parameters, [np.nan, 0.1998])
    assert np.isnan(found.state)  # 2.2 of 20


def test_what_is_given_has_none() -> None:
    best = hypothesis(fixed={'x': 1.0, 'gain': 1.3})
    found = Deviations.of(best, np.array([[1e-4]]), 1.0)
    np.testing.assert_array_equal(found.initial, [0.0])
    np.testing.assert_allclose(found.parameters, [0.0, 0.02])
    np.testing.assert_allclose(found.state, [0.02 * 6.0])
    np.testing.assert_allclose(found.joint[:, 1], 0.0)


def test_withheld_are_all() -> None:
    found = Deviations.withheld(LAG)
    assert [v.shape for v in (found.initial, found.state, found.parameters)] == [(1,), (1,), (2,)]
    assert np.isnan([*found.initial, *found.state, *found.parameters]).all()
    assert found.joint.size == 0


def test_inflation_is_that_of_autoregressive_noise() -> None:
    """The mean of N values has variance (1 + r) / (1 - r) / N; 2000 means of 500, seed 1."""
    r = 0.5
    white = np.random.default_rng(1).standard_normal((600, 2000))
    noise = np.zeros_like(white)
    for k in range(1, 600):
        noise[k] = r * noise[k - 1] + white[k]
    noise = noise[100:] * np.sqrt(1.0 - r**2)
    expected = 500.0 * noise.mean(axis=0).var()
    found = np.median([inflation_by(column[:, None]) for column in noise.T[:200]])
    assert found == pytest.approx(expected, rel=0.15)
    # Against noise that is known to be as correlated, or more, it is nothing.
    against = [inflation_by(column[:, None], r) for column in noise.T[:200]]
    assert np.mean(np.array(against) > 1.0) < 0.02
    assert max(inflation_by(column[:, None], 0.9) for column in noise.T[:200]) == 1.0
    # Lag 1 does not tell of a slow drift below white noise.
    drift = np.zeros((1000, 20))
    steps = np.random.default_rng(2).standard_normal(drift.shape)
    for k in range(1, len(drift)):
        drift[k] = 0.95 * drift[k - 1] + np.sqrt(1.0 - 0.95**2) * steps[k]
    mixed = (drift + np.random.default_rng(4).standard_normal(drift.shape)) / np.sqrt(2.0)
    lag = 0.5 * 0.95
    needed = 0.5 + 0.5 * (1.0 + 0.95) / (1.0 - 0.95)
    total = [inflation_by(column[:, None], lag) * (1.0 + lag) / (1.0 - lag) for column in mixed.T]
    assert np.median(total) > 0.5 * needed
    less = np.median([inflation_by(column[:, None], 0.2) for column in noise.T[:200]])
    assert less == pytest.approx(expected / 1.5, rel=0.15)


def test_white_or_negative_correlation_inflates_nothing() -> None:
    rng = np.random.default_rng(3)
    white = rng.standard_normal((400, 1))
    assert inflation_by(white) == 1.0
    assert inflation_by(np.diff(white, axis=0)) == 1.0  # lag-1 correlation -0.5
    assert inflation_by(np.zeros((5, 1))) == 1.0
    assert inflation_by(np.full((5, 2), np.nan)) == 1.0


@pytest.mark.parametrize('known', [True, False])
def test_standard_deviations_cover_the_truth(known: bool) -> None:
    """Seeds 0 to 199 of the integrator: the truth within 1.96 of them 95 times in 100.

    Each of four numbers at least 181 and at most 198 of 200 times: luck leaves that range once in
    500 cases.
    """
    design = integrator_design(T, U)[-1]
    end = float(design @ list(TRUTH.values()))
    covered = np.zeros(4)
    for seed in range(200):
        noise = {'y': SIGMA} if known else None
        found = solve_window(INTEGRATOR, record(seed), noise=noise, seed=seed)
        errors = [found.initial_state['x'] - 1.0, found.state['x'] - end]
        errors += [found.parameters[name] - TRUTH[name] for name in ('gain', 'drift')]
        deviations = [found.initial_stddev['x'], *(found.stddev[n] for n in TRUTH)]
        covered += np.abs(errors) < 1.96 * np.array(deviations)
    assert (covered >= 181).all(), covered
    assert (covered <= 198).all(), covered


def test_fixed_values_have_a_deviation_of_zero() -> None:
    u = square_wave(T, 2.0)
    y = lag_outputs(T, u, 0.5, np.tile([2.0, 4.0], (60, 1)))
    y += 0.01 * np.random.default_rng(1).standard_normal(61)
    fixed = {'x': 0.5, 'k': 2.0}
    found = solve_window(LAG, Record(T, u, y), noise={'y': 0.01}, fixed=fixed)
    assert found.outcome is Outcome.CONVERGED
    assert (found.initial_stddev['x'], found.stddev['k']) == (0.0, 0.0)
    assert 0.0 < found.stddev['tau'] < 0.1
    assert 0.0 < found.stddev['x'] < 0.01  # at the end, tau tells


def test_beside_others_that_explain_as_much_deviations_hold_them_too() -> None:
    """The excess is of the state in its unit and of gain and drift in boxes, which are 2 wide."""
    best = hypothesis()
    alone = Deviations.of(best, np.diag([0.001, 0.02, 0.03]) ** 2, 1.0)
    excess = np.diag([0.3, 0.015, 0.02]) ** 2
    excess[0, 2] = excess[2, 0] = 1e-3
    found = alone.beside(best, excess)
    np.testing.assert_allclose(found.state**2, alone.state**2 + 0.09)
    np.testing.assert_allclose(found.parameters, [0.05, 2.0 * (0.03**2 + 0.02**2) ** 0.5])
    np.testing.assert_allclose(found.joint[0, 2] - alone.joint[0, 2], 2e-3)
    np.testing.assert_allclose(found.initial, alone.initial)
    # Above a tenth of the box nothing is determined any more.
    wide = alone.beside(best, np.diag([0.0, 0.0, 0.1]) ** 2)
    assert np.isnan(wide.parameters).tolist() == [False, True]
    # None leads beyond a bound.
    best.point[1] = 0.98
    near = Deviations.of(best, np.diag([0.001, 0.01, 0.03]) ** 2, 1.0).beside(best, excess)
    assert near.upper[1] == 2.0 and near.lower[1] < 1.96


def test_rivals_that_are_surer_make_nothing_surer() -> None:
    """Their excess is negative: an interval may shrink by that to nothing."""
    best = hypothesis()
    alone = Deviations.of(best, np.diag([0.001, 0.02, 0.03]) ** 2, 1.0)
    found = alone.beside(best, np.diag([-1.0, -0.01, 0.0004]))
    np.testing.assert_allclose(found.state, alone.state)
    np.testing.assert_allclose(found.lower[:2], alone.lower[:2])
    np.testing.assert_allclose(found.parameters, [0.04, 2.0 * (0.03**2 + 0.02**2) ** 0.5])
    assert np.linalg.eigvalsh(found.joint).min() > -1e-12
