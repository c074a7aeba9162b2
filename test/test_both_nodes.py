"""Simulator and estimator together, in one process: the whole path but for the installation."""

import pytest
from ros import set_parameter, vector
from std_srvs.srv import SetBool

from obs_ros.node.estimator import Estimator
from plant_sim.node import Simulator


def test_the_estimate_follows_a_fault(ros):
    simulator = ros.start(Simulator, speed=200, enabled=False, snr_db=60)
    estimator = ros.start(Estimator, window__duration=200, window__period=100)
    estimates, truth = ros.listen('/estimator/parameters'), ros.listen('/plant/parameters')
    states, levels = ros.listen('/estimator/state'), ros.listen('/plant/state')
    ros.spin_until(lambda: estimator.progress.ready, timeout=90.0)
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
