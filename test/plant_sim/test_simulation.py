import math

import numpy as np
import pytest

from plant_sim.scenario import Scenario
from plant_sim.scenarios import load_scenario
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
