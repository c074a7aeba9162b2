"""Tests of obs_ros.core.estimate."""

from typing import Any

import numpy as np
import pytest

from obs_ros import Estimate, Outcome


def estimate(**changes: Any) -> Estimate:
    values: dict[str, Any] = {
        'parameters': {'p': 1.0},
        'initial_state': {'x': 2.0},
        'state': {'x': 3.0},
        'stddev': {'x': np.nan, 'p': np.nan},
        'outcome': Outcome.CONVERGED,
        'message': 'two rounds agree',
        't0': 0.0,
        't1': 1.0,
    }
    return Estimate(**(values | changes))


def test_outcomes_are_the_words_of_the_contract() -> None:
    assert {str(outcome) for outcome in Outcome} == {
        'converged', 'approximate', 'deadline', 'not_identifiable', 'at_bound', 'model_mismatch',
        'too_few_samples', 'stale_output', 'stale_input', 'diverged',
    }  # fmt: skip


def test_usable_without_standard_deviations() -> None:
    assert estimate().usable
    assert estimate(parameters={}).usable


@pytest.mark.parametrize('field', ['parameters', 'initial_state', 'state'])
@pytest.mark.parametrize('value', [np.nan, np.inf])
def test_not_usable_with_a_value_that_is_not_finite(field: str, value: float) -> None:
    assert not estimate(**{field: {'name': value}}).usable


def test_estimates_compare_by_identity_since_they_hold_arrays() -> None:
    one, other = (estimate(times=np.arange(3.0), states=np.zeros((3, 1))) for _ in range(2))
    assert one == one and one != other
    assert len({one, other, one}) == 2
