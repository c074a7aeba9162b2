"""Tests of obs_ros.optimization.result."""

from obs_ros.optimization.result import Effort


def test_an_effort_is_told_with_its_unit() -> None:
    assert [str(Effort(n, 'round')) for n in (0, 1, 2)] == ['0 rounds', '1 round', '2 rounds']
