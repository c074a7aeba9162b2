"""Tests of obs_ros.core.changes."""

import dataclasses
from functools import cached_property

import pytest

from obs_ros.core.changes import replace


@dataclasses.dataclass(frozen=True)
class Box:
    width: float
    height: float = 2.0

    def __post_init__(self) -> None:
        if self.width < 0.0:
            raise ValueError('a width is not negative')

    @cached_property
    def area(self) -> float:
        return self.width * self.height


def test_a_copy_has_the_changes_and_nothing_that_was_cached() -> None:
    box = Box(3.0)
    assert box.area == 6.0
    wider = replace(box, width=5.0)
    assert wider == dataclasses.replace(box, width=5.0) and type(wider) is Box
    assert wider.area == 10.0 and box.width == 3.0


def test_a_copy_is_checked_as_any_instance() -> None:
    with pytest.raises(ValueError, match='not negative'):
        replace(Box(1.0), width=-1.0)
    with pytest.raises(TypeError, match="Box has no field 'depth'"):
        replace(Box(1.0), depth=1.0)
