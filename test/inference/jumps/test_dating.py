"""Tests of obs_ros.inference.jumps.dating."""

from itertools import pairwise

import numpy as np
import pytest
from plants import OSCILLATOR, oscillator_dynamics, window_of
from scipy.integrate import solve_ivp

from obs_ros import Record
from obs_ros.core.deadline import Deadline
from obs_ros.core.typing import Array
from obs_ros.inference.jumps.dating import DATING, dated
from obs_ros.inference.jumps.hypothesis import Hypothesis, hypothesis_at
from obs_ros.inference.jumps.jump_search import JumpSearch
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.prior import Prior
from obs_ros.optimization.levenberg_marquardt import levenberg_marquardt

T = 0.1 * np.arange(301)
SIGMA, BEFORE = 0.02, np.array([0.8, 1.0])
STIFFNESS = 2  # place of the unknown
LOWER, WIDTH = np.array([0.2, 0.0]), np.array([1.8, 2.0])


def measured(jump: float, time: float, seed: int) -> Record:
    """An oscillation whose stiffness jumps, by an integrator of eighth order."""
    rng = np.random.default_rng(seed)
    u = 0.5 * np.sign(np.sin(0.7 * T))
    x, states = np.array([1.0, 0.0]), [np.array([1.0, 0.0])]
    for k in range(T.size - 1):
        edges = [T[k], *([time] if T[k] < time < T[k + 1] else []), T[k + 1]]
        for start, end in pairwise(edges):
            p = BEFORE + np.array([jump if start >= time else 0.0, 0.0])
            x = solve_ivp(
                lambda t, x, p=p, k=k: oscillator_dynamics(t, x, u[k : k + 1], p),
                (start, end), x, 'DOP853', rtol=1e-9, atol=1e-11,
            ).y[:, -1]  # fmt: skip
        states.append(x)
    values = [BEFORE + np.array([jump if now > time else 0.0, 0.0]) for now in T]
    outputs = [OSCILLATOR.output(*each) for each in zip(T, states, u[:, None], values, strict=True)]
    return Record(T, u, np.array(outputs) + SIGMA * rng.standard_normal((T.size, 2)))


def without_jump(record: Record, deviation: float | None = 1e-3) -> Hypothesis:
    """The fit without a jump, with parameters known to a `deviation` (boxes), None: not at all."""
    objective = window_of(OSCILLATOR, record, SIGMA, backend=None)  # NumPy takes ten times as long
    prior = Prior.box(objective.unknowns)
    if deviation is not None:
        mean = (BEFORE - LOWER) / WIDTH
        prior = Prior.of(objective.unknowns, mean, deviation**2 * np.eye(2))
    problem = PiecewiseProblem(objective, prior)
    start = np.array([0.7, 0.5, *prior.mean[2:]])
    found = levenberg_marquardt(problem, start[None], T.size, 60, Deadline())
    return hypothesis_at(problem, found.z[0])


def after(best: Hypothesis) -> tuple[float, Array]:
    """Time (s) and stiffness after the one jump."""
    return T[-1] * best.point[4], LOWER[0] + WIDTH[0] * best.point[5]


@pytest.mark.parametrize('jump', [-0.4, 0.6, 1.0])
@pytest.mark.parametrize('time', [4.33, 12.71])
def test_a_jump_that_throws_an_oscillation_out_of_phase_is_found(jump: float, time: float) -> None:
    still = without_jump(measured(jump, time, seed=round(10 * time)))
    assert still.squares > 10.0 * 2 * T.size
    starts = list(dated(still, Deadline()))
    assert starts[0].parameters == {STIFFNESS}
    part = T[-1] / DATING.parts
    assert -DATING.back * part <= starts[0].point[4] * T[-1] - time <= 2.0 * part
    best = JumpSearch(still, Deadline(), known=None).run()
    assert best.problem.events == ((STIFFNESS,),)
    found, value = after(best)
    assert found == pytest.approx(time, abs=0.3)
    assert value == pytest.approx(
        BEFORE[0] + jump, abs=5.0 * WIDTH[0] * best.covariance[5, 5] ** 0.5
    )
    assert best.squares < 2 * T.size + 5.0 * (4 * T.size) ** 0.5


def test_nothing_is_dated_without_earlier_windows() -> None:
    """Any parameters explain a first part then."""
    assert not list(dated(without_jump(measured(0.6, 12.71, seed=1), None), Deadline()))


def test_starts_lie_within_the_box_and_name_no_parameter_twice() -> None:
    starts = list(dated(without_jump(measured(0.6, 12.71, seed=1)), Deadline()))
    assert starts[0].parameters == {STIFFNESS}
    assert len({start.parameters for start in starts}) == len(starts) <= 2
    for start in starts:
        low, high = start.problem.limits
        assert (start.point >= low).all() and (start.point <= high).all() and not start.earlier
