"""Tests of obs_ros.observers.papers.high_gain against the specification's numbers."""

import pytest
from exchanger import coloured, played, rms_percent, true_flows, watched

from obs_ros.observers.papers.high_gain import HighGainObserver
from obs_ros.observers.papers.interconnected import InterconnectedObserver


@pytest.mark.slow
def test_with_valves_in_motion_knowing_them_pays() -> None:
    """Case 3, seed 2: at most a third of the errors of the plain observer."""
    instants = played('heat_exchanger_case3', 20.0)
    noise, truth = coloured(len(instants), seed=2), true_flows(instants)
    informed, plain = (
        rms_percent(
            watched(kind('heat_exchanger'), instants, 'flows', noise)[10000:], truth[10000:]
        )
        for kind in (InterconnectedObserver, HighGainObserver)
    )
    assert (informed <= plain / 3.0).all()
    assert (plain > 4.0).all()
