"""Tests of obs_ros.observers.papers.unknown_input against the specification's numbers."""

import numpy as np
import pytest
from exchanger import COLD, FLOWS, played, settled, watched

from obs_ros.observers.papers.unknown_input import UnknownInputObserver


@pytest.mark.slow
def test_the_unknown_input_observer_is_slower_by_the_factors_of_the_specification() -> None:
    """4.91 and 1.51 s there; 2 % of a tail as slow as this lies within 10 %."""
    instants = played('heat_exchanger_case1', 8.0)
    observer = UnknownInputObserver('heat_exchanger', tau=(0.55, 0.19), **COLD)
    flows = watched(observer, instants, 'flows')
    assert settled(flows, FLOWS, np.array([i.t for i in instants])) == pytest.approx(
        [4.91, 1.51], rel=0.1
    )
    assert flows[-1] == pytest.approx(FLOWS, rel=1e-3)


def test_a_wrong_number_of_time_constants_is_refused() -> None:
    with pytest.raises(ValueError, match='tau must be 1 or 2 positive times in s'):
        UnknownInputObserver('heat_exchanger', tau=(0.1, 0.2, 0.3))
