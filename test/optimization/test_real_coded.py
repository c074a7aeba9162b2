"""Tests of obs_ros.optimization.real_coded."""

import numpy as np

from obs_ros.optimization.real_coded import BLEND, DEVIATION, offspring

PARENTS = np.array([[0, 1]] * 4000)


def test_children_are_uniform_between_their_parents_and_half_their_distance_beyond() -> None:
    z = np.array([[0.4, 0.5], [0.6, 0.5]])
    children = offspring(z, PARENTS, 0.0, np.random.default_rng(1), 8000)
    assert children.shape == (8000, 2)
    low, high = 0.4 - 0.2 * BLEND, 0.6 + 0.2 * BLEND
    assert low <= children[:, 0].min() < low + 0.001
    assert high - 0.001 < children[:, 0].max() <= high
    assert abs(children[:, 0].mean() - 0.5) < 4.0 * 0.4 / np.sqrt(12.0 * 8000)
    np.testing.assert_array_equal(children[:, 1], 0.5)


def test_mutations_are_normal_and_as_frequent_as_asked() -> None:
    z = np.full((2, 1), 0.5)
    children = offspring(z, PARENTS, 0.3, np.random.default_rng(2), 8000)
    mutated = children[children != 0.5]
    assert abs(mutated.size / 8000 - 0.3) < 4.0 * np.sqrt(0.21 / 8000)
    assert abs(mutated.std() / DEVIATION - 1.0) < 0.1


def test_a_child_outside_the_box_is_drawn_anew_inside() -> None:
    z = np.array([[0.0], [1.0]])
    children = offspring(z, PARENTS, 0.0, np.random.default_rng(3), 8000)
    assert ((children >= 0.0) & (children <= 1.0)).all()
    assert abs(children.mean() - 0.5) < 0.02
