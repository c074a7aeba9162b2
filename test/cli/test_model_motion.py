"""Time constants of models, against poles known by hand."""

import math

import numpy as np
import pytest

from obs_ros import Model, Variable
from obs_ros.cli.model_motion import motion_of, rounded


def linear(*rates, coupling=0.0):
    """States that decay by themselves, each at its rate (1/s)."""
    n = len(rates)
    return Model(
        name='linear',
        states=tuple(Variable(f'x{i}', lower=-1.0, upper=1.0) for i in range(n)),
        outputs=(Variable('y'),),
        parameters=(Variable('a', lower=0.5, upper=2.0),),
        dynamics=lambda t, x, u, p: tuple(
            -p[0] * rate * each - coupling * x[0] ** 3 for rate, each in zip(rates, x, strict=True)
        ),
        output=lambda t, x, u, p: (x[0],),
    )


def at(model, *values):
    points = np.array(values, dtype=float).reshape(-1, 1)
    n = len(model.states)
    return motion_of(model, points[:n], points[n:])


def test_the_fastest_and_the_slowest_decay_and_their_ratio():
    motion = at(linear(1e3, 0.05, 10.0), 0.0, 0.0, 0.0, 1.0)
    assert motion.fastest[0] == pytest.approx(1e-3)
    assert motion.slowest[0] == pytest.approx(20.0)
    assert motion.wanted == 60.0 and motion.longest == pytest.approx(60.0)
    assert str(motion) == '0.001 s to 20 s (stiffness 20000)'


def test_an_oscillation_asks_for_two_periods():
    pendulum = Model(
        name='pendulum',
        states=(Variable('angle', lower=-1, upper=1), Variable('rate', lower=-1, upper=1)),
        outputs=(Variable('angle'),),
        dynamics=lambda t, x, u, p: (x[1], -9.81 * np.sin(x[0]) - 0.1 * x[1]),
        output=lambda t, x, u, p: (x[0],),
    )
    motion = at(pendulum, 0.0, 0.0)
    assert motion.duration[0] == pytest.approx(4.0 * math.pi / math.sqrt(9.81 - 0.05**2), rel=1e-6)
    assert motion.wanted == 4.0
    assert str(motion) == '0.32 s'


def test_integrators_and_modes_slower_than_a_rollout_stand_still():
    assert np.isnan(at(linear(0.0, 0.0), 0.0, 0.0, 1.0).wanted)
    assert str(at(linear(0.0, 0.0), 0.0, 0.0, 1.0)).startswith('none: all states only add up')
    slow = linear(1.0, 1e-6)
    points = np.zeros((2, 1)), np.ones((1, 1))
    assert motion_of(slow, *points).slowest[0] == pytest.approx(1e6)
    assert motion_of(slow, *points, 10.0).slowest[0] == pytest.approx(1.0)


def test_points_that_are_not_finite_are_left_out():
    x, p = np.array([[0.0, np.nan], [0.0, 0.0]]), np.array([[1.0, 1.0]])
    motion = motion_of(linear(1.0, 2.0, coupling=1.0), x, p)
    assert motion.fastest[0] == pytest.approx(0.5) and np.isnan(motion.fastest[1])
    assert motion.wanted == 3.0


@pytest.mark.parametrize(
    ('seconds', 'down', 'expected'),
    [(298.0, False, 300.0), (0.0123, False, 0.015), (0.0123, True, 0.01), (7.9e-5, True, 6e-5),
     (12.5, True, 10.0), (1.0, True, 1.0)],
)  # fmt: skip
def test_proposals_are_round(seconds, down, expected):
    assert rounded(seconds, down=down) == expected
