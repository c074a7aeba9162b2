"""Tests of obs_ros.core.step_cost: ratios beside those that were measured, and their growth."""

from typing import Any

import numpy as np
import pytest
from plants import OSCILLATOR
from scipy.special import expit

from obs_ros import Model, Variable
from obs_ros.core.step_cost import step_cost


def plant(n: int, f: Any, inputs: int = 0, parameters: int = 0) -> Model:
    groups = [
        [Variable(f'{name}{i}', nominal=1.0) for i in range(count)]
        for name, count in (('x', n), ('u', inputs), ('p', parameters))
    ]
    return Model('plant', groups[0], [Variable('y')], f, lambda t, x, u, p: (x[0],), *groups[1:])


def ratio(model: Model) -> float:
    return step_cost(model, 'rosenbrock') / step_cost(model, 'rk4')


def motor(t: Any, x: Any, u: Any, p: Any) -> Any:
    return (u[0] - p[0] * x[0] - p[2] * x[1]) / p[1], (p[2] * x[0] - p[4] * x[1]) / p[3]


def robertson(t: Any, x: Any, u: Any, p: Any) -> Any:
    slow, back, apart = p[0] * x[0], p[1] * x[1] * x[2], p[2] * x[1] * x[1]
    return back - slow, slow - back - apart, apart


def coupled(n: int) -> Any:
    def f(t: Any, x: Any, u: Any, p: Any) -> Any:
        total = sum((1.0 + i) * each for i, each in enumerate(x))
        return [-p[0] * x[i] + 1e-3 * p[1] * total * x[(i + 1) % n] for i in range(n)]

    return f


def chain(n: int) -> Any:
    def f(t: Any, x: Any, u: Any, p: Any) -> Any:
        ends = (x[0], *x, x[-1])
        return [p[0] * (ends[i] - 2.0 * ends[i + 1] + ends[i + 2]) for i in range(n)]

    return f


@pytest.mark.parametrize(
    ('model', 'measured'),  # on a Zen 5, 16 lanes
    [
        (plant(2, motor, 1, 5), 1.62), (plant(3, robertson, 0, 3), 2.48),
        (plant(4, coupled(4), 0, 2), 2.81), (plant(8, coupled(8), 0, 2), 4.93),
        (plant(12, coupled(12), 0, 2), 7.71),
    ],
)  # fmt: skip
def test_ratios_are_those_measured(model: Model, measured: float) -> None:
    assert ratio(model) == pytest.approx(measured, rel=0.15)


def test_a_chain_costs_in_proportion_to_its_nodes() -> None:
    costs = [step_cost(plant(n, chain(n), 0, 1), 'rosenbrock') for n in (10, 20, 40)]
    assert costs[2] - costs[1] == pytest.approx(2.0 * (costs[1] - costs[0]), rel=0.01)


def test_functions_cost_more_than_sums_and_whole_powers_do_not() -> None:
    linear, sine, square, root = (
        step_cost(plant(1, f), 'euler')
        for f in (
            lambda t, x, u, p: (x[0] + x[0],),
            lambda t, x, u, p: (np.sin(x[0]),),
            lambda t, x, u, p: (x[0] ** 2,),
            lambda t, x, u, p: (x[0] ** 0.5,),
        )
    )
    assert sine > 30.0 * linear and root == sine and square < 2.0 * linear


def test_costs_are_known_for_every_method_and_for_functions_that_cannot_be_recorded() -> None:
    assert step_cost(OSCILLATOR, 'rk4') == 4.0 * step_cost(OSCILLATOR, 'euler')
    assert 1.0 < ratio(plant(2, lambda t, x, u, p: (-expit(x[0]), x[0]))) < 3.0
