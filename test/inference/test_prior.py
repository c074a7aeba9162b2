"""Tests of obs_ros.inference.prior."""

import numpy as np
import pytest
from plants import INTEGRATOR, OSCILLATOR, integrator_design, square_wave, window_of

from obs_ros import Record
from obs_ros.core.deadline import Deadline
from obs_ros.core.linear_algebra import scaled_inverse
from obs_ros.core.prior_knowledge import with_knowledge
from obs_ros.core.typing import Array
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.inference.prior import Posterior, Prior
from obs_ros.optimization.levenberg_marquardt import levenberg_marquardt

BOTH = Unknowns.of(INTEGRATOR)
SIGMA = 0.05
WIDTH = np.array([20.0, 2.0, 2.0])
LOWER = np.array([-10.0, 0.0, -1.0])


def window(start: float, seed: int, nodes: int = 61) -> Record:
    t = start + 0.1 * np.arange(nodes)
    u = square_wave(t)
    y = integrator_design(t, u) @ [1.0 + start, 1.3, -0.4]
    return Record(t, u, y + SIGMA * np.random.default_rng(seed).standard_normal(nodes))


def scaled(record: Record) -> tuple[Array, Array]:
    """Design (K, 3) in boxes and target (K,), in units of the noise."""
    design = integrator_design(record.t, record.u[:, 0])
    return design * WIDTH / SIGMA, (record.y[:, 0] - design @ LOWER) / SIGMA


def test_the_precision_is_the_inverse_of_the_covariance() -> None:
    covariance = np.array([[4e-4, 3e-4], [3e-4, 9e-4]])
    prior = Prior.of(BOTH, np.array([0.6, 0.3]), covariance)
    np.testing.assert_allclose(prior.precision[1:, 1:], np.linalg.inv(covariance), rtol=1e-9)
    # Of the initial state hardly anything is known: a standard deviation of 10 boxes.
    np.testing.assert_allclose(prior.precision[0], [0.01, 0.0, 0.0])
    np.testing.assert_array_equal(prior.precision[1:, 0], 0.0)
    np.testing.assert_array_equal(prior.mean, [0.5, 0.6, 0.3])


def test_no_direction_is_known_less_than_that_it_lies_in_its_box() -> None:
    prior = Prior.of(BOTH, np.array([0.6, 0.3]), np.diag([4.0, 1e-3]))
    np.testing.assert_allclose(np.diagonal(prior.precision)[1:], [12.0, 1e3])
    # Along the diagonal 1 is too much, across it 1e-3 is not.
    along, across = np.array([1.0, 1.0]) / 2**0.5, np.array([1.0, -1.0]) / 2**0.5
    covariance = np.outer(along, along) + 1e-3 * np.outer(across, across)
    precision = Prior.of(BOTH, np.array([0.6, 0.3]), covariance).precision[1:, 1:]
    assert along @ precision @ along == pytest.approx(12.0)
    assert across @ precision @ across == pytest.approx(1e3)


def test_nothing_is_known_exactly() -> None:
    prior = Prior.of(BOTH, np.array([0.6, 0.3]), np.zeros((2, 2)))
    np.testing.assert_allclose(np.diagonal(prior.precision)[1:], 12e12)


def test_the_prior_of_a_box_has_its_variance() -> None:
    prior = Prior.box(BOTH)
    np.testing.assert_allclose(prior.mean, 0.5)
    np.testing.assert_allclose(prior.precision, np.diag([0.01, 12.0, 12.0]))


def test_where_there_is_no_bound_a_parameter_may_be_far_away() -> None:
    unknowns = Unknowns.of(INTEGRATOR, bounds={'drift': (0.0, np.inf)})
    np.testing.assert_allclose(unknowns.box_variances, [1.0 / 12.0, 100.0])
    np.testing.assert_allclose(np.diagonal(Prior.box(unknowns).precision), [0.01, 12.0, 0.01])


def test_only_what_is_estimated_has_a_prior() -> None:
    assert Prior.box(Unknowns.of(INTEGRATOR, fixed={'gain': 1.0})).mean.shape == (2,)
    no_states = Prior.box(Unknowns.of(INTEGRATOR, fixed={'x': 1.0}))
    np.testing.assert_allclose(no_states.precision, 12.0 * np.eye(2))
    no_parameters = Prior.box(Unknowns.of(INTEGRATOR, parameters=[]))
    np.testing.assert_allclose(no_parameters.precision, [[0.01]])


def test_squares_and_half_their_gradient() -> None:
    prior = Prior.of(BOTH, np.array([0.6, 0.3]), np.array([[4e-3, 3e-3], [3e-3, 9e-3]]))
    z = np.random.default_rng(1).uniform(size=(5, 3))
    off = z - [0.5, 0.6, 0.3]
    # The inverse by hand; its larger variance, 0.0104, is below that of a box.
    a, b = off[:, 1], off[:, 2]
    expected = 0.01 * off[:, 0] ** 2 + (9.0 * a**2 - 6.0 * a * b + 4.0 * b**2) / 0.027
    np.testing.assert_allclose(prior.squares(z), expected)
    for i in range(3):
        step = np.zeros(3)
        step[i] = 1e-5
        slope = (prior.squares(z + step) - prior.squares(z - step)) / 2e-5
        np.testing.assert_allclose(2.0 * prior.gradient(z)[:, i], slope, rtol=1e-6, atol=1e-9)


def test_a_posterior_adds_the_squares_at_the_last_node(backend: str) -> None:
    t = np.linspace(0.0, 2.0, 31)
    y = np.column_stack([np.cos(t), np.sin(t)])
    objective = window_of(OSCILLATOR, Record(t, np.sin(t), y), 0.1, backend)
    prior = Prior.box(objective.unknowns)
    posterior = Posterior(objective, prior)
    z = np.random.default_rng(2).uniform(0.1, 0.9, (4, 4))
    added = 12.0 * ((z[:, 2:] - 0.5) ** 2).sum(axis=1) + 0.01 * ((z[:, :2] - 0.5) ** 2).sum(axis=1)
    np.testing.assert_allclose(posterior.costs(z), objective.costs(z) + added, rtol=1e-12)
    prefixes = np.array([5, 20, 31])
    blocks = posterior.block_squares(z, prefixes)
    np.testing.assert_allclose(blocks[:2], objective.block_squares(z, prefixes)[:2])
    np.testing.assert_allclose(blocks.sum(axis=0), posterior.costs(z), rtol=1e-12)
    squares, gradient, hessian = posterior.linearise(z, np.full_like(z, 1e-7), 31)
    np.testing.assert_allclose(squares, posterior.costs(z), rtol=1e-9)
    for i in range(4):
        step = np.zeros(4)
        step[i] = 1e-5
        slope = (posterior.costs(z + step) - posterior.costs(z - step)) / 2e-5
        np.testing.assert_allclose(2.0 * gradient[:, i], slope, rtol=1e-4, atol=1e-2)
    only = objective.linearise(z, np.full_like(z, 1e-7), 31)[2]
    np.testing.assert_allclose(hessian - only, np.tile(prior.precision, (4, 1, 1)), atol=1e-8)
    assert (posterior.dimension, posterior.nodes, posterior.count(31)) == (4, 31, 62)


def test_a_prior_and_a_window_tell_what_both_windows_tell_at_once() -> None:
    """Against batch least squares over (x1, x2, gain, drift)."""
    first, second = window(0.0, 1), window(6.1, 2)
    prior, means = Prior.box(BOTH), []
    for record in (first, second):
        posterior = Posterior(window_of(INTEGRATOR, record, SIGMA), prior)
        start = np.full((1, 3), 0.5)
        solved = levenberg_marquardt(posterior, start, 61, 60, Deadline())
        hessian = posterior.linearise(solved.z, np.full((1, 3), 1e-6), 61)[2][0]
        covariance = scaled_inverse(hessian)
        means.append(solved.z[0])
        prior = Prior.of(BOTH, solved.z[0, 1:], covariance[1:, 1:])
    (a, ya), (b, yb) = scaled(first), scaled(second)
    design = np.zeros((122, 4))
    design[:61, [0, 2, 3]], design[61:, [1, 2, 3]] = a, b
    before = np.diag([0.01, 0.01, 12.0, 12.0])
    batch = np.linalg.inv(design.T @ design + before)
    best = batch @ (design.T @ np.concatenate([ya, yb]) + before @ np.full(4, 0.5))
    deviations = np.sqrt(np.diagonal(batch))
    assert np.abs((means[1] - best[1:]) / deviations[1:]).max() < 0.01
    np.testing.assert_allclose(prior.precision[1:, 1:], np.linalg.inv(batch[2:, 2:]), rtol=1e-5)
    # What one window alone says is farther away.
    assert np.abs((means[0][1:] - best[2:]) / deviations[2:]).max() > 0.1


def known(**priors: tuple[float, float]) -> Unknowns:
    return Unknowns.of(with_knowledge(INTEGRATOR, None, priors))


def test_where_nothing_is_given_it_is_the_box_bit_for_bit() -> None:
    box = Prior.box(BOTH)
    for found in (Prior.known(BOTH, start=True), Prior.known(BOTH, start=False)):
        assert found.given is None
        np.testing.assert_array_equal(found.mean, box.mean)
        np.testing.assert_array_equal(found.precision, box.precision)


def test_given_priors_stand_beside_boxes() -> None:
    unknowns = known(x=(2.0, 0.5), gain=(1.2, 0.1))
    found, box = Prior.known(unknowns, start=True), Prior.box(unknowns)
    assert found.given is not None
    np.testing.assert_allclose(found.mean, [0.6, 0.6, 0.5])
    expected = [(20.0 / 0.5) ** 2, (2.0 / 0.1) ** 2, 12.0]
    np.testing.assert_allclose(found.precision, np.diag(expected))
    np.testing.assert_allclose(found.given, [1600.0 - 0.01, 400.0 - 12.0, 0.0])
    assert found.precision[2, 2] == box.precision[2, 2]
    assert found.gives({0}) and found.gives([2, 1]) and not found.gives({2}) and not box.gives({1})
    np.testing.assert_allclose(found.information(2), np.diag([388.0, 0.0]))
    assert not box.information(2).any() and box.information(2).shape == (2, 2)
    later = Prior.known(unknowns, start=False)
    np.testing.assert_allclose(np.diagonal(later.precision), [0.01, 400.0, 12.0])
    assert Prior.known(unknowns, start=False, jumped=np.array([1])).given is None
    alone = found.without_boxes
    np.testing.assert_allclose(alone.precision, np.diag([1600.0, 400.0, 0.0]))


def test_a_given_prior_is_no_wider_than_its_box_and_no_narrower_than_rounding() -> None:
    found = Prior.known(known(gain=(1.0, 50.0), drift=(0.5, 1e-12)), start=True)
    assert found.given is not None
    np.testing.assert_allclose(np.diagonal(found.precision)[1:], [12.0, 12e12])
    np.testing.assert_allclose(found.given, [0.0, 0.0, 12e12])
    np.testing.assert_allclose(found.mean, [0.5, 0.5, 0.75])


def test_given_priors_are_independent_of_all_else() -> None:
    unknowns = known(drift=(0.2, 0.1))
    before = Prior.of(unknowns, np.array([0.6, 0.3]), np.array([[4e-4, 3e-4], [3e-4, 9e-4]]), 0.5)
    found = before.with_given(unknowns, np.array([2]))
    np.testing.assert_allclose(found.precision[2], [0.0, 0.0, 400.0])
    np.testing.assert_array_equal(found.precision[:2, :2], before.precision[:2, :2])
    assert found.gap == 0.5
    np.testing.assert_allclose(found.mean, [0.5, 0.6, 0.6])
    assert before.with_given(unknowns, np.array([1])) is before  # there is none
    again = found.without_given(np.array([2]))
    np.testing.assert_allclose(again.precision[2], [0.0, 0.0, 12.0])
    assert again.given is not None and not again.given.any() and again.mean[2] == 0.5


def test_boxes_are_the_part_that_is_no_knowledge() -> None:
    """Along the diagonal a covariance is wider than the box, across it is not."""
    along, across = np.array([1.0, 1.0]) / 2**0.5, np.array([1.0, -1.0]) / 2**0.5
    covariance = np.outer(along, along) + 1e-3 * np.outer(across, across)
    prior = Prior.of(BOTH, np.array([0.6, 0.3]), covariance)
    assert prior.boxes is not None
    expected = np.zeros((3, 3))
    expected[1:, 1:] = 12.0 * np.outer(along, along)
    np.testing.assert_allclose(prior.boxes, expected, atol=1e-9)
    knowledge = prior.knowledge
    assert knowledge.boxes is None and knowledge.knowledge is knowledge
    np.testing.assert_array_equal(knowledge.mean, prior.mean)
    precision = knowledge.precision[1:, 1:]
    # Next to nothing is left along the diagonal: that of a deviation of ten boxes.
    assert along @ precision @ along == pytest.approx(0.01)
    assert across @ precision @ across == pytest.approx(1e3, rel=1e-4)
    assert np.linalg.eigvalsh(knowledge.precision)[0] > 0.0


def test_of_a_box_nothing_is_known() -> None:
    prior = Prior.box(BOTH)
    np.testing.assert_allclose(prior.boxes, np.diag([0.0, 12.0, 12.0]))
    np.testing.assert_allclose(prior.knowledge.precision, 0.01 * np.eye(3))
    narrow = Prior.of(BOTH, np.array([0.6, 0.3]), np.diag([1e-3, 2e-3]))
    np.testing.assert_array_equal(narrow.boxes, np.zeros((3, 3)))
    np.testing.assert_array_equal(narrow.knowledge.precision, narrow.precision)


def test_given_priors_are_knowledge() -> None:
    found = Prior.known(known(gain=(1.2, 0.1)), start=True)
    np.testing.assert_allclose(found.boxes, np.diag([0.0, 0.0, 12.0]))
    np.testing.assert_allclose(found.knowledge.precision, np.diag([0.01, 400.0, 0.01]))
    again = found.without_given(np.array([1]))
    np.testing.assert_allclose(again.boxes, np.diag([0.0, 12.0, 12.0]))
    np.testing.assert_allclose(again.knowledge.precision, 0.01 * np.eye(3))
    # One as wide as its box says no more than that.
    wide = Prior.known(known(gain=(1.0, 50.0)), start=True)
    np.testing.assert_allclose(wide.precision[1, 1], 12.0)


def test_a_covariance_that_is_not_finite_tells_nothing() -> None:
    unknowns = Unknowns.of(OSCILLATOR)
    q = unknowns.dimension - unknowns.n_states
    found = Prior.of(unknowns, np.full(q, 0.5), np.full((q, q), np.nan), gap=2.0)
    box = Prior.box(unknowns)
    np.testing.assert_array_equal(found.precision, box.precision)
    np.testing.assert_array_equal(found.mean, box.mean)
    assert found.gap == 2.0
