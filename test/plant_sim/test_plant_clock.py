import pytest

from plant_sim.plant_clock import PlantClock


@pytest.fixture
def wall():
    return {'now': 100.0}


def test_plant_time_runs_speed_times_as_fast(wall):
    run = PlantClock(20.0, lambda: wall['now'])
    wall['now'] += 3.0
    assert run.now() == pytest.approx(60.0)
    run.change(2.0, run.now())
    wall['now'] += 1.0
    assert run.now() == pytest.approx(62.0)


def test_a_short_delay_is_caught_up_with_and_a_long_one_given_up(wall):
    run = PlantClock(10.0, lambda: wall['now'])
    wall['now'] += 0.4
    run.yield_to(0.0)
    assert run.now() == pytest.approx(4.0) and run.lag == 0.0
    wall['now'] += 60.0
    run.yield_to(4.0)
    assert run.now() == pytest.approx(4.0) and run.lag == pytest.approx(60.0)


def test_a_pause_takes_no_plant_time(wall):
    run = PlantClock(10.0, lambda: wall['now'])
    wall['now'] += 60.0
    run.hold(7.0)
    assert run.now() == pytest.approx(7.0)
