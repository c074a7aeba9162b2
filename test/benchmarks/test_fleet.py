"""Short form of the fleet: two processes, four plants, and the judgement of what was measured."""

from itertools import pairwise

import pytest
from patience import patience

pytest.importorskip('rclpy')

from benchmarks.fleet.report import report
from benchmarks.fleet.run import Load, Measured, Process, measured, schedule
from demo.domain import Domain


def test_plants_begin_spread_over_a_period_and_send_as_often_as_told():
    load = Load(plants=3, rate=10.0, every=6, window=4, seconds=1.0)
    sent = [*schedule(load)]
    assert [at for at, *_ in sent] == sorted(at for at, *_ in sent)
    for plant in range(3):
        own = [(at, sample) for at, k, sample in sent if k == plant]
        assert [sample for _, sample in own] == list(range(10))
        gaps = [later[0] - before[0] for before, later in pairwise(own)]
        assert gaps == pytest.approx([0.1] * 9)
        assert own[0][0] == pytest.approx(plant / 3 * 0.6 + plant / 30)
    assert load.windows == 3
    at_once = [at for at, _, sample in schedule(load._replace(at_once=True)) if not sample]
    assert max(at_once) < 0.1


def test_what_is_asked_is_judged():
    load = Load(plants=2, seconds=40.0)
    found = Measured(
        load, 1600, 1600, 3, 1, 0, [0.1, 0.2, 0.3, 1.5],
        {'fleet 0': Process(400.0, 300.0, 0.5), 'senders': Process(900.0, 900.0, 0.1)}, 0.01, [0],
    )  # fmt: skip
    text = report(found)
    assert load.windows == 4
    for line in ('700 MB | 400 MB | yes', '1600: none | 0 | yes', '0 skipped, 4 solved | yes',
                 '>= 99% | 75.00% | **no**', 'exit codes 0 | 0 | yes'):  # fmt: skip
        assert line in text
    text = report(found._replace(received=1599, published=2, codes=[1]))
    assert text.count('**no**') == 4


@pytest.mark.slow
def test_a_short_run_of_two_fleets_loses_nothing(monkeypatch):
    for name in ('ROS_DOMAIN_ID', 'ROS_AUTOMATIC_DISCOVERY_RANGE'):
        monkeypatch.setenv(name, '')  # put back afterwards what it sets
    load = Load(plants=4, rate=10.0, window=20, every=20, seconds=patience(1.0))
    with Domain() as domain:
        found = measured(load, domain)
    assert (found.sent, found.received) == (2 * 4 * load.samples,) * 2
    # A busy machine may skip windows, and says so.
    assert found.published + found.withheld + found.skipped == load.windows >= 8
    assert len(found.latencies) == found.published and min(found.latencies) > 0.0
    assert found.codes == [0, 0]
