import math

import numpy as np
import pytest

from plant_sim.signals import Noise, Schedule, constant, noise_deviation, ramp


def test_a_change_counts_from_its_time_on():
    schedule = Schedule((0.0, 10.0, 20.0), ((1.0,), (2.0,), (3.0,)))
    assert [schedule(t) for t in (0.0, 9.999, 10.0, 20.0, 1e6)] == [
        (1.0,), (1.0,), (2.0,), (3.0,), (3.0,)
    ]  # fmt: skip
    assert [schedule.next_change(t) for t in (0.0, 10.0, 15.0, 20.0)] == [
        10.0, 20.0, 20.0, math.inf
    ]  # fmt: skip


@pytest.mark.parametrize(
    ('times', 'values'),
    [((1.0,), ((1.0,),)), ((0.0, 0.0), ((1.0,), (2.0,))), ((0.0, 1.0), ((1.0,), (1.0, 2.0)))],
)
def test_schedules_that_make_no_sense_are_refused(times, values):
    with pytest.raises(ValueError, match='schedule'):
        Schedule(times, values)


def test_a_constant_never_changes():
    assert constant(30.0, 31.0)(1e9) == (30.0, 31.0)
    assert constant(1.0).next_change(0.0) == math.inf


def test_noise_has_the_deviation_of_its_snr():
    assert noise_deviation(40.0) == pytest.approx(0.01)
    assert noise_deviation(20.0, power=25.0) == pytest.approx(0.5)
    noise = Noise(seed=3, outputs=2)
    draws = np.array([noise.draw(0.1) for _ in range(20000)])
    # 5 standard errors of a deviation and of a correlation.
    assert draws.std(axis=0) == pytest.approx(0.1, rel=5 / math.sqrt(2 * 20000))
    assert abs(np.corrcoef(draws.T)[0, 1]) < 5 / math.sqrt(20000)


def test_the_seed_makes_the_noise():
    one, same, other = (Noise(seed, 2).draw(1.0).tolist() for seed in (1, 1, 2))
    assert one == same != other


def test_a_ramp_runs_straight_between_its_times():
    reference = ramp((0.0, 17.0, 25.0), (2.6, 1.3, 1.7))
    assert [reference(t)[0] for t in (0.0, 8.5, 17.0, 21.0, 40.0)] == pytest.approx(
        [2.6, 1.95, 1.3, 1.5, 1.7]
    )


def test_correlated_noise_keeps_its_deviation_and_forgets_at_its_pace():
    noise = Noise(seed=4, outputs=2, correlation=0.8)
    draws = np.array([noise.draw(0.1) for _ in range(20000)])
    # A ninth of the draws are independent: 5 standard errors as above.
    assert draws.std(axis=0) == pytest.approx(0.1, rel=5 / math.sqrt(2 * 20000 / 9))
    lag = (draws[1:] * draws[:-1]).mean(axis=0) / draws.var(axis=0)
    assert lag == pytest.approx(0.8, abs=5 * math.sqrt((1 - 0.8**2) / 20000))
