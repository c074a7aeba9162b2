"""Simulator and estimator together, in one process: the whole path but for the installation."""

from functools import partial

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from ros import Waiting, set_parameter, vector
from std_srvs.srv import SetBool

from obs_ros.ros.estimator import Estimator
from plant_sim.node import Simulator


def started(ros, plant, settings):
    """Return a simulator at rest, and an estimator that is ready and that the plant waits for."""
    clock = Waiting()
    simulator = ros.start(partial(Simulator, clock=clock), enabled=False, **plant)
    estimator = ros.start(Estimator, **settings)

    def behind():
        taken = min(heard.received for heard in estimator.estimation.streams.subscriptions.values())
        return taken < simulator.sent - 5 or not estimator.estimation.idle

    for stream in ('output', 'input'):
        ros.spin_until(lambda topic=f'plant/{stream}': simulator.count_subscribers(topic))
    ros.spin_until(lambda: estimator.estimation.progress.ready, timeout=90.0)
    clock.behind = behind
    return simulator, estimator


def test_the_estimate_follows_a_fault(ros):
    simulator, _ = started(
        ros,
        {'speed': 400, 'snr_db': 60},
        {'window__duration': 200, 'window__period': 100},
    )
    estimates, truth = ros.listen('/estimator/parameters'), ros.listen('/plant/parameters')
    states, levels = ros.listen('/estimator/state'), ros.listen('/plant/state')
    ros.call('/simulator/enable', SetBool, data=True)
    ros.spin_until(lambda: len(estimates) >= 2, timeout=60.0)
    assert vector(estimates[-1]) == pytest.approx({'p1': 1.0, 'p2': 1.0, 'p3': 1.0}, abs=0.02)

    assert set_parameter(simulator, 'plant.p2', 0.6).successful
    ros.spin_until(lambda: truth[-1].position[1] == 0.6)
    changed = truth[-1].header.stamp.sec

    def settled():
        return [e for e in estimates if e.header.stamp.sec >= changed + 300]

    estimate = ros.spin_until(settled, timeout=60.0)[0]
    assert vector(estimate)['p2'] == pytest.approx(0.6, abs=0.02)
    # The state is that of the newest sample used, not of the window's start.
    stamp = estimate.header.stamp
    state, level = (
        ros.spin_until(lambda heard=heard: [m for m in heard if m.header.stamp == stamp])[0]
        for heard in (states, levels)
    )
    assert vector(state) == pytest.approx(vector(level), abs=0.2)


def test_a_fault_is_announced_by_the_first_window_that_shows_it(ros):
    simulator, _ = started(
        ros,
        {'speed': 400, 'snr_db': 40, 'seed': 4},
        {'window__duration': 200, 'window__period': 50},
    )
    estimates, truth = ros.listen('/estimator/parameters'), ros.listen('/plant/parameters')
    deviations = ros.listen('/estimator/parameters_stddev')
    jumps, health = ros.listen('/estimator/jump'), ros.listen('/diagnostics', DiagnosticArray)
    ros.call('/simulator/enable', SetBool, data=True)
    ros.spin_until(lambda: len(estimates) >= 3, timeout=60.0)
    assert not jumps

    assert set_parameter(simulator, 'plant.p1', 0.5).successful
    ros.spin_until(lambda: truth[-1].position[0] == 0.5)
    # The value holds from the sample that carries it on.
    changed = next(m.header.stamp.sec for m in truth if m.position[0] == 0.5)
    shown = 50  # s: one period
    ros.spin_until(
        lambda: [e for e in estimates if e.header.stamp.sec >= changed + shown + 1], timeout=60.0
    )
    jump = ros.spin_until(lambda: jumps)[0]
    assert vector(jump) == pytest.approx({'p1': -0.5}, abs=0.02)
    assert abs(jump.position[0] + 0.5) < 4.0 * jump.effort[0] < 0.1
    moment = jump.header.stamp.sec + 1e-9 * jump.header.stamp.nanosec
    assert moment == pytest.approx(changed, abs=1.0)
    first = next(e for e in estimates if e.header.stamp.sec > changed + 1)
    deviation = next(d for d in deviations if d.header.stamp == first.header.stamp)
    assert abs(vector(first)['p1'] - 0.5) < 4.0 * vector(deviation)['p1']

    def told():
        figures = [entry for status in health[-1].status for entry in status.values]
        return [entry.value for entry in figures if entry.key == 'last_jump']

    assert 'p1 -0.5' in ros.spin_until(told)[0]
    assert len(jumps) == 1
