"""Tests of obs_ros.inference.jumps.hypothesis."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from jump_windows import (
    DESIGN,
    DRIFT,
    GAIN,
    LOWER,
    SIGMA,
    TIGHT,
    T,
    U,
    neg2_log_probability,
    record,
    still,
)
from plants import integrator_design
from scipy.signal import lfilter

from obs_ros.inference.jumps.hypothesis import beats, discounted, hypothesis_at

ONCE = 2.0 * np.log(100.0)  # penalty of a jump


def test_evidence_differs_as_minus_two_log_probabilities_do() -> None:
    window = record()
    e = [still(window, prior).neg2_log_evidence for prior in (None, TIGHT)]
    expected = [neg2_log_probability(window, prior=prior) for prior in (None, TIGHT)]
    assert e[0] - e[1] == pytest.approx(expected[0] - expected[1], abs=1e-4)


def test_penalties() -> None:
    base = still(record())
    point = np.concatenate([base.point, [0.5], base.point[[GAIN, DRIFT]]])
    costs = []
    for events, places in ((((GAIN,),), [0, 1, 2, 3, 4]), (((GAIN, DRIFT),), range(6))):
        problem = replace(base.problem, events=events)
        costs.append(hypothesis_at(problem, point[places]).cost - base.cost)
    assert costs == pytest.approx([ONCE, ONCE + 2.0 * np.log(10.0)])
    # As likely as the time is long in which nobody looked, or nothing would have shown it.
    for gap, penalty in (
        (0.0, ONCE), (1.0, ONCE - 2.0 * np.log(2.0)), (1000.0, 0.0),
    ):  # fmt: skip
        prior = replace(base.problem.prior, mean=base.point, gap=gap)
        problem = replace(base.problem, prior=prior)
        unseen, seen = (
            hypothesis_at(problem, base.point + size * np.eye(base.point.size)[GAIN], (GAIN,))
            for size in (0.0, 0.1)
        )
        assert unseen.cost - unseen.squares == pytest.approx(penalty)
        assert unseen.unseen == gap + 1.0
        visible = 0.01 / seen.covariance[GAIN, GAIN]
        assert seen.unseen == pytest.approx(gap + ONCE / visible)


def test_the_covariance_is_that_of_linear_least_squares() -> None:
    base = still(record(), TIGHT)
    expected = np.linalg.inv(DESIGN.T @ DESIGN + TIGHT.precision)
    np.testing.assert_allclose(base.covariance, expected, rtol=1e-4)
    target = (record().y[:, 0] - integrator_design(T, U) @ LOWER) / SIGMA
    best = expected @ (DESIGN.T @ target + TIGHT.precision @ TIGHT.mean)
    np.testing.assert_allclose(base.point, best, atol=1e-6)
    assert base.squares == pytest.approx(((DESIGN @ best - target) ** 2).sum(), rel=1e-6)


def test_colour_that_the_noise_is_known_to_have_costs_a_jump_nothing() -> None:
    noise = lfilter([0.8], [1.0, -0.6], np.random.default_rng(5).standard_normal(400))
    hypotheses: list[Any] = [
        SimpleNamespace(squares=s, cost=c, neg2_log_evidence=e, trajectory=(None, noise[:, None]))
        for s, c, e in ((420.0, 420.0, 420.0), (400.0, 410.0, 415.0))
    ]
    without, jumped = hypotheses
    assert not beats(jumped, without, 0.0)
    assert beats(jumped, without, 0.6)


def test_squares_of_a_correlated_residual_count_for_less() -> None:
    best = still(record())
    assert discounted(best, 1.0) == best.neg2_log_evidence
    assert discounted(best, 4.0) == pytest.approx(best.neg2_log_evidence - 0.75 * best.squares)
