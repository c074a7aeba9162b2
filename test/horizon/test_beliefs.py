"""Tests of obs_ros.horizon.beliefs: lineages of the integrator, linear in all its unknowns."""

import numpy as np
import pytest
from jump_windows import record, still, with_a_drift_jump

from obs_ros.core.deadline import Deadline
from obs_ros.horizon.arrival_cost import Lineal
from obs_ros.horizon.beliefs import Beliefs, believed
from obs_ros.horizon.found_jumps import JumpFound, Size
from obs_ros.inference.assessment.interval import covariance_without_boxes
from obs_ros.inference.jumps.mixture import Mixture
from obs_ros.inference.prior import Prior

WINDOW = record(0.0)
SPREAD = np.diag([4e-4, 4e-4])
EARLIER = JumpFound(-3.0, 0.1, {'drift': Size(1.0, 0.1, 0.5, 0.05)})
STILL = still(WINDOW)
DRIFT = float(STILL.point[2])


def lineal(weight: float, drift: float, *jumps: JumpFound) -> Lineal:
    prior = Prior.of(STILL.problem.objective.unknowns, np.array([0.65, drift]), SPREAD)
    return Lineal(weight, lambda: prior, jumps)


def beliefs(*lineages: Lineal) -> Beliefs:
    """What a window adds up to that was fitted under the first lineage's prior."""
    best = still(WINDOW, lineages[0].prior())
    return believed(Mixture.only(best), lineages, 0.0, 10.0, Deadline())


def test_a_window_multiplies_the_odds_of_lineages() -> None:
    """By the ratio of its probabilities under their priors, which are known in closed form."""
    right, wrong = lineal(0.2, DRIFT), lineal(0.8, DRIFT + 0.03, EARLIER)
    found = beliefs(wrong, right)
    neg2_log = []
    for lineage in (right, wrong):
        one = still(WINDOW, lineage.prior())
        neg2_log.append(one.neg2_log_evidence - 2.0 * np.log(lineage.weight))
    odds = np.exp(-0.5 * (neg2_log[0] - neg2_log[1]))
    chances = found.chances(EARLIER)
    assert sorted(chances.values()) == sorted(one.weight for one in found.every)
    assert chances[frozenset()] / chances[frozenset({'drift'})] == pytest.approx(odds, rel=0.02)
    assert found.shown(EARLIER, frozenset({'drift'})) is EARLIER
    assert found.shown(EARLIER, frozenset({'gain'})) is None


def test_a_lineage_that_the_window_contradicts_ends() -> None:
    """Then the window is as if it had been fitted under the other alone."""
    found = beliefs(lineal(0.9, DRIFT + 0.3, EARLIER), lineal(0.1, DRIFT))
    (only,) = found.every
    assert (only.jumps, only.weight) == ((), 1.0)
    alone = still(WINDOW, lineal(0.1, DRIFT).prior())
    np.testing.assert_allclose(only.hypothesis.point, alone.point, atol=5e-4)  # of 0.01, its sd
    assert found.components(1.0) == []


def test_one_lineage_leaves_the_mixture_as_it_is() -> None:
    best = still(WINDOW)
    found = believed(Mixture.only(best), [lineal(1.0, DRIFT, EARLIER)], 0.0, 10.0, Deadline())
    (only,) = found.every
    assert only.hypothesis is best and only.jumps == (EARLIER,) and only.own == ()


def test_jumps_of_a_window_are_known_with_their_rivals() -> None:
    window = record(0.1)
    jumped, without = with_a_drift_jump(window), still(window)
    mixture = Mixture((jumped, without), np.array([0.7, 0.3]), still=0.3)
    found = believed(mixture, [], 0.0, 10.0, Deadline())
    (event,) = found.events()
    assert event.time == pytest.approx(4.23, abs=0.5)
    (known,) = found.known_jumps(jumped.problem.objective.unknowns)
    assert known.parameters == frozenset({2})
    assert {places: chance for chance, places, _ in known.chances} == pytest.approx({
        frozenset({2}): 0.7, frozenset(): 0.3
    })  # fmt: skip
    (component,) = found.components(2.0)
    assert component.weight == 0.3 and component.jumps == ()
    np.testing.assert_allclose(component.mean, without.point[1:])
    # Boxes bound what is handed on, but do not pull it.
    expected = 2.0 * covariance_without_boxes(without)[1:, 1:]
    np.testing.assert_allclose(component.covariance, expected)
