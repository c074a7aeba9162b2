"""Tests of obs_ros.integration.step_choice."""

from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from obs_ros.core.typing import Array, IntArray
from obs_ros.integration.step_choice import chosen, observed_order, redistributed
from obs_ros.integration.step_trials import (
    ORDERS,
    STEPPING,
    Verdict,
    common,
    doubling_error,
    own_error,
)

BASE = np.ones(50, dtype=np.int64)
ONE = BASE.astype(np.float64)
COST = {'rk4': 1.0, 'rosenbrock': 3.0}.__getitem__


@dataclass
class Known:
    """Errors that fall as S^-p in every interval, from `sizes`; unstable below so many steps."""

    sizes: dict[str, Array]
    stable: dict[str, int] = field(default_factory=dict)
    dead: int = 0  # candidates that diverge however
    dying: bool = True  # whether a mode dies out within an interval
    judged: list[tuple[str, int]] = field(default_factory=list)
    order: float | None = None
    own: str = ''  # the method by which candidates take steps of their own
    suffices: float = 1.0  # tolerance of these
    leads: bool = True  # whether any tolerance leads the reference on
    lost: int = 0  # candidates that no steps of their own lead on, though steps of all do
    chaotic: bool = False  # whether the reference errs whatever the steps

    def decays(self) -> bool:
        return self.dying

    def takes_own(self, method: str) -> bool:
        return method == self.own

    def judge_own(self, method: str, tolerance: float) -> tuple[Verdict, IntArray]:
        """Errors in proportion to the tolerance, at the cost of its cube root."""
        self.judged.append((method, round(np.log10(tolerance))))
        excess = np.full(16, tolerance / self.suffices)
        excess[16 - self.dead - self.lost :] = np.inf
        if not self.leads:
            excess[0] = np.inf
        counts = np.full((50, 16), round(0.02 * tolerance ** (-1.0 / 3.0)) + 1)
        return Verdict(float(STEPPING.aimed * excess[0]), excess), counts

    def judge(self, method: str, steps: IntArray) -> Verdict:
        self.judged.append((method, int(steps.sum())))
        excess = np.full(16, self.errors(method, steps).sum())
        excess[16 - self.dead :] = np.inf
        if (steps < self.stable.get(method, 0)).any():
            excess[:] = np.inf
        if self.chaotic:
            excess[0] = 100.0
        return Verdict(float(STEPPING.aimed * excess[0]), excess)

    def shares(self, method: str, steps: IntArray, verdict: Verdict) -> Array:
        if np.isinf(verdict.worst()) or self.chaotic:
            return np.full(steps.size, 1e6)
        return self.errors(method, steps)

    def errors(self, method: str, steps: IntArray) -> Array:
        return self.sizes[method] / steps ** (self.order or ORDERS[method])


def test_steps_that_do_are_kept_at_the_price_of_one_look() -> None:
    trial = Known({'rk4': 0.01 * ONE})
    found = chosen(trial, ('rk4', 'rosenbrock'), BASE, COST)
    assert found.method == 'rk4' and found.fine and found.error == pytest.approx(0.05)
    np.testing.assert_array_equal(found.steps, BASE)
    assert trial.judged == [('rk4', 50)]


def test_steps_go_where_the_errors_are() -> None:
    sizes = 1e-4 * ONE
    sizes[20] = 200.0
    found = chosen(Known({'rk4': sizes}), ('rk4',), BASE, COST)
    assert found.fine and found.steps[20] >= 4
    assert np.delete(found.steps, 20).max() == 1
    # A fourth of the excess of 200 that is aimed at: 400^(1/4) = 4.5.
    assert found.steps[20] == 5


def test_the_fewest_steps_meet_the_safety_that_is_asked() -> None:
    shares = np.geomspace(1e-3, 10.0, 50)
    steps = redistributed(10 * BASE, shares, 4.0, BASE)
    left = float(np.sum(shares * (10.0 / steps) ** 4))
    assert 0.25 < left <= STEPPING.safety
    # All intervals come to errors per step alike, but for whole numbers.
    per_step = shares * (10.0 / steps) ** 4 / steps
    assert per_step.max() / per_step.min() < 3.0


def test_steps_grow_by_a_factor_at_most_and_never_fall_below_the_fewest() -> None:
    assert redistributed(BASE, 1e6 * ONE, 4.0, BASE).max() == 8
    np.testing.assert_array_equal(redistributed(40 * BASE, 1e-9 * ONE, 4.0, 7 * BASE), 7 * BASE)


def test_errors_that_fall_slowly_as_at_kinks_are_followed() -> None:
    sizes = np.where(np.arange(50) == 7, 300.0, 1e-6)
    found = chosen(Known({'rk4': sizes}, order=1.5), ('rk4',), BASE, COST)
    assert found.fine
    assert 300.0**0.667 < found.steps[7] < 4.0 * 300.0**0.667
    assert observed_order(4.0, (100.0, 10), (25.0, 20), 4.0) == pytest.approx(2.0)
    assert observed_order(4.0, (np.inf, 10), (25.0, 20), 4.0) == 4.0


def test_what_only_stability_asks_for_is_halved_again() -> None:
    trial = Known({'rk4': 1e-9 * ONE}, stable={'rk4': 10})
    found = chosen(trial, ('rk4',), BASE, COST)
    assert found.fine and found.steps.max() == 16


def test_another_method_must_be_clearly_cheaper() -> None:
    implicit = {'rosenbrock': 0.01 * ONE}
    # RK4 in 16 steps costs 5.3 times as much as one step that costs three of it.
    stiff = Known({'rk4': 1e-9 * ONE, **implicit}, stable={'rk4': 10})
    assert chosen(stiff, ('rk4', 'rosenbrock'), BASE, COST).method == 'rosenbrock'
    # Within twice the cost RK4 is kept, and nothing else is even tried.
    mild = Known({'rk4': 1e-9 * ONE, **implicit}, stable={'rk4': 4})
    found = chosen(mild, ('rk4', 'rosenbrock'), BASE, COST)
    assert found.method == 'rk4' and found.steps.max() == 6
    assert all(method == 'rk4' for method, _ in mild.judged)
    # Where the other method needs many steps too, RK4 may take more.
    slow = Known({'rk4': 1e-9 * ONE, 'rosenbrock': 200.0 * ONE}, stable={'rk4': 30})
    found = chosen(slow, ('rk4', 'rosenbrock'), BASE, COST)
    assert found.method == 'rk4' and found.steps.max() == 32


def test_candidates_that_diverge_by_every_method_do_not_count() -> None:
    trial = Known({'rk4': 0.001 * ONE, 'rosenbrock': 0.001 * ONE}, dead=8)
    found = chosen(trial, ('rk4', 'rosenbrock'), BASE, COST)
    assert found.method == 'rk4' and found.fine and found.steps.max() == 1


def test_what_explodes_by_nature_is_not_followed_for_long() -> None:
    trial = Known({'rk4': 0.001 * ONE}, dead=8, dying=False)
    found = chosen(trial, ('rk4', 'rosenbrock'), BASE, COST)
    assert found.method == 'rk4' and not found.fine and found.steps.max() == 1
    assert max(steps for _, steps in trial.judged) == 50 * 8**2
    # What an explicit method only cannot follow in few steps is followed.
    swinging = Known({'rk4': 1e-9 * ONE}, stable={'rk4': 40}, dying=False)
    found = chosen(swinging, ('rk4', 'rosenbrock'), BASE, COST)
    assert found.fine and 40 <= found.steps.max() <= 64


def test_the_limit_of_steps_holds_and_the_least_error_is_told() -> None:
    settings = replace(STEPPING, steps=2000)
    trial = Known({'rk4': 1e9 * ONE, 'rosenbrock': 1e6 * ONE})
    found = chosen(trial, ('rk4', 'rosenbrock'), BASE, COST, settings)
    assert not found.fine and found.method == 'rosenbrock'
    assert found.steps.sum() <= 2050
    assert found.error == pytest.approx(0.1 * 1e6 * 50.0 / float(found.steps[0]) ** 3)
    assert max(steps for _, steps in trial.judged) <= 2050


def test_own_steps_take_the_loosest_tolerance_that_suffices() -> None:
    trial = Known({}, own='rosenbrock', suffices=2e-7)
    found = chosen(trial, ('rosenbrock',), BASE, COST)
    assert found.fine and found.tolerance == pytest.approx(1e-7)
    assert trial.judged == [('rosenbrock', power) for power in (-4, -5, -6, -7)]
    assert found.error == pytest.approx(0.05)
    # 0.02 (1e-7)^(-1/3) = 4.3 steps an interval; five times as many are the most, or a thousand.
    np.testing.assert_array_equal(found.steps, 5 * BASE)
    assert found.budget == 5 * 250 + 500
    assert chosen(Known({}, own='rosenbrock'), ('rosenbrock',), BASE, COST).budget == 1500


def test_own_steps_that_never_suffice_end_at_the_tightest_tolerance() -> None:
    found = chosen(Known({}, own='rosenbrock', suffices=1e-30), ('rosenbrock',), BASE, COST)
    assert not found.fine and found.tolerance == pytest.approx(STEPPING.tightest)
    # What no tolerance leads on shares the steps of the grid.
    trial = Known({'rosenbrock': 0.01 * ONE}, own='rosenbrock', leads=False)
    found = chosen(trial, ('rosenbrock',), BASE, COST)
    assert found.fine and found.tolerance == 0.0 and len(trial.judged) == 3


def test_of_candidates_that_no_steps_lead_on_rk4_is_kept_where_it_serves_the_others() -> None:
    trial = Known({'rk4': 0.001 * ONE}, own='rosenbrock', dead=8)
    found = chosen(trial, ('rk4', 'rosenbrock'), BASE, COST)
    assert found.method == 'rk4' and found.fine and found.tolerance == 0.0
    stiff = Known({'rk4': 1e-9 * ONE}, stable={'rk4': 40}, own='rosenbrock')
    found = chosen(stiff, ('rk4', 'rosenbrock'), BASE, COST)
    assert found.method == 'rosenbrock' and found.tolerance == STEPPING.loosest


def test_errors_of_own_steps_are_those_beside_a_tenth_of_the_tolerance() -> None:
    exact, errors = 1.0, np.array([1.0, 0.1**0.75])  # of an order of 3
    assert own_error(np.array([exact * (errors[0] - errors[1])]))[0] == pytest.approx(1.0)


def test_doubling_tells_the_error_of_a_step() -> None:
    h = 0.1
    rk4 = sum(h**i / np.prod(np.arange(1.0, i + 1.0)) for i in range(5))
    half = sum((h / 2) ** i / np.prod(np.arange(1.0, i + 1.0)) for i in range(5))
    error = doubling_error(np.array([rk4 - half**2]), 'rk4')
    assert error[0] == pytest.approx(np.exp(h) - rk4, rel=0.05)


def test_most_values_are_a_share_of_them() -> None:
    values = np.array([[1.0, 5.0, np.inf, 2.0], [0.0, 0.0, 0.0, 9.0]])
    np.testing.assert_array_equal(common(values, 0.75), [5.0, 0.0])
    np.testing.assert_array_equal(common(np.empty((2, 0)), 0.75), [0.0, 0.0])


def test_own_steps_that_most_do_not_survive_are_not_taken() -> None:
    # As where a right-hand side switches all the time, and the reference rests.
    sizes = {'rk4': 1e6 * ONE, 'rosenbrock': 20.0 * ONE}
    few = chosen(Known(sizes, own='rosenbrock', lost=3), ('rk4', 'rosenbrock'), BASE, COST)
    assert few.tolerance > 0.0
    many = chosen(Known(sizes, own='rosenbrock', lost=8), ('rk4', 'rosenbrock'), BASE, COST)
    assert many.fine and many.method == 'rosenbrock' and many.tolerance == 0.0
    assert many.steps.max() > 8


def test_a_reference_that_is_lost_by_every_method_excuses_none_of_them() -> None:
    sizes = {'rk4': 1e-9 * ONE, 'rosenbrock': 20.0 * ONE}
    trial = Known(sizes, stable={'rk4': 1000}, own='rosenbrock', leads=False)
    found = chosen(trial, ('rk4', 'rosenbrock'), BASE, COST)
    assert found.fine and found.method == 'rosenbrock' and found.tolerance == 0.0


def test_a_reference_that_no_steps_lead_on_is_not_awaited_where_it_errs_alone() -> None:
    """As where nominal values are chaotic: the steps that suffice for the others are taken."""
    trial = Known({'rk4': 0.01 * ONE}, dying=False, chaotic=True)
    found = chosen(trial, ('rk4', 'rosenbrock'), BASE, COST)
    assert found.method == 'rk4' and not found.fine
    np.testing.assert_array_equal(found.steps, BASE)
    assert len({steps for _, steps in trial.judged}) == 2
