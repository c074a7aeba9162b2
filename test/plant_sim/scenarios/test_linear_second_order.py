import math

import numpy as np
import pytest

from plant_sim.scenarios.linear_second_order import TWO_COSINES, two_cosines
from plant_sim.simulation import Simulation


def test_the_input_is_that_of_equation_16():
    assert two_cosines(0.0) == (pytest.approx(0.999 + 0.42 + 0.32),)
    assert two_cosines(2.0) == (pytest.approx(0.999 + 0.42 * math.cos(3.5) + 0.32 * math.cos(9.0)),)


def test_it_is_sampled_every_hundredth_of_a_second_without_noise():
    run = Simulation(TWO_COSINES)
    instants = [run.sample() for _ in range(101)]
    assert instants[-1].t == pytest.approx(1.0)
    outputs = [run.model.output(i.t, i.x, i.u, i.p) for i in instants]
    np.testing.assert_array_equal([i.y for i in instants], outputs)
    np.testing.assert_array_equal([i.u for i in instants], [two_cosines(i.t) for i in instants])
