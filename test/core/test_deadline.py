"""Tests of obs_ros.core.deadline."""

import math
import threading

import pytest

from obs_ros.core.deadline import Deadline, uncounted


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


def test_what_is_spent_once_does_not_count(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = [0.0]
    monkeypatch.setattr(Deadline, '_now', staticmethod(lambda: clock[0]))
    with uncounted():
        clock[0] += 7.0
    deadline = Deadline(10.0)
    with uncounted(), uncounted():
        clock[0] += 100.0
    clock[0] += 4.0
    assert (deadline.elapsed, deadline.remaining) == pytest.approx((4.0, 6.0))
    other = threading.Thread(target=spend, args=(clock, 5.0))
    other.start()
    other.join()
    assert (deadline.elapsed, deadline.remaining) == pytest.approx((9.0, 1.0))
    with pytest.raises(ZeroDivisionError), uncounted():
        clock[0] += 100.0 / 0.0
    clock[0] += 1.001
    assert deadline.passed


def spend(clock: list[float], seconds: float) -> None:
    """Let time pass that another thread does not count."""
    with uncounted():
        clock[0] += seconds
