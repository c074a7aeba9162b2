"""Levels are those of diagnostic_msgs."""

import pytest

from obs_ros.interface.status import Health, Level, SubscriptionStatus


@pytest.mark.parametrize('level', Level)
def test_levels_are_the_bytes_of_the_message(level):
    messages = pytest.importorskip('diagnostic_msgs.msg')
    assert getattr(messages.DiagnosticStatus, level.name) == level.value


def test_a_subscription_begins_unheard_and_a_health_without_figures():
    status = SubscriptionStatus('plant/output', 'output')
    assert status.silence is None and status.stamp is None and status.refused == {}
    assert Health(Level.OK, 'fine').figures == {}
