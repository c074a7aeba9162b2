"""Tests of obs_ros.integration.path."""

import pytest

from obs_ros.integration.path import LANES, lanes


@pytest.mark.parametrize(('count', 'width'), [(1, 16), (15, 16), (16, 16), (17, 32), (33, 48)])
def test_candidates_fill_whole_chunks(count: int, width: int) -> None:
    assert lanes(count) == width and width % LANES == 0
