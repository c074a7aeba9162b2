"""Actuators with dead times and limits."""

import math

import pytest

from obs_ros import Variable
from plant_sim.actuators import IDEAL, Actuator, Inputs


def stairs(actuators: list[Actuator], count: int = 10) -> Inputs:
    """Inputs k and 10 k told at k s."""
    inputs = Inputs(2, None)
    for k in range(count):
        inputs.tell(float(k), (float(k), 10.0 * k), actuators)
    return inputs


def test_ideal_inputs_act_as_they_are_told() -> None:
    actuators = [IDEAL, IDEAL]
    inputs = Inputs(2, None)
    assert inputs.acting(0.0, actuators) == (0.0, 0.0)
    inputs = stairs(actuators)
    assert inputs.acting(9.0, actuators) == inputs.signal(9.0, actuators)(9.5) == (9.0, 90.0)
    assert inputs.next_change(9.0, actuators) == math.inf


def test_each_input_acts_after_its_own_dead_time() -> None:
    actuators = [Actuator(delay=2.5), Actuator(delay=1.0)]
    inputs = stairs(actuators)
    assert inputs.acting(9.0, actuators) == (6.0, 80.0)
    assert inputs.acting(9.5, actuators) == (7.0, 80.0)
    assert inputs.next_change(9.0, actuators) == 9.5
    assert inputs.next_change(9.5, actuators) == 10.0
    assert inputs.next_change(11.5, actuators) == math.inf


def test_what_is_told_first_acted_before() -> None:
    actuators = [Actuator(delay=5.0), IDEAL]
    inputs = stairs(actuators, 3)
    assert inputs.acting(2.0, actuators) == (0.0, 20.0)
    late = Inputs(1, None)
    late.tell(0.0, (7.0,), [Actuator(delay=5.0)])
    assert late.acting(0.0, [Actuator(delay=5.0)]) == (7.0,)


def test_a_dead_time_that_is_lengthened_holds_the_oldest_input_known() -> None:
    inputs = stairs([IDEAL, IDEAL])
    longer = [Actuator(delay=3.0), IDEAL]
    assert inputs.acting(9.0, longer) == (9.0, 90.0)
    for k in range(10, 14):
        inputs.tell(float(k), (float(k), 10.0 * k), longer)
    assert inputs.acting(13.0, longer) == (10.0, 130.0)


def test_an_input_that_acts_keeps_to_its_limits() -> None:
    actuators = [Actuator(range=(2.0, 4.0)), Actuator(range=(-5.0, 25.0), delay=1.0)]
    inputs = Inputs(2, None)
    for k, acting in ((1, (2.0, 10.0)), (3, (3.0, 10.0)), (9, (4.0, 25.0))):
        inputs.tell(float(k), (float(k), 10.0 * k), actuators)
        assert inputs.acting(float(k), actuators) == acting


def test_a_signal_that_runs_on_acts_late_and_clipped() -> None:
    inputs = Inputs(1, lambda t: (t,))
    actuators = [Actuator(delay=2.0, range=(0.5, 4.0))]
    inputs.tell(0.0, (0.0,), actuators)
    signal = inputs.signal(0.0, actuators)
    assert [signal(t)[0] for t in (0.0, 3.0, 9.0)] == pytest.approx([0.5, 1.0, 4.0])
    assert inputs.acting(3.0, actuators) == (1.0,)
    assert inputs.next_change(0.0, actuators) == math.inf
    assert inputs.signal(0.0, [IDEAL])(3.25) == (3.25,)


def test_an_actuator_is_as_its_input_declares() -> None:
    assert Actuator.of(Variable('u')) == IDEAL
    assert Actuator.of(Variable('u', delay=2, range=(0, 5))) == Actuator(2.0, (0.0, 5.0))
    assert Actuator.of(Variable('u', delay=(0.0, 2.0))) == IDEAL
    assert Actuator.of(Variable('u', delay=-1.0)) == IDEAL  # none acts before it is told
