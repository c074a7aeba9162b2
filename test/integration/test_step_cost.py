"""Tests of obs_ros.integration.step_cost."""

from dataclasses import replace
from typing import Any

import numpy as np
from stiff_plants import MOTOR, ROBERTSON

from obs_ros import Model, Variable
from obs_ros.integration.step_cost import cost_of_step, of_dynamics, operations
from obs_ros.models.three_tank import THREE_TANK


def test_implicit_steps_cost_more_the_more_states_depend_on_each_other() -> None:
    ratios = [
        cost_of_step(model, 'rosenbrock') / cost_of_step(model, 'rk4')
        for model in (THREE_TANK, MOTOR, ROBERTSON)
    ]
    # Measured on compiled kernels: 1.2, 1.7 and 2.3.
    np.testing.assert_allclose(ratios, [1.2, 1.7, 2.3], rtol=0.2)


def test_euler_costs_one_evaluation() -> None:
    assert cost_of_step(MOTOR, 'euler') < 0.3 * cost_of_step(MOTOR, 'rk4')


def test_operations_are_counted_wherever_they_stand() -> None:
    assert operations(lambda a, b: (a + b * a, -b)) == 3
    assert operations(lambda a: np.sqrt(a) + 1.0) == 9

    def with_loop(t: Any, x: Any, u: Any, p: Any) -> Any:
        return [sum(p[0] * x[i] for _ in range(4)) for i in range(2)]

    assert of_dynamics(with_loop, (2, 0, 1)) >= 2


def test_what_cannot_be_recorded_has_a_cost_all_the_same() -> None:
    def odd(t: Any, x: Any, u: Any, p: Any) -> Any:
        return (float(f'{float(np.ravel(x[0])[0])}') * p[0] + 0.0 * x[0],)

    assert of_dynamics(odd, (1, 0, 1)) == 30.0
    states = (Variable('x', lower=0.0, upper=1.0),)
    gain = Variable('g', lower=0.0, upper=1.0)
    plain = Model('plain', states, states, lambda t, x, u, p: (p[0] * x[0],),
                  lambda t, x, u, p: (x[0],), parameters=(gain,))  # fmt: skip
    assert cost_of_step(replace(plain), 'rosenbrock') > 0.0
