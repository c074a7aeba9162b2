"""The past of a run, integrated again."""

import pytest

from obs_ros.core.model import Model, Variable
from plant_sim.past import Past, Stretch
from plant_sim.signals import constant

RAMP = Model(
    name='ramp',
    states=(Variable('x'),),
    outputs=(Variable('y'),),
    inputs=(Variable('u'),),
    parameters=(Variable('a'),),
    dynamics=lambda t, x, u, p: (u[0] * p[0],),
    output=lambda t, x, u, p: (x[0] + 100.0 * u[0],),
)


@pytest.fixture
def past() -> Past:
    """Rates of 2, then of 6, then of -1, from 1, 2 and 4 s on."""
    found = Past(RAMP)
    found.add(Stretch(1.0, (0.0,), constant(1.0), (2.0,)))
    found.add(Stretch(2.0, (2.0,), constant(2.0), (3.0,)))
    found.add(Stretch(4.0, (14.0,), constant(-1.0), (1.0,)))
    return found


@pytest.mark.parametrize(
    ('t', 'y'),
    [(1.0, 100.0), (1.5, 101.0), (2.0, 202.0), (3.5, 211.0), (4.0, -86.0), (5.0, -87.0)],
)
def test_outputs_of_any_time_are_found_again(past: Past, t: float, y: float) -> None:
    assert past.outputs(t) == pytest.approx((y,), abs=1e-9)


def test_before_it_begins_stands_its_first_state(past: Past) -> None:
    assert past.outputs(-3.0) == (100.0,)
    past.forget(3.0)
    assert past.outputs(1.5) == (202.0,)
    assert past.outputs(3.5) == pytest.approx((211.0,))


def test_nothing_is_known_of_no_past(past: Past) -> None:
    past.clear()
    assert past.outputs(2.0) is None


def test_rounded_times_belong_to_the_stretch_that_begins_there(past: Past) -> None:
    assert past.outputs(2.0 - 1e-12) == (202.0,)
