"""Short forms of the soak and the fuzz: the estimator as a process, fed a lot and fed rubbish."""

import random

import pytest
from patience import patience

pytest.importorskip('rclpy')

from benchmarks.fuzz.run import fuzzed
from benchmarks.live import Live
from benchmarks.soak.report import GROWTH
from benchmarks.soak.run import soaked
from demo.domain import Domain

pytestmark = pytest.mark.slow


@pytest.fixture
def live(monkeypatch):
    domain = Domain()
    monkeypatch.setattr(Live, 'patience', patience(1.0))
    for name in ('ROS_DOMAIN_ID', 'ROS_AUTOMATIC_DISCOVERY_RANGE'):
        monkeypatch.setenv(name, '')  # put back afterwards what it sets
    live = Live(domain.number, 'window.duration:=20.0')
    yield live
    if live.process.poll() is None:
        live.process.kill()
        live.process.wait()
    live._written.close()
    domain.close()


def test_a_short_soak_loses_nothing_and_keeps_its_memory(live):
    found = soaked(live, 12000, 1000.0)  # the first windows load what is compiled
    assert found.lost == 0 and found.growth < GROWTH
    figures = {name: int(found.figures[name]) for name in ('published', 'skipped', 'predicted')}
    # A busy machine may skip windows, and says so.
    assert figures['published'] + figures['skipped'] >= 10
    assert figures['published'] > 0 and figures['predicted'] > 0
    assert found.figures['failed'] == '0'
    assert found.code == 0 and not found.traceback


def test_rubbish_is_counted_and_survived(live):
    found = fuzzed(live, 2000, random.Random(7))
    assert found.uncounted == 0 and found.non_finite == 0
    assert found.figures['failed'] == '0'
    assert found.last == pytest.approx({'p1': 1.0, 'p2': 1.0, 'p3': 1.0}, abs=0.05)
    assert found.code == 0 and not found.traceback
