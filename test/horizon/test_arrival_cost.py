"""Tests of obs_ros.horizon.arrival_cost."""

import math
from dataclasses import replace

import numpy as np
import pytest
from plants import INTEGRATOR

from obs_ros import Variable
from obs_ros.core.prior_knowledge import with_knowledge
from obs_ros.horizon.arrival_cost import KEPT, ArrivalCost, KnownJump, WindowPosterior
from obs_ros.horizon.found_jumps import JumpFound, Size
from obs_ros.horizon.gaussian_sum import Component, moments
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.inference.prior import Prior

UNKNOWNS = Unknowns.of(INTEGRATOR)
COVARIANCE = np.array([[4e-4, 1e-4], [1e-4, 9e-4]])
DURATION = 10.0
GAIN = frozenset({1})  # its place in z, after x
BOX = 1.0 / 12.0
FOUND = JumpFound(22.0, 0.1, {'gain': Size(0.1, 0.02, 0.07, 0.01)})


def history(*ends: float) -> ArrivalCost:
    """Windows whose mean tells their end."""
    found = ArrivalCost(UNKNOWNS)
    for end in ends:
        found.add(WindowPosterior(end, np.array([0.01 * end, 0.5]), COVARIANCE))
    return found


def taken(prior: Prior | None) -> float:
    """The end of the window that a prior comes from."""
    assert prior is not None
    return float(100.0 * prior.mean[1])


def covariance(prior: Prior | None) -> np.ndarray:
    assert prior is not None
    return np.linalg.inv(prior.precision)[1:, 1:]


def test_without_a_window_that_ended_there_is_no_prior() -> None:
    assert history().prior(50.0, DURATION) is None
    assert history(20.0, 30.0).prior(19.9, DURATION) is None


@pytest.mark.parametrize(
    ('start', 'end'), [(20.0, 20.0), (24.9, 20.0), (25.0, 25.0), (29.0, 25.0), (99.0, 30.0)]
)
def test_the_newest_window_that_had_ended(start: float, end: float) -> None:
    assert taken(history(20.0, 25.0, 30.0).prior(start, DURATION)) == pytest.approx(end)


def test_of_windows_that_ended_lately_the_one_that_knew_most() -> None:
    """They are walked as if windows abutted: here half a window apart, for up to two of them."""
    for end, surer in ((20.0, True), (15.1, True), (14.9, False)):
        sequence = history(end)
        sequence.add(WindowPosterior(25.0, np.array([0.25, 0.5]), 4.0 * COVARIANCE))
        sequence.add(
            WindowPosterior(31.0, np.array([0.31, 0.5]), 0.1 * COVARIANCE)
        )  # not ended yet
        prior = sequence.most_informative_prior(30.0, DURATION)
        assert (prior is not None) == surer
        if prior is not None:
            assert taken(prior) == pytest.approx(end)
            walked = 0.01 * BOX * 0.5 * (1.0 + (25.0 - end) / DURATION) * np.eye(2)
            np.testing.assert_allclose(covariance(prior), COVARIANCE + walked, rtol=1e-9)
            assert prior.gap == pytest.approx(0.5 * (1.0 + (25.0 - end) / DURATION))
    assert history().most_informative_prior(30.0, DURATION) is None
    assert history(20.0).most_informative_prior(30.0, DURATION) is None  # no other than the newest


def test_no_sample_is_used_twice_in_a_sequence_of_overlapping_windows() -> None:
    sequence = ArrivalCost(UNKNOWNS)
    for end in np.arange(10.0, 60.0, 2.0):
        prior = sequence.prior(end - DURATION, DURATION)
        assert (prior is None) == (end < 20.0)
        if prior is not None:
            assert taken(prior) == pytest.approx(end - DURATION)  # abuts, to the sample
        sequence.add(WindowPosterior(end, np.array([0.01 * end, 0.5]), COVARIANCE))
        sequence.prune(end - DURATION, DURATION)
        assert len(sequence._entries) <= 11


def test_parameters_walk_at_random() -> None:
    """rho^2 (start - end) / K with rho^2 = 0.01 / 12."""
    for start in (20.0, 25.0, 50.0):
        found = covariance(history(20.0).prior(start, DURATION))
        walked = 0.01 * BOX * (start - 20.0) / DURATION
        np.testing.assert_allclose(found, COVARIANCE + walked * np.eye(2), rtol=1e-9)


def test_a_prior_knows_how_old_it_is() -> None:
    found = history(20.0).prior(25.0, DURATION)
    assert found is not None
    assert found.gap == 0.5


def disturbed(walk: float) -> ArrivalCost:
    """A window that ended at 20 s, of the integrator with a drift that wanders."""
    drift = replace(INTEGRATOR.parameters[1], walk=walk)
    model = replace(INTEGRATOR, parameters=(INTEGRATOR.parameters[0], drift))
    found = ArrivalCost(Unknowns.of(model))
    found.add(WindowPosterior(20.0, np.array([0.2, 0.9]), COVARIANCE))
    return found


def test_a_disturbance_that_is_new_in_every_window_is_forgotten() -> None:
    """But not what the other parameter was."""
    prior = disturbed(math.inf).prior(25.0, DURATION)
    found = covariance(prior)
    assert found[1, 1] == pytest.approx(BOX, rel=1e-3)
    assert found[0, 1] == pytest.approx(0.0, abs=1e-4)
    assert found[0, 0] == pytest.approx(4e-4 + 0.01 * BOX * 0.5, rel=0.05)


@pytest.mark.parametrize('walk', [0.01, 0.04])
def test_a_disturbance_that_walks_is_widened_as_far_as_it_does(walk: float) -> None:
    """By walk^2 times the time between the windows' means: drift is 2 wide."""
    for start in (20.0, 35.0):
        found = covariance(disturbed(walk).prior(start, DURATION))
        jumps = 0.01 * BOX * (start - 20.0) / DURATION
        walked = (walk / 2.0) ** 2 * (start - 20.0 + 2.0 / 3.0 * DURATION)
        assert found[0, 0] == pytest.approx(4e-4 + jumps, rel=1e-6)
        assert found[1, 1] == pytest.approx(9e-4 + jumps + walked, rel=1e-6)


def test_on_a_log_scale_the_logarithm_walks() -> None:
    gain = Variable('gain', lower=0.5, upper=2.0, scale='log', walk=0.01)
    unknowns = Unknowns.of(replace(INTEGRATOR, parameters=(gain, INTEGRATOR.parameters[1])))
    found = ArrivalCost(unknowns)
    found.add(WindowPosterior(20.0, np.array([0.2, 0.9]), COVARIANCE))
    walked = (0.01 / np.log(4.0)) ** 2 * (15.0 + 2.0 / 3.0 * DURATION)
    jumps = 0.01 * BOX * 1.5
    assert covariance(found.prior(35.0, DURATION))[0, 0] == pytest.approx(4e-4 + jumps + walked)


def test_a_walk_beyond_all_numbers_forgets_and_no_more() -> None:
    prior = disturbed(1e100).prior(25.0, DURATION)
    assert prior is not None and np.isfinite(prior.precision).all()
    assert covariance(prior)[1, 1] == pytest.approx(BOX, rel=1e-3)


def test_a_disturbance_that_is_new_in_every_window_is_drawn_from_its_prior() -> None:
    drift = replace(INTEGRATOR.parameters[1], walk=math.inf, prior=(0.5, 0.1))
    model = replace(INTEGRATOR, parameters=(INTEGRATOR.parameters[0], drift))
    sequence = ArrivalCost(Unknowns.of(model))
    sequence.add(WindowPosterior(20.0, np.array([0.2, 0.9]), COVARIANCE))
    prior = sequence.prior(25.0, DURATION)
    assert prior is not None and prior.given is not None
    np.testing.assert_allclose(prior.mean, [0.5, 0.2, 0.75])
    np.testing.assert_allclose(prior.precision[2], [0.0, 0.0, 400.0])
    np.testing.assert_allclose(prior.given, [0.0, 0.0, 388.0])
    assert covariance(prior)[0, 0] == pytest.approx(4e-4 + 0.01 * BOX * 0.5, rel=0.05)


def test_given_priors_hold_until_a_jump() -> None:
    priors = {'x': (2.0, 0.5), 'gain': (1.2, 0.1), 'drift': (0.0, 0.1)}
    unknowns = Unknowns.of(with_knowledge(INTEGRATOR, None, priors))
    sequence = ArrivalCost(unknowns)
    for first in (True, False):
        found, expected = (
            sequence.given_prior(30.0, first=first),
            Prior.known(unknowns, start=first),
        )
        np.testing.assert_array_equal(found.precision, expected.precision)
    sequence.jumps = [KnownJump(25.0, GAIN)]
    before, after = (sequence.given_prior(start, first=False) for start in (24.9, 25.0))
    np.testing.assert_allclose(np.diagonal(before.precision), [0.01, 400.0, 400.0])
    np.testing.assert_allclose(np.diagonal(after.precision), [0.01, 12.0, 400.0])


def test_a_jump_since_then_widens_what_jumped_to_its_box() -> None:
    for time, wider in ((20.0, False), (20.1, True), (25.0, True), (25.1, False)):
        sequence = history(20.0)
        sequence.jumps = [KnownJump(time, GAIN)]
        found = covariance(sequence.prior(25.0, DURATION))
        still = COVARIANCE + 0.01 * BOX * 0.5 * np.eye(2)
        if not wider:
            np.testing.assert_allclose(found, still, rtol=1e-9)
            continue
        # Variance of a box, at most: a jump does not make less known than nothing.
        assert found[0, 0] == pytest.approx(BOX, rel=1e-3)
        assert found[1, 1] == pytest.approx(still[1, 1], rel=1e-3)


def test_a_new_jump_forgets_windows_that_did_not_know_of_it() -> None:
    sequence = history(20.0, 25.0, 30.0)
    # The third is the second again, found a little earlier.
    for time, newest in ((25.0, 25.0), (24.4, 20.0), (24.0, 20.0), (5.0, None)):
        sequence.update_jumps([KnownJump(time, GAIN)], time - 5.0, time + 5.0, near=0.5)
        assert sequence.jumps[-1] == KnownJump(time, GAIN)
        prior = sequence.prior(40.0, DURATION)
        assert (None if prior is None else taken(prior)) == pytest.approx(newest)


def test_pruning_keeps_what_later_windows_need() -> None:
    sequence = history(20.0, 25.0, 30.0)
    sequence.jumps = [KnownJump(22.0, GAIN), KnownJump(27.0, GAIN)]
    before = [sequence.prior(start, DURATION) for start in (26.0, 40.0)]
    for duration, jumps in ((DURATION, [22.0, 27.0]), (2.0, [27.0])):
        sequence.prune(26.0, duration)
        assert [known.time for known in sequence.jumps] == jumps
        after = [sequence.prior(start, DURATION) for start in (26.0, 40.0)]
        for a, b in zip(before, after):
            np.testing.assert_array_equal(covariance(a), covariance(b))
    assert sequence.prior(24.0, DURATION) is None
    sequence.prune(10.0, DURATION)  # nothing ended by then
    assert taken(sequence.prior(40.0, DURATION)) == pytest.approx(30.0)


def test_it_does_not_grow_for_ever() -> None:
    sequence = history(*np.arange(KEPT + 50.0))
    assert sequence.prior(49.5, DURATION) is None
    assert taken(sequence.prior(50.0, DURATION)) == pytest.approx(50.0)


def doubtful(time: float, chance: float) -> KnownJump:
    """The gain jumped with this probability, else nothing did."""
    return KnownJump(time, GAIN, ((chance, GAIN, FOUND), (1.0 - chance, frozenset(), None)))


def test_a_doubtful_jump_widens_by_its_probability_and_makes_lineages() -> None:
    sequence = history(20.0)
    sequence.jumps = [doubtful(22.0, 0.7)]
    walked = 0.01 * BOX * 0.5
    moments = covariance(sequence.prior(25.0, DURATION))
    assert moments[0, 0] == pytest.approx(4e-4 + walked + 0.7 * BOX, rel=1e-2)
    jumped, still = sequence.lineages(25.0, DURATION)
    assert (jumped.weight, still.weight) == pytest.approx((0.7, 0.3))
    assert (jumped.jumps, still.jumps) == ((FOUND,), ())
    assert covariance(jumped.prior())[0, 0] == pytest.approx(BOX, rel=1e-3)
    assert covariance(still.prior())[0, 0] == pytest.approx(4e-4 + walked)
    np.testing.assert_array_equal(jumped.prior().mean, still.prior().mean)


def test_lineages_of_a_window_go_on() -> None:
    sequence = ArrivalCost(UNKNOWNS)
    parts = tuple(
        Component(weight, np.array([mean, 0.5]), COVARIANCE, jumps)
        for weight, mean, jumps in ((0.8, 0.6, (FOUND,)), (0.2, 0.2, ()))
    )
    sequence.add(WindowPosterior(24.0, *moments(parts), components=parts))
    one, other = sequence.lineages(24.0, DURATION)
    assert (one.weight, other.weight) == pytest.approx((0.8, 0.2))
    assert (one.prior().mean[1], other.prior().mean[1]) == (0.6, 0.2)
    prior = sequence.prior(24.0, DURATION)
    assert prior is not None
    assert prior.mean[1] == pytest.approx(0.52)
    assert covariance(prior)[0, 0] == pytest.approx(4e-4 + 0.8 * 0.2 * 0.4**2)
    assert history(20.0).lineages(19.0, DURATION) == ()


def test_a_jump_that_counted_before_is_not_new() -> None:
    """The windows that ended after it knew of it, with another one as the best."""
    for chance in (0.7, None):
        sequence = history(20.0, 25.0)
        sequence.jumps = [doubtful(24.0, 0.7)] if chance else []
        sequence.update_jumps([KnownJump(24.2, GAIN)], 15.0, 25.0, near=0.5)
        assert taken(sequence.prior(40.0, DURATION)) == pytest.approx(25.0 if chance else 20.0)


def test_windows_that_believe_in_a_wrong_jump_are_forgotten() -> None:
    sequence = history(20.0, 25.0, 30.0)
    sequence.forget_wrong(22.0, 30.0)
    assert taken(sequence.prior(29.0, DURATION)) == pytest.approx(20.0)
    assert taken(sequence.prior(30.0, DURATION)) == pytest.approx(30.0)


def test_what_drifts_is_widened_by_its_walk() -> None:
    sequence = history(20.0)
    sequence.note_drifts({'gain': 1e-3})
    found = covariance(sequence.prior(25.0, DURATION))
    walked = 0.01 * BOX * 0.5
    apart = 5.0 + 2.0 / 3.0 * DURATION
    assert found[0, 0] == pytest.approx(4e-4 + walked + 1e-3 * apart, rel=1e-6)
    assert found[1, 1] == pytest.approx(9e-4 + walked, rel=1e-6)
    sequence.note_drifts({})
    assert covariance(sequence.prior(25.0, DURATION))[0, 0] == pytest.approx(4e-4 + walked)
