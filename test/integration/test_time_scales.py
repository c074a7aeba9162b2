"""Tests of obs_ros.integration.time_scales: modes against closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from plants import BLOW_UP, LAG
from sampled_stiff_plants import MOTOR, chain

from obs_ros.integration.time_scales import (
    fastest_decay,
    jacobians,
    may_be_stiff,
    modes,
    shortest_time,
    stiffness,
)
from obs_ros.models import load_model

NOTHING = np.empty(0)


def of_motor() -> np.ndarray:
    return modes(MOTOR, 0.0, np.array([1.0, 20.0]), np.array([12.0]), np.array([0.05]))


def test_the_modes_of_a_linear_plant_are_the_eigenvalues_of_its_matrix() -> None:
    """i' = 1e4 (v - i - k w), w' = 1e4 k i - w, with k = 0.05."""
    exact = np.linalg.eigvals(np.array([[-1e4, -500.0], [500.0, -1.0]]))
    assert np.sort(of_motor().real) == pytest.approx(np.sort(exact.real), rel=1e-6)


def test_derivatives_are_exact_for_each_candidate() -> None:
    gain = np.array([[0.05, 0.1]])
    found = jacobians(MOTOR, 0.0, np.ones((2, 2)), np.array([12.0]), gain)
    exact = [[[-1e4, -1e4 * k], [1e4 * k, -1.0]] for k in gain[0].tolist()]
    np.testing.assert_allclose(found, exact, rtol=1e-14)


def test_rates_and_times_follow_from_the_modes() -> None:
    found = np.array([-100.0 + 0j, -2.0 + 0j, 0.0 + 0j, 3.0 + 4.0j, 3.0 - 4.0j])
    assert fastest_decay(found) == 100.0
    assert shortest_time(found) == 0.01
    assert stiffness(found) == 50.0  # what does not move at all does not count
    assert fastest_decay(np.array([2.0 + 0j])) == 0.0
    assert shortest_time(NOTHING) == np.inf
    assert stiffness(NOTHING) == 0.0


def test_there_are_no_modes_where_derivatives_are_not_finite() -> None:
    assert not modes(BLOW_UP, 0.0, np.array([np.nan]), NOTHING, NOTHING).size


def test_stiff_plants_are_told_from_others() -> None:
    assert may_be_stiff(MOTOR)
    assert may_be_stiff(chain(6))
    assert not may_be_stiff(LAG)
    assert not may_be_stiff(load_model('three_tank'))


def test_a_longest_step_says_what_is_resolved() -> None:
    """At steps of 1e-4 s nothing of the motor decays by more than one time constant a step."""
    assert not may_be_stiff(replace(MOTOR, max_step=1e-4))
    assert may_be_stiff(replace(MOTOR, max_step=1e-2))
