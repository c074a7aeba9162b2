"""Tests of obs_ros.optimization.growing_horizon."""

from dataclasses import replace

import numpy as np
import pytest
from problems import Curve, decay_problem, ripples_problem

from obs_ros.core.deadline import Deadline
from obs_ros.core.typing import Array
from obs_ros.optimization.growing_horizon import HorizonSettings, first_prefix, grown
from obs_ros.optimization.levenberg_marquardt import LMSettings

NEVER = Deadline()
USUAL = HorizonSettings()


class Horizons:
    """A horizon from 20 nodes on, with the prefixes that least squares saw, in order."""

    def __init__(self, problem: Curve, deadline: Deadline = NEVER, **changes: float) -> None:
        self.nodes: list[int] = []
        self.squares: list[float] = []
        linearise = problem.linearise

        def seen(z: Array, h: Array, nodes: int) -> tuple[Array, Array, Array]:
            self.nodes += [nodes] if nodes not in self.nodes else []
            return linearise(z, h, nodes)

        problem.linearise = seen  # type: ignore[method-assign]
        z = np.random.default_rng(1).random((8, problem.dimension))
        settings = replace(USUAL, **changes)
        self.found = grown(problem, z, 20, deadline, self._remember, settings, LMSettings())

    def _remember(self, z: Array, squares: Array) -> None:
        self.squares.append(float(squares.min()))


def test_a_prefix_is_a_share_of_the_window_by_round_with_values_for_every_unknown() -> None:
    problem = decay_problem(nodes=1600)
    assert [first_prefix(problem, n, USUAL) for n in range(5)] == [100, 200, 50, 400, 100]
    assert first_prefix(decay_problem(nodes=100), 0, USUAL) == 16
    assert first_prefix(decay_problem(nodes=100), 0, replace(USUAL, values=20)) == 64
    assert first_prefix(decay_problem(nodes=30), 0, replace(USUAL, values=20)) == 30


def test_a_horizon_grows_until_the_best_leads_over_all_of_it() -> None:
    """Half of the candidates are left at each step, two at least; the best comes first."""
    problem = decay_problem()
    horizons = Horizons(problem)
    assert horizons.nodes[0] == 20 and horizons.nodes == sorted(horizons.nodes)
    assert 2 <= len(horizons.nodes) <= USUAL.most_steps and len(horizons.found) == 2
    costs = problem.costs(horizons.found)
    assert costs[0] == costs.min() == pytest.approx(0.02, rel=0.2)  # 200 times 0.01^2
    assert len(Horizons(ripples_problem()).found) == 4  # after one step


def test_a_horizon_that_no_candidate_leads_on_is_given_up() -> None:
    """Here none is near enough on any block."""
    never = {'bad_noise': 0.0, 'bad_share': 0.0}
    assert len(Horizons(ripples_problem(), **never).nodes) == USUAL.crawling
    assert len(Horizons(ripples_problem(), **never, crawling=9).nodes) == USUAL.most_steps


def test_all_candidates_over_the_whole_window_are_remembered() -> None:
    problem = ripples_problem()
    horizons = Horizons(problem)
    assert horizons.squares[-1] == pytest.approx(problem.costs(horizons.found).min())
    assert len(horizons.squares) == len(horizons.nodes)


def test_without_time_the_starts_are_returned() -> None:
    horizons = Horizons(decay_problem(), Deadline(0.0))
    np.testing.assert_array_equal(horizons.found, np.random.default_rng(1).random((8, 3)))
    assert not horizons.nodes
