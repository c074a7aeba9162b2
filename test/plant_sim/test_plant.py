import math

import numpy as np
import pytest
from arx import ARX, X0, A, B, course, pushes
from sampled_stiff_plants import MOTOR, by_radau, chain, van_der_pol

from obs_ros.core.model import Model, Variable
from obs_ros.models import load_model
from plant_sim.plant import Plant
from plant_sim.signals import constant


def test_a_linear_plant_follows_its_closed_form():
    decay = Model(
        name='decay',
        states=(Variable('x'),),
        outputs=(Variable('y'),),
        inputs=(Variable('u'),),
        parameters=(Variable('a'),),
        dynamics=lambda t, x, u, p: (u[0] - p[0] * x[0],),
        output=lambda t, x, u, p: (2.0 * x[0],),
    )
    plant = Plant(decay, [3.0])
    plant.advance(5.0, constant(1.0), [0.5])
    assert plant.x[0] == pytest.approx(2.0 + math.exp(-2.5), abs=1e-6)
    assert plant.output([1.0], [0.5])[0] == 2.0 * plant.x[0]


def test_an_input_that_runs_on_is_followed_between_the_ends_of_a_step():
    """x' = -x + cos 3 t from x(0) = 0.1, without transient: x = (cos 3 t + 3 sin 3 t) / 10."""
    lag = Model(
        name='lag',
        states=(Variable('x'),),
        outputs=(Variable('y'),),
        inputs=(Variable('u'),),
        dynamics=lambda t, x, u, p: (u[0] - x[0],),
        output=lambda t, x, u, p: (x[0],),
    )
    plant = Plant(lag, [0.1])
    plant.advance(7.0, lambda t: (math.cos(3.0 * t),), ())
    assert plant.x[0] == pytest.approx(0.1 * math.cos(21.0) + 0.3 * math.sin(21.0), abs=1e-6)


def test_a_coarse_sampling_of_the_tanks_loses_nothing():
    """Window 1 begins with a crossing of levels, where fixed steps of 1 s err by 3e-3 cm."""
    tanks, u, p = load_model('three_tank'), constant(30.0, 30.0), (1.0, 1.0, 1.0)
    coarse, fine = (Plant(tanks, (0.0, 0.0, 60.0)) for _ in range(2))
    coarse.advance(100.0, u, p)
    for t in np.arange(0.01, 100.005, 0.01):
        fine.advance(float(t), u, p)
    assert coarse.x == pytest.approx(fine.x, abs=1e-5)


def test_diverging_plants_do_not_hang():
    wild = Model(
        name='wild',
        states=(Variable('x', nominal=1.0),),
        outputs=(Variable('y'),),
        dynamics=lambda t, x, u, p: (np.exp(x[0]),),
        output=lambda t, x, u, p: (x[0],),
    )
    plant = Plant(wild, [1.0])
    with np.errstate(all='ignore'):
        plant.advance(1.0, constant(), ())
    assert not math.isfinite(plant.x[0]) or plant.x[0] > 1e3


def test_wrong_use_is_refused():
    tanks = load_model('three_tank')
    with pytest.raises(ValueError, match='3 states, not 2'):
        Plant(tanks, [1.0, 2.0])
    plant = Plant(tanks, [1.0, 2.0, 3.0])
    plant.advance(1.0, constant(30.0, 30.0), (1.0, 1.0, 1.0))
    with pytest.raises(ValueError, match='cannot go back'):
        plant.advance(0.5, constant(30.0, 30.0), (1.0, 1.0, 1.0))


def test_a_discrete_model_goes_by_the_inputs_at_its_nodes():
    u = pushes(20)
    states, _ = course(u)
    plant, k = Plant(ARX, X0), 0
    for to in np.arange(1, 60) / 30.0:  # three calls a period
        acting = u[k] if plant.following is None else math.nan
        plant.advance(to, constant(acting), (*A, B))
        k = math.floor(10.0 * to + 1e-6)
        assert plant.x == pytest.approx(states[k], rel=1e-12)
    other = Plant(ARX, X0)
    other.advance(1.9, lambda t: (u[math.floor(10.0 * t + 1e-6)],), (*A, B))
    assert other.x == pytest.approx(states[19], rel=1e-12)


@pytest.mark.parametrize(
    ('model', 'x', 'u', 'p', 'period', 'samples'),
    [
        (MOTOR, (0.0, 0.0), (12.0, -20.0, 5.0), (0.05,), 0.01, 12),
        (van_der_pol(100.0), (2.0, 0.0), (), (100.0,), 4.0, 12),
        (chain(20), (20.0,) * 20, (60.0, 80.0), (20.0,), 10.0, 8),
    ],
)
def test_stiff_plants_are_as_scipy_s_radau_has_them(model, x, u, p, period, samples):
    plant, exact = Plant(model, x), np.array(x)
    width = np.array([v.upper - v.lower for v in model.states])
    for k in range(samples):
        held = (u[k % len(u)],) if u else ()
        plant.advance((k + 1) * period, constant(*held), p)
        exact = by_radau(model, k * period, (k + 1) * period, exact, np.array(held), np.array(p))
        assert np.abs(np.array(plant.x) - exact).max() <= 1e-7 * width.min()
    assert plant.stiff


def test_a_plant_that_is_not_stiff_stays_with_rk4():
    tanks = load_model('three_tank')
    plant = Plant(tanks, (0.0, 0.0, 60.0))
    plant.advance(100.0, constant(30.0, 30.0), (1.0, 1.0, 1.0))
    assert not plant.stiff


def test_small_states_are_as_exact_as_large_ones():
    """x' = -x in units of 1e-9 and of 1e9 of the same."""
    results = []
    for unit in (1e-9, 1.0, 1e9):
        decay = Model(
            name='decay',
            states=(Variable('x', lower=0.0, upper=2.0 * unit),),
            outputs=(Variable('y'),),
            dynamics=lambda t, x, u, p: (-x[0],),
            output=lambda t, x, u, p: (x[0],),
        )
        plant = Plant(decay, [unit])
        plant.advance(3.0, constant(), ())
        results.append(plant.x[0] / unit)
    assert results == pytest.approx([math.exp(-3.0)] * 3, abs=2e-7)


def test_floats_that_overflow_on_the_way_do_no_harm():
    """One RK4 step of 1 s leads from 2 beyond 1e300, where ** of a float raises."""
    steep = Model(
        name='steep',
        states=(Variable('x', lower=0.0, upper=3.0),),
        outputs=(Variable('y'),),
        dynamics=lambda t, x, u, p: (-1e4 * x[0] ** 9,),
        output=lambda t, x, u, p: (x[0],),
    )
    plant = Plant(steep, [2.0])
    plant.advance(1.0, constant(), ())
    assert plant.x[0] == pytest.approx((2.0**-8 + 8e4) ** -0.125, rel=1e-6)
