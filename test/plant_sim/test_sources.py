import math

import numpy as np
import pytest

from plant_sim.signals import Noise, constant, ramp
from plant_sim.sources import PIController, WhiteGaussian, start


def test_a_pi_controller_by_hand():
    control = start(PIController(5.0, 2.0, constant(2.0)), period=0.1, seed=0)
    assert control(0.0, (3.0,)) == pytest.approx((5.0 * 1.0 + 2.0 * 0.1 * 1.0,))
    assert control(0.1, (2.5,)) == pytest.approx((5.0 * 0.5 + 2.0 * 0.1 * 1.5,))
    assert control(0.2, (0.5,)) == pytest.approx((5.0 * -1.5 + 2.0 * 0.1 * 0.0,))


def test_a_controller_follows_its_reference_and_every_run_starts_anew():
    controller = PIController(1.0, 1.0, ramp((0.0, 10.0), (2.0, 3.0)))
    for _ in range(2):
        control = start(controller, period=1.0, seed=0)
        assert control(5.0, (2.5,)) == (0.0,)
        assert control(20.0, (4.0,)) == (2.0,)


def test_a_controller_of_one_output_refuses_two():
    with pytest.raises(ValueError, match='answers one output, not 2'):
        start(PIController(1.0, 1.0, constant(0.0)), 1.0, 0)(0.0, (1.0, 2.0))


def test_white_noise_has_its_mean_and_deviation():
    draw = start(WhiteGaussian(1.25, 0.5), period=0.01, seed=3)
    u = np.array([draw(0.0, ())[0] for _ in range(20000)])
    # 5 standard errors of a mean, of a deviation and of a correlation.
    assert u.mean() == pytest.approx(1.25, abs=5 * 0.5 / math.sqrt(20000))
    assert u.std() == pytest.approx(0.5, rel=5 / math.sqrt(2 * 20000))
    assert abs(np.corrcoef(u[1:], u[:-1])[0, 1]) < 5 / math.sqrt(20000)
    noise = Noise(seed=3, outputs=1)
    measured = np.array([noise.draw(1.0)[0] for _ in range(20000)])
    assert abs(np.corrcoef(u, measured)[0, 1]) < 5 / math.sqrt(20000)


def test_the_seed_makes_the_input():
    one, same, other = (start(WhiteGaussian(0.0, 1.0), 0.01, s)(0.0, ()) for s in (1, 1, 2))
    assert one == same != other


def test_a_signal_does_not_look_at_the_outputs():
    drive = start(ramp((0.0, 2.0), (0.0, 4.0)), period=1.0, seed=0)
    assert [drive(t, (9.0,)) for t in (0.0, 1.0, 2.0, 3.0)] == [(0.0,), (2.0,), (4.0,), (4.0,)]
