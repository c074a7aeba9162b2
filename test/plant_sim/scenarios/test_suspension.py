import math

import pytest

from obs_ros.models.suspension import KT
from plant_sim.scenarios.suspension import COSINES, RECTANGLES, SOFT_TYRE, TRAPEZOIDS
from plant_sim.simulation import Simulation


@pytest.mark.parametrize(
    ('scenario', 'heights'),
    [
        (TRAPEZOIDS, {10.1: 0.025, 10.2: 0.05, 12.8: 0.05, 12.9: 0.025}),
        (COSINES, {10.75: 0.05, 11.5: 0.1, 12.25: 0.05}),
        (RECTANGLES, {10.0: 0.05, 12.999: 0.05}),
    ],
)
def test_roads_have_two_bumps(scenario, heights):
    for t in (0.0, 9.999, 13.0, 15.0, 64.0):
        assert scenario.inputs(t) == pytest.approx((0.0, 2.0), abs=1e-12)
    for t, height in heights.items():
        assert scenario.inputs(t)[0] == pytest.approx(height, abs=1e-9)
        assert scenario.inputs(t + 10.0)[0] == pytest.approx(height, abs=1e-9)


def test_the_force_on_the_damper_rises_and_stays():
    values = {t: TRAPEZOIDS.parameters(t)[1] for t in (0.0, 8.0, 10.0, 12.0, 65.0)}
    assert list(values.values()) == pytest.approx([0.0, 0.0, 150.0, 300.0, 300.0])
    assert all(TRAPEZOIDS.parameters(t)[0] == KT for t in values)


def test_the_tyre_softens_between_the_bumps():
    schedule = SOFT_TYRE.parameters
    assert [schedule(t) for t in (11.0, 14.99, 15.0)] == [
        (KT, 225.0), (KT, 300.0), (0.8 * KT, 300.0)
    ]  # fmt: skip


def test_without_the_force_the_car_comes_to_rest_on_the_bump():
    simulation = Simulation(TRAPEZOIDS, period=0.05, snr_db=math.inf)
    simulation.faults = {'eta': 0.0}
    instants = [simulation.sample() for _ in range(256)]
    assert instants[200].x == pytest.approx((0.0,) * 4, abs=1e-12)
    assert instants[-1].t == pytest.approx(12.75)
    assert instants[-1].x == pytest.approx((0.05, 0.0, 0.05, 0.0), abs=2e-3)
    assert max(i.x[0] for i in instants) > 0.055
