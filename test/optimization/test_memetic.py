"""Tests of obs_ros.optimization.memetic."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from problems import Curve, decay_problem, ripples_problem

from obs_ros.core.deadline import Deadline
from obs_ros.core.typing import Array
from obs_ros.optimization import memetic
from obs_ros.optimization.levenberg_marquardt import LMSettings, Starts
from obs_ros.optimization.memetic import MemeticSettings, Rounds, memetic_search

NEVER = Deadline()
FAST = MemeticSettings()
SAFE = replace(FAST, acceptance='safe')


def with_unit_noise(problem: Curve, sigma: float) -> Curve:
    """The same problem in units of its noise."""
    curve = problem.curve
    return Curve(lambda z, s: curve(z, s) / sigma, problem.s, problem.y / sigma, problem.dimension)


@pytest.mark.parametrize('nodes', [60, 400])
def test_with_known_noise_chi_square_and_convergence_decide(nodes: int) -> None:
    problem = with_unit_noise(decay_problem(sigma=0.02, nodes=nodes), 0.02)
    found = memetic_search(problem, np.random.default_rng(1), NEVER, FAST, noise_known=True)
    assert found.accepted == 'the residual is as small as the noise'
    assert found.converged
    assert str(found.effort) == '1 round'
    assert found.cost < 1.4 * nodes


def test_with_a_residual_above_the_given_noise_another_round_must_agree() -> None:
    problem = with_unit_noise(decay_problem(sigma=0.02), 0.005)
    found = memetic_search(problem, np.random.default_rng(1), NEVER, FAST, noise_known=True)
    assert found.accepted == 'two rounds agree'
    assert str(found.effort) == '2 rounds'


def test_with_unknown_noise_two_survivors_must_agree_on_a_white_residual() -> None:
    found = memetic_search(decay_problem(), np.random.default_rng(1), NEVER, FAST)
    assert found.accepted == 'two survivors agree and the residual is white'
    assert str(found.effort) == '1 round'


def test_the_safe_rule_takes_two_rounds() -> None:
    rounds = []
    for seed in range(10):
        found = memetic_search(decay_problem(seed=seed), np.random.default_rng(seed), NEVER, SAFE)
        assert found.accepted.startswith('two rounds agree')
        rounds.append(found.effort.number)
    assert rounds == [2] * 10


def test_a_residual_that_is_not_white_takes_two_rounds() -> None:
    """A third would find the same: what is left is no fault of the search."""
    problem = decay_problem()
    problem.y = problem.y + 0.05 * np.sin(20.0 * problem.s)
    found = memetic_search(problem, np.random.default_rng(1), NEVER, FAST)
    assert found.accepted == 'two rounds agree'
    assert str(found.effort) == '2 rounds'


def test_a_residual_of_rounding_is_not_asked_for_its_colour() -> None:
    found = memetic_search(decay_problem(sigma=0.0), np.random.default_rng(1), NEVER, FAST)
    assert found.accepted == 'two survivors agree and the residual is white'
    np.testing.assert_allclose(found.z, (0.7, 0.4, 0.2), atol=1e-6)


def test_it_gives_up_after_its_rounds() -> None:
    problem = decay_problem()
    problem.y = problem.y + 0.05 * np.sin(20.0 * problem.s)
    found = memetic_search(problem, np.random.default_rng(1), NEVER, replace(FAST, max_rounds=1))
    assert str(found.effort) == '1 round'
    assert not found.accepted


def test_it_needs_fewer_rollouts_than_the_papers_search() -> None:
    problem = ripples_problem()
    memetic_search(problem, np.random.default_rng(3), NEVER, FAST)
    assert problem.evaluations < 2150


def test_a_deadline_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = [0.0]
    monkeypatch.setattr(Deadline, '_now', staticmethod(lambda: clock[0]))
    problem = ripples_problem()
    quick = problem.curve

    def curve(z: Array, s: Array) -> Array:
        clock[0] += 0.002
        return quick(z, s)

    problem.curve = curve
    deadline = Deadline(0.1)
    found = memetic_search(
        problem, np.random.default_rng(3), deadline, replace(SAFE, max_rounds=1000)
    )
    # A step of least squares may be under way: five rollouts.
    assert -0.01 < deadline.remaining <= 0.0
    assert np.isfinite(found.cost)


def lanes(problem: Curve, deadline: Deadline, warm: Array | None = None) -> list[int]:
    """How many candidates each rollout without derivatives had, in one search."""
    seen, costs = [], problem.costs

    def counted(z: Array, nodes: int | None = None) -> Array:
        seen.append(len(z))
        return costs(z, nodes)

    problem.costs = counted  # type: ignore[method-assign]
    memetic_search(problem, np.random.default_rng(1), deadline, FAST, warm)
    return seen


def test_without_time_no_candidate_is_rolled_out_twice() -> None:
    problem = decay_problem(nodes=200)
    assert lanes(problem, Deadline(0.0)) == [32]
    assert problem.evaluations == 32


def test_a_warm_start_takes_the_place_of_another_candidate() -> None:
    warm = np.full(3, 0.5)  # 32 fill the lanes of two chunks
    assert set(lanes(decay_problem(nodes=200), NEVER, warm)) == {32}
    assert lanes(decay_problem(nodes=200), Deadline(0.0), warm) == [32]


def ends(squares: list[float], converged: list[bool]) -> Starts:
    return Starts(np.full((len(squares), 3), 0.5), np.array(squares), np.array(converged))


def test_half_of_the_starts_must_have_converged_to_stop_the_others(monkeypatch: Any) -> None:
    """Where data tell little two may well agree on a false minimum."""
    seen: list[Any] = []
    real = memetic.levenberg_marquardt

    def spied(*arguments: Any) -> Starts:
        if len(arguments) > 5:
            seen.append((len(arguments[1]), arguments[5]))
        return real(*arguments)

    monkeypatch.setattr(memetic, 'levenberg_marquardt', spied)
    Rounds(decay_problem(nodes=60), np.random.default_rng(1), NEVER, FAST, None, False).run(0)
    ((count, enough),) = seen
    assert count == 8
    for agreeing in range(1, 9):
        stopped = ends([1e-3] * agreeing, [True] * agreeing)
        assert enough(stopped) == (agreeing >= 4)


def test_squares_as_small_as_the_noise_are_not_enough_where_nothing_converged() -> None:
    problem = with_unit_noise(decay_problem(nodes=103), 0.01)
    for converged in (False, True):
        local = LMSettings() if converged else LMSettings(converged_gain=0.0)
        once = replace(FAST, max_rounds=1, local=local)
        found = memetic_search(problem, np.random.default_rng(1), NEVER, once, noise_known=True)
        assert found.cost < 103.0 and found.converged == converged
        assert found.accepted == ('the residual is as small as the noise' if converged else None)
