"""Tests of obs_ros.core.deadline."""

import math

import pytest

from obs_ros.core.deadline import Deadline


def test_never() -> None:
    deadline = Deadline()
    assert deadline.never
    assert not deadline.passed
    assert deadline.remaining == math.inf


def test_at_once_and_later() -> None:
    assert Deadline(0.0).passed
    later = Deadline(100.0)
    assert not later.passed and not later.never
    assert 99.0 < later.remaining <= 100.0


@pytest.mark.parametrize('seconds', [-1e-9, -1.0, math.nan])
def test_a_time_that_is_none_is_refused(seconds: float) -> None:
    with pytest.raises(ValueError, match=f'deadline {seconds}'):
        Deadline(seconds)
