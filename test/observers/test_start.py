"""Values that an observer starts from."""

import numpy as np

from obs_ros.inference.parameterisation import Unknowns
from obs_ros.models.three_tank import THREE_TANK
from obs_ros.observers.start import initial_values


def test_given_values_count_before_nominal_ones_and_the_middle() -> None:
    unknowns = Unknowns.of(THREE_TANK, fixed={'p3': 0.25}, parameters=('p1', 'p2'))
    values = initial_values(unknowns, {'h1': 7.0})
    assert values[0] == 7.0 and values[5] == 0.25
    for i in (1, 2, 3, 4):
        v = THREE_TANK.variables[i]
        middle = 0.5 * (v.lower + v.upper)
        assert values[i] == (middle if v.nominal is None else v.nominal)
    assert np.isfinite(values).all()
