"""Tests of obs_ros.observers.base."""

import pytest

from obs_ros.observers.base import OBSERVERS, Observer, load_observer


@pytest.mark.parametrize('name', OBSERVERS)
def test_every_observer_has_all_that_is_asked_of_one(name: str) -> None:
    asked = [n for n in (*vars(Observer), 'immediate') if not n.startswith('_') and n != 'model']
    assert {'absorb', 'estimate', 'reset', 'counts', 'last_break'} <= set(asked)
    assert [n for n in asked if not hasattr(load_observer(name), n)] == []


def test_observers_are_found_by_path_and_others_refused() -> None:
    assert load_observer(OBSERVERS['sliding_window']) is load_observer('sliding_window')
    with pytest.raises(ValueError, match="unknown observer 'slidin_window': did you mean"):
        load_observer('slidin_window')
    with pytest.raises(ValueError, match=r"observer 'math:pi' is 3\.14.*, not an observer class"):
        load_observer('math:pi')
