"""Tests of obs_ros.integration.step_trials."""

import numpy as np

from obs_ros.integration.step_trials import Choice, Verdict


def test_the_first_candidate_counts_alone_and_of_the_others_most() -> None:
    verdict = Verdict(0.01, np.array([0.2, 0.5, 0.5, 0.5, np.inf]))
    assert verdict.worst(0.75) == 0.5 and verdict.worst(1.0) == np.inf
    exempt = np.array([False, False, False, False, True])
    assert verdict.without(exempt).worst(1.0) == 0.5 and verdict.without(None) is verdict
    assert Verdict(0.1, np.array([2.0])).worst() == 2.0


def test_a_choice_is_fine_up_to_what_is_allowed() -> None:
    steps = np.ones(3, dtype=np.int64)
    assert Choice('rk4', steps, 0.1, 1.0).fine and not Choice('rk4', steps, 0.1, 1.1).fine
