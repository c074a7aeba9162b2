"""Tests of obs_ros.horizon.gaussian_sum."""

import numpy as np
import pytest

from obs_ros.horizon.found_jumps import JumpFound, Size
from obs_ros.horizon.gaussian_sum import (
    SUM,
    Component,
    moments,
    reduced,
    same_event,
    same_lineage,
    set_at,
)

DURATION, END = 10.0, 30.0


def jump(time: float, *names: str, deviation: float = 0.1) -> JumpFound:
    return JumpFound(time, deviation, {name: Size(1.0, 0.1, 0.5, 0.05) for name in names})


def component(weight: float, mean: float, *jumps: JumpFound) -> Component:
    return Component(weight, np.array([mean]), np.array([[0.01]]), jumps)


def test_moments_are_those_of_draws() -> None:
    parts = [component(0.7, 0.2), component(0.3, 0.8)]
    mean, covariance = moments(parts)
    rng = np.random.default_rng(1)
    drawn = np.where(rng.random(100_000) < 0.7, 0.2, 0.8) + 0.1 * rng.standard_normal(100_000)
    assert mean[0] == pytest.approx(drawn.mean(), abs=0.005)
    assert covariance[0, 0] == pytest.approx(drawn.var(), rel=0.02)
    assert moments(parts[:1]) == (parts[0].mean, parts[0].covariance)


def test_those_of_the_same_jumps_are_one() -> None:
    parts = [
        component(0.5, 0.2, jump(25.0, 'h')),
        component(0.3, 0.4, jump(25.3, 'h')),
        component(0.2, 0.8, jump(25.0, 'l')),
    ]
    one, other = reduced(parts, END, DURATION)
    assert (one.weight, other.weight) == pytest.approx((0.8, 0.2))
    assert one.mean[0] == pytest.approx((0.5 * 0.2 + 0.3 * 0.4) / 0.8)
    assert one.covariance[0, 0] == pytest.approx(0.01 + 0.2**2 * 0.5 * 0.3 / 0.8**2)
    assert other.jumps == (jump(25.0, 'l'),)


def test_unlikely_ones_end_and_no_more_than_three_live() -> None:
    parts = [component(w, 0.1, jump(25.0, name)) for w, name in ((0.995, 'a'), (0.005, 'b'))]
    (only,) = reduced(parts, END, DURATION)
    assert only.weight == 1.0
    parts = [component(0.25, 0.1 * i, jump(25.0, name)) for i, name in enumerate('abcd')]
    found = reduced(parts, END, DURATION)
    assert len(found) == SUM.most
    assert sum(one.weight for one in found) == pytest.approx(1.0)


def test_history_makes_no_lineage() -> None:
    """After ten windows nobody asks any more who jumped."""
    old, new = END - 101.0, END - 99.0
    for time, count in ((old, 1), (new, 2)):
        parts = [component(0.6, 0.2, jump(time, 'h')), component(0.4, 0.5)]
        assert len(reduced(parts, END, DURATION)) == count


def test_one_event_is_one_whatever_it_is_called() -> None:
    one = jump(25.0, 'h')
    assert same_event(one, jump(25.5, 'l', 'h'), DURATION)
    assert not same_event(one, jump(25.6, 'h'), DURATION)
    assert same_event(one, jump(27.0, 'h', deviation=0.5), DURATION)
    assert not same_event(one, jump(30.1, 'h', deviation=5.0), DURATION)
    assert not same_lineage((one,), (jump(25.5, 'l'),), DURATION)
    assert not same_lineage((one,), (), DURATION)
    lineage = (one, jump(25.2, 'l'), jump(15.0, 'k'))
    assert set_at(lineage, jump(25.1, 'x'), DURATION) == {'h', 'l'}
    assert set_at(lineage, jump(20.0, 'x'), DURATION) == frozenset()
