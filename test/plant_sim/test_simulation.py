import math
from dataclasses import replace
from types import MappingProxyType

import numpy as np
import plants
import pytest
from plants import VESSEL

from obs_ros.core.model import names
from plant_sim.actuators import Actuator
from plant_sim.scenario import Scenario
from plant_sim.scenarios import load_scenario
from plant_sim.sensors import Sensor
from plant_sim.signals import constant
from plant_sim.simulation import Simulation
from plant_sim.sources import PIController, WhiteGaussian

THREE_TANK = load_scenario('three_tank')
# spec/three_tank_chaotic_de.md: Radau, checked; at 1000, 2000 and 3000 s.
LEVELS = {
    1000: (21.25897, 14.17197, 17.71669),
    2000: (59.53719, 49.96477, 52.93330),
    3000: (86.27335, 52.72873, 65.42825),
}


@pytest.mark.parametrize('period', [1.0, 12.5])
def test_three_tanks_reach_the_levels_of_an_independent_solver(period):
    simulation = Simulation(THREE_TANK, period=period, snr_db=math.inf)
    reached = {i.t: i for i in (simulation.sample() for _ in range(round(3000 / period) + 1))}
    for t, levels in LEVELS.items():
        assert reached[t].x == pytest.approx(levels, abs=1e-5)
        assert reached[t].y == reached[t].x[:2]
    assert [reached[t].p for t in (0, 1000, 2000)] == list(THREE_TANK.parameters.values)


def test_changes_between_samples_happen_on_their_time():
    simulation = Simulation(THREE_TANK, period=300.0, snr_db=math.inf)
    instants = [simulation.sample() for _ in range(11)]
    assert instants[-1].x == pytest.approx(LEVELS[3000], abs=1e-5)


def test_noise_is_seeded_and_as_strong_as_asked():
    def outputs(**options):
        simulation = Simulation(THREE_TANK, **options)
        return np.array([simulation.sample().y for _ in range(2000)])

    exact = outputs(snr_db=math.inf)
    noisy = outputs(seed=5, snr_db=20.0)
    assert np.array_equal(noisy, outputs(seed=5, snr_db=20.0))
    assert (noisy - exact).std() == pytest.approx(0.1, rel=0.08)


def test_measured_power_scales_the_noise_to_each_output():
    simulation = Simulation(THREE_TANK, snr_db=20.0, noise_reference='measured')
    quiet = Simulation(THREE_TANK, snr_db=math.inf)
    pairs = [(simulation.sample().y, quiet.sample().y) for _ in range(3000)]
    noisy, exact = np.array(pairs).transpose(1, 0, 2)
    rms = np.sqrt(np.mean(exact**2, axis=0))
    assert (noisy - exact).std(axis=0) / rms == pytest.approx([0.1, 0.1], rel=0.08)


def test_a_fault_holds_whatever_is_scheduled_until_it_is_taken_away():
    simulation = Simulation(THREE_TANK, period=100.0)
    for _ in range(6):
        simulation.sample()
    simulation.faults['p1'] = 0.2
    assert {simulation.sample().p[0] for _ in range(10)} == {0.2}
    simulation.faults.clear()
    assert simulation.sample().p[0] == 0.7


def test_a_period_that_is_not_positive_is_refused():
    with pytest.raises(ValueError, match='not positive'):
        Simulation(THREE_TANK, period=0.0)


def vessel(**changes):
    settings = {
        'name': 'vessel',
        'model': 'plants:VESSEL',
        'initial_state': (3.0,),
        'inputs': PIController(2.0, 1.0, constant(2.0)),
        'parameters': constant(0.7, 0.0),
        'sample_period': 0.1,
        'duration': 20.0,
        'snr_db': math.inf,
    }
    return Scenario(**(settings | changes))


def play(scenario, **options):
    simulation = Simulation(scenario, **options)
    return [simulation.sample() for _ in range(round(scenario.duration / simulation.period))]


@pytest.mark.parametrize('period', [0.1, 0.05])
def test_a_closed_loop_holds_the_reference_against_a_load(period):
    end = play(vessel(), period=period)[-1]
    assert (*end.x, *end.u) == pytest.approx((2.0, 0.7), abs=1e-6)


def test_a_controller_acts_at_once_on_what_is_measured_with_noise_and_disturbance():
    scenario = vessel(snr_db=20.0, disturbance=lambda t: (math.sin(t),))
    instants = play(scenario, seed=3)
    y, u = (np.array([getattr(i, name)[0] for i in instants]) for name in 'yu')
    np.testing.assert_allclose(u, 2.0 * (y - 2.0) + 0.1 * np.cumsum(y - 2.0), rtol=1e-12)
    x = np.array([i.x[0] for i in instants])
    # The input set at a sample is held to the next.
    np.testing.assert_allclose(np.diff(x), 0.1 * (0.7 - u[:-1]), atol=1e-12)


def test_a_controller_sees_its_own_last_input_where_that_passes_to_the_output():
    first, second, *_ = play(vessel(parameters=constant(0.7, 0.5)))
    assert first.u == (2.0 * 1.0 + 0.1 * 1.0,) and first.y == (3.0 + 0.5 * 2.1,)
    seen = second.x[0] + 0.5 * first.u[0] - 2.0
    assert second.u[0] == pytest.approx(2.0 * seen + 0.1 * (1.0 + seen), rel=1e-12)


@pytest.mark.parametrize(('held', 'end'), [(True, 3.0 - 0.5 * 20.0 * 0.9), (False, 3.0 - 10.0)])
def test_a_signal_is_held_or_runs_on_between_samples(held, end):
    """x' = -t / 20 for 20 s: -10, or with the input held for 2 s on the way -9."""
    scenario = vessel(
        inputs=lambda t: (t / 20.0,), parameters=constant(0.0, 0.0), sample_period=2.0,
        duration=22.0, held=held,
    )  # fmt: skip
    last = play(scenario)[-1]
    assert last.t == 20.0 and last.u == (1.0,)
    assert last.x[0] == pytest.approx(end, abs=1e-9)


def test_a_controller_cannot_run_on_between_samples():
    with pytest.raises(ValueError, match='only a signal can run on'):
        vessel(held=False)


def test_a_disturbance_is_measured_only():
    clean, disturbed = (
        play(vessel(inputs=constant(0.7), disturbance=disturbance))
        for disturbance in (None, lambda t: (0.1 * math.sin(t),))
    )
    for a, b in zip(clean, disturbed, strict=True):
        assert a.x == b.x
        assert b.y[0] - a.y[0] == pytest.approx(0.1 * math.sin(a.t), abs=1e-12)


def test_random_inputs_follow_the_seed_whatever_the_noise():
    scenario = vessel(inputs=WhiteGaussian(0.7, 0.1))
    quiet, loud, other = (
        [i.u for i in play(scenario, seed=seed, snr_db=snr_db)]
        for seed, snr_db in ((1, math.inf), (1, 20.0), (2, math.inf))
    )
    assert quiet == loud and not set(quiet) & set(other)


def test_measured_power_is_that_of_the_same_closed_loop():
    noisy = play(vessel(), snr_db=20.0, noise_reference='measured')
    error = np.array([i.y[0] - i.x[0] for i in noisy])
    rms = math.sqrt(np.mean([i.y[0] ** 2 for i in play(vessel())]))
    # 200 draws: 5 standard errors of a deviation are a quarter.
    assert error.std() == pytest.approx(0.1 * rms, rel=0.25)


def test_a_late_sensor_reads_the_past_and_an_early_one_the_future():
    """Between samples as well, and while the valves change on their time."""
    fine = [i.y for i in play_tanks(period=0.5, count=2 * 1400)]
    for delay in (2.5, -2.5, 3.0, -3.0):
        late = play_tanks({'h1': Sensor(delay=delay)}, count=1300)
        assert [i.t for i in late] == [float(k) for k in range(1300)]
        for k in range(3, 1300):
            expected = fine[round(2 * (k - delay))][0]
            assert late[k].y == pytest.approx((expected, fine[2 * k][1]), abs=2e-5)
    assert {i.y[0] for i in play_tanks({'h1': Sensor(delay=9.0)}, count=9)} == {0.0}


def play_tanks(sensors=MappingProxyType({}), period=1.0, count=100, actuators=None, **options):
    options = {'snr_db': math.inf} | options
    simulation = Simulation(THREE_TANK, period=period, **options)
    simulation.sensors, simulation.actuators = sensors, actuators or {}
    return [simulation.sample() for _ in range(count)]


def test_an_offset_in_time_changes_stamps_and_no_plant():
    clean = play_tanks(seed=2, snr_db=40.0)
    for sensor in (Sensor(delay=4.0), Sensor(delay=-4.0)):
        faulty = play_tanks({'h1': sensor}, seed=2, snr_db=40.0)
        assert [(i.t, i.x, i.u, i.p, i.y[1]) for i in faulty] == [
            (i.t, i.x, i.u, i.p, i.y[1]) for i in clean
        ]


def test_an_offset_in_time_comes_and_goes_while_it_runs():
    simulation = Simulation(THREE_TANK, snr_db=math.inf)
    clean = [i.y[0] for i in play_tanks(count=200)]
    found = []
    for k in range(150):
        delay = {0: 0.0, 1: 20.0, 2: 0.0, 3: -20.0, 4: 0.0}[k // 30]
        simulation.sensors = {'h1': Sensor(delay=delay)}
        found.append(simulation.sample())
    assert [i.t for i in found] == [float(k) for k in range(150)]
    y = [i.y[0] for i in found]
    assert y[:30] == clean[:30] and y[60:90] == clean[60:90] and y[120:] == clean[120:150]
    # A delay line shows the oldest value known until it is full.
    assert y[30:50] == pytest.approx([clean[29]] * 20) and y[50:60] == pytest.approx(clean[30:40])
    assert y[90:120] == pytest.approx(clean[110:140], abs=1e-5)


def test_an_outlier_counts_in_the_deviation_of_the_noise():
    sensor = Sensor(outlier_period=10.0, outlier_size=(7.0, 7.0))
    clean, spiked = (play_tanks(s, seed=2, snr_db=40.0) for s in ({}, {'h2': sensor}))
    off = np.array([np.subtract(b.y, a.y) for a, b in zip(clean, spiked, strict=True)])
    assert not off[:, 0].any() and np.flatnonzero(off[:, 1]).tolist() == list(range(10, 100, 10))
    assert np.abs(off[10::10, 1]) == pytest.approx(0.07)
    without = play_tanks({'h2': sensor})
    assert abs(without[10].y[1] - play_tanks()[10].y[1]) == pytest.approx(7.0)


def test_sensors_that_are_perfect_leave_every_bit():
    clean = play_tanks(seed=2, snr_db=40.0)
    assert play_tanks({'h1': Sensor()}, seed=2, snr_db=40.0, actuators={'Q1': Actuator()}) == clean


def test_a_dead_time_lets_the_plant_wait_for_its_input():
    """x' = -u: the input t / 20, held for 2 s, acts 5 s later."""
    scenario = vessel(
        inputs=lambda t: (t / 20.0,), parameters=constant(0.0, 0.0), sample_period=2.0,
        duration=22.0,
    )  # fmt: skip
    simulation = Simulation(scenario)
    simulation.actuators = {'u': Actuator(delay=5.0)}
    last = [simulation.sample() for _ in range(11)][-1]
    # Until 5 s the first input, 0; then one more of 0, 0.1, ... each for 2 s, the last for 1 s.
    acted = 2.0 * sum(0.1 * k for k in range(7)) + 0.7
    assert last.t == 20.0 and last.u == (1.0,) and last.x[0] == pytest.approx(3.0 - acted)


def test_an_actuator_that_saturates_gives_the_plant_less_than_is_told():
    simulation = Simulation(vessel(inputs=constant(0.7), parameters=constant(0.7, 0.0)))
    simulation.actuators = {'u': Actuator(range=(0.0, 0.5))}
    end = [simulation.sample() for _ in range(11)][-1]
    assert end.u == (0.7,) and end.x[0] == pytest.approx(3.0 + (0.7 - 0.5) * 1.0)


def test_a_controller_gets_the_readings_at_their_time():
    clean, late, coarse = (play_loop(s) for s in (None, Sensor(delay=0.5), Sensor(resolution=1.0)))
    assert [i.u for i in late] == [i.u for i in clean] != [i.u for i in coarse]
    y, before = [i.y[0] for i in late[6:]], [i.y[0] for i in clean[1:-5]]
    assert y == pytest.approx(before, abs=1e-9)


def play_loop(sensor):
    simulation = Simulation(vessel())
    simulation.sensors = {'y': sensor} if sensor else {}
    return [simulation.sample() for _ in range(50)]


def declared(output=MappingProxyType({}), input=MappingProxyType({})):
    """Return the vessel whose output and input have further properties."""
    return replace(
        VESSEL,
        inputs=[replace(v, **input) for v in VESSEL.inputs],
        outputs=[replace(v, **output) for v in VESSEL.outputs],
    )


def test_sensors_and_actuators_are_at_first_as_the_model_declares():
    model = declared({'resolution': 0.5, 'delay': 0.3}, {'range': (0.0, 0.5)})
    scenario = vessel(inputs=constant(0.7), parameters=constant(0.7, 0.0))
    own = play(scenario, model=model)
    bare = Simulation(scenario)
    bare.sensors, bare.actuators = (
        {'y': Sensor(delay=0.3, resolution=0.5)}, {'u': Actuator(range=(0.0, 0.5))}
    )  # fmt: skip
    assert own == [bare.sample() for _ in own] != play(scenario)
    ideal = Simulation(scenario, model=model)
    ideal.sensors = ideal.actuators = {}
    assert [ideal.sample() for _ in own] == play(scenario)


def test_readings_wrap_as_declared_until_the_sensor_is_another():
    simulation = Simulation(vessel(), model=declared({'period': 2.0}))
    assert simulation.sample().y == (-1.0,)
    simulation.sensors = {}
    assert simulation.sample().y[0] > 2.0


def test_a_delay_among_the_parameters_is_the_one_that_there_is(monkeypatch):
    model = declared({'delay': (-1.0, 1.0)}, {'delay': (0.0, 2.0)})
    assert names(model.parameters) == ('d', 'g', 'u.delay', 'y.delay')
    monkeypatch.setattr(plants, 'LATE_VESSEL', model, raising=False)
    simulation = Simulation(vessel(model='plants:LATE_VESSEL', inputs=constant(0.7)))
    assert simulation.sample().p == (0.7, 0.0, 0.0, 0.0)
    simulation.actuators = {'u': Actuator(delay=0.5)}
    simulation.sensors = {'y': Sensor(delay=-0.25)}
    simulation.faults['d'] = 0.2
    assert simulation.sample().p == (0.2, 0.0, 0.5, -0.25)
