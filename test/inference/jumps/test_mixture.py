"""Tests of obs_ros.inference.jumps.mixture."""

from dataclasses import replace

import numpy as np
import pytest
from jump_windows import DRIFT, GAIN, record, still, with_a_drift_jump

from obs_ros.core.deadline import Deadline
from obs_ros.inference.jumps.hypothesis import Hypothesis
from obs_ros.inference.jumps.jump_search import JumpSearch
from obs_ros.inference.jumps.mixture import Mixture, at_end, excess, probabilities


def with_evidence(hypothesis: Hypothesis, neg2_log_evidence: float) -> Hypothesis:
    """The same hypothesis, as if it were as likely as that."""
    return replace(hypothesis, neg2_log_evidence=neg2_log_evidence)


STILL, JUMPED = still(record(0.6)), with_a_drift_jump(record(0.6))


def test_probabilities_are_those_of_the_evidence() -> None:
    found = probabilities(np.array([410.0, 412.0, 420.0]))
    assert found.sum() == pytest.approx(1.0)
    np.testing.assert_allclose(found[1:] / found[0], np.exp([-1.0, -5.0]))


@pytest.mark.parametrize(('gap', 'counts'), [(2.0, True), (5.7, True), (9.5, False)])
def test_hypotheses_of_more_than_a_twentieth_count(gap: float, counts: bool) -> None:
    best, other = with_evidence(JUMPED, 400.0), with_evidence(STILL, 400.0 + gap)
    mixture = Mixture.of(best, [other, best], 0.0)
    odds = float(np.exp(-0.5 * gap))
    assert mixture.still == pytest.approx(odds / (1.0 + odds), rel=1e-6)
    assert mixture.best is best
    assert (len(mixture.hypotheses) == 2) == counts
    if counts:
        np.testing.assert_allclose(mixture.weights, np.array([1.0, odds]) / (1.0 + odds))
    assert (mixture.alternatives == [other]) == counts


def test_of_one_set_of_parameters_the_best_stands_for_all() -> None:
    best = with_evidence(STILL, 400.0)
    one, other = (replace(JUMPED, neg2_log_evidence=e, cost=0.0) for e in (403.0, 402.0))
    mixture = Mixture.of(best, [best, one, other], 0.0)
    assert [h.neg2_log_evidence for h in mixture.hypotheses] == [400.0, 402.0]


@pytest.mark.parametrize('evidence', [(400.0, np.nan), (np.nan, 400.0)])
def test_what_cannot_be_weighed_counts_for_nothing(evidence: tuple[float, float]) -> None:
    best, other = with_evidence(STILL, evidence[0]), with_evidence(JUMPED, evidence[1])
    mixture = Mixture.of(best, [best, replace(other, cost=0.0)], 0.0)
    assert mixture.hypotheses == (best,)
    assert mixture.weights.tolist() == [1.0]


def test_determinants_gain_nothing_for_a_jump() -> None:
    """At the kinks of a model they mean little."""
    best = replace(STILL, neg2_log_evidence=400.0, cost=300.0)
    other = replace(JUMPED, neg2_log_evidence=390.0, cost=301.0)
    weights = Mixture.of(best, [best, other], 0.0).weights
    assert weights[1] / weights[0] == pytest.approx(np.exp(-0.5))


def test_the_search_weighs_what_explains_as_much() -> None:
    """A small drift jump: the gain, whose square wave is no step, is no rival; no jump is one."""
    shares = []
    for seed in range(20):
        window = record(0.06, 5.0, seed)
        search = JumpSearch(still(window), Deadline(), known=None)
        best = search.run()
        mixture = search.mixture()
        assert mixture.best is best
        assert mixture.weights.sum() == pytest.approx(1.0)
        shares.append(mixture.still)
    # Neither are all certain of a jump, nor of none.
    assert min(shares) < 0.5 < max(shares)


def test_the_second_moment_is_about_the_published_value() -> None:
    best, other = with_evidence(JUMPED, 400.0), with_evidence(STILL, 401.0)
    mixture = Mixture.of(best, [best, other], 0.0)
    found = excess(mixture, best.covariance)
    assert found is not None
    (value, rows), (others, other_rows) = at_end(best), at_end(other)
    np.testing.assert_allclose(value[1:], [best.point[GAIN], best.point[4]])
    assert best.layout.final(best.point)[DRIFT] == 4
    apart = others - value
    weight = mixture.weights[1]
    expected = other_rows @ other.covariance @ other_rows.T + np.outer(apart, apart)
    expected -= rows @ best.covariance @ rows.T
    np.testing.assert_allclose(found, weight * expected)
    total = rows @ best.covariance @ rows.T + found
    assert np.linalg.eigvalsh(total).min() > 0.0


def test_one_hypothesis_leaves_everything_as_it_is() -> None:
    assert excess(Mixture.only(STILL), STILL.covariance) is None
    assert (Mixture.only(STILL).still, Mixture.only(JUMPED).still) == (1.0, 0.0)
