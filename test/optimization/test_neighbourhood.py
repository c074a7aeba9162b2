"""Tests of obs_ros.optimization.neighbourhood."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from obs_ros.core.deadline import Deadline
from obs_ros.core.rng import random_generator
from obs_ros.core.typing import Array
from obs_ros.optimization.acceptance import Acceptance
from obs_ros.optimization.neighbourhood import NEIGHBOURHOOD, bettered, neighbours
from obs_ros.optimization.result import Effort, Found


@dataclass
class Stepped:
    """100 residuals of a line with noise; one more is off until the slope exceeds an edge."""

    edge: float = -1.0
    limits: Array = field(default_factory=lambda: np.array([[0.0, 0.0], [1.0, 1.0]]))
    dimension = 2
    nodes = 101
    signal = 1e4
    asked: int = 0

    def __post_init__(self) -> None:
        self.t = np.linspace(0.0, 1.0, 100)
        noise = np.random.default_rng(4).standard_normal(100)
        self.y = 300.0 * 0.5 * self.t + 300.0 * 0.4 + noise

    def count(self, nodes: int) -> int:
        return nodes

    def floor(self, nodes: int) -> float:
        return 1e-9

    def rows(self, z: Array) -> Array:
        line = 300.0 * (z[:, :1] * self.t + z[:, 1:]) - self.y
        jump = np.where(z[:, :1] > self.edge, 0.0, 200.0)
        return np.hstack([line, jump])

    def costs(self, z: Array, nodes: int | None = None) -> Array:
        self.asked += 1
        return np.sum(self.rows(z) ** 2, axis=1)

    def linearise(self, z: Array, h: Array, nodes: int) -> tuple[Array, Array, Array]:
        J = 300.0 * np.vstack([np.column_stack([self.t, np.ones(100)]), np.zeros((1, 2))])
        rows = self.rows(z)
        return np.sum(rows**2, axis=1), rows @ J, np.repeat((J.T @ J)[None], len(z), axis=0)

    def optimum(self) -> Array:
        A = 300.0 * np.column_stack([self.t, np.ones(100)])
        return np.linalg.lstsq(A, self.y, rcond=None)[0]


def found_at(problem: Any, z: Array) -> Found:
    cost = float(problem.costs(z[None])[0])
    return Found(z, cost, converged=True, accepted=Acceptance.ROUNDS, effort=Effort(1, 'round'))


def test_a_jump_that_is_missed_by_a_sample_is_found_within_the_deviations() -> None:
    best = Stepped().optimum()
    problem = Stepped(edge=best[0] + 0.002)  # .6 deviations of the slope
    found = bettered(problem, found_at(problem, best), Deadline(), noise_known=True)
    assert found.cost < 110.0 and found.z[0] > problem.edge
    assert found_at(problem, best).cost > 4e4


def test_an_optimum_without_better_neighbours_stays_itself() -> None:
    problem = Stepped()
    found = found_at(problem, problem.optimum())
    assert bettered(problem, found, Deadline(), noise_known=True) is found
    assert problem.asked == 2
    assert bettered(problem, found, Deadline(0.0), noise_known=True) is found


def test_neighbours_lie_where_squares_rise_alike_and_within_the_limits() -> None:
    problem = Stepped()
    found = found_at(problem, problem.optimum())
    z = neighbours(problem, found, random_generator(0), NEIGHBOURHOOD)
    assert z.shape == (NEIGHBOURHOOD.count, 2)
    assert ((z >= 0.0) & (z <= 1.0)).all()
    rise = problem.costs(z) - found.cost
    expected = 2.0 * np.geomspace(0.01, 3.0, NEIGHBOURHOOD.count) ** 2  # chi-square of 2
    assert 0.5 < np.mean(rise / expected) < 2.0
    at_edge = found_at(problem, np.array([1.0, 0.0]))
    assert problem.costs(neighbours(problem, at_edge, random_generator(0), NEIGHBOURHOOD)).size
