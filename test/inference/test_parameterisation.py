"""Tests of obs_ros.inference.parameterisation."""

import math
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from plants import OSCILLATOR

from obs_ros.core.model import Model, Variable
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.models.three_tank import THREE_TANK


def test_by_default_all_initial_states_and_parameters_in_the_models_order() -> None:
    unknowns = Unknowns.of(THREE_TANK)
    assert unknowns.names == ('h1', 'h2', 'h3', 'p1', 'p2', 'p3')
    assert unknowns.dimension == 6
    np.testing.assert_array_equal(unknowns.scale.upper, [100, 100, 100, 1, 1, 1])


def test_a_choice_of_names_keeps_the_models_order_and_the_rest_is_given() -> None:
    unknowns = Unknowns.of(
        THREE_TANK, parameters=['p3', 'p1'], states=['h3'], fixed={'h1': 3.0, 'h2': 4.0}
    )
    assert unknowns.names == ('h3', 'p1', 'p3')
    x0, p = unknowns.values(np.array([[0.5, 0.25, 1.0], [0.0, 0.0, 0.0]]))
    np.testing.assert_array_equal(x0, [[3.0, 3.0], [4.0, 4.0], [50.0, 0.0]])
    np.testing.assert_array_equal(p, [[0.25, 0.0], [1.0, 1.0], [1.0, 0.0]])  # p2 is nominal


def test_what_is_fixed_is_not_estimated() -> None:
    assert Unknowns.of(THREE_TANK, fixed={'h1': 3.0, 'p2': 0.5}).names == ('h2', 'h3', 'p1', 'p3')


def test_one_name_and_a_generator_will_do() -> None:
    unknowns = Unknowns.of(
        THREE_TANK, parameters='p2', states=(name for name in ('h1', 'h2', 'h3'))
    )
    assert unknowns.names == ('h1', 'h2', 'h3', 'p2')


def test_bounds_replace_the_models() -> None:
    unknowns = Unknowns.of(THREE_TANK, bounds={'p1': (0.2, 0.6)})
    _, p = unknowns.values(np.full((1, 6), 0.5))
    assert p[:, 0].tolist() == [pytest.approx(0.4), 0.5, 0.5]


@pytest.mark.parametrize(
    ('settings_', 'message'),
    [
        ({'parameters': ['p4']}, "no parameter 'p4' to estimate: did you mean"),
        ({'states': ['h9']}, "no state 'h9' to estimate: did you mean"),
        ({'fixed': {'q1': 1.0}}, "'three_tank' has no state or parameter 'q1'"),
        ({'bounds': {'Q1': (0.0, 1.0)}}, "'three_tank' has no state or parameter 'Q1'"),
        ({'bounds': {'p1': (0.9, 0.1)}}, 'p1: lower bound 0.9 is not below upper bound 0.1'),
        ({'bounds': {'p1': (0.0, math.nan)}}, 'p1: lower bound 0.0 is not below upper bound nan'),
        ({'bounds': {'p1': 0.5}}, 'bounds of p1 must be (lower, upper), not 0.5'),
        ({'bounds': {'p1': (0, 1, 2)}}, 'bounds of p1 must be (lower, upper), not (0, 1, 2)'),
        ({'fixed': {'p1': math.nan}}, 'p1 is fixed at nan, which is not a finite number'),
        (
            {'parameters': ['p1'], 'fixed': {'p1': 0.5}},
            "parameter 'p1' cannot be both estimated and fixed",
        ),
        (
            {'states': ['h1', 'h3']},
            'h2 is not estimated and has no nominal value: give it a fixed value, in cm',
        ),
        (
            {'parameters': (), 'states': ()},
            "nothing to estimate: every unknown of 'three_tank' is fixed",
        ),
    ],
)
def test_what_is_wrong_is_named(settings_: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=re.escape(message)):
        Unknowns.of(THREE_TANK, **settings_)


unit = st.floats(0.0, 1.0)


@given(st.lists(unit, min_size=4, max_size=4), st.floats(-1e6, 1e6), st.floats(1e-3, 1e6))
def test_points_and_values_are_inverse(z: list[float], lower: float, width: float) -> None:
    unknowns = Unknowns.of(OSCILLATOR, bounds={'position': (lower, lower + width)})
    x0, p = unknowns.values(np.array([z]))
    names = [v.name for v in OSCILLATOR.variables]
    named = dict(zip(names, np.concatenate([x0, p])[:, 0], strict=True))
    rounding = 1e-15 * (1.0 + abs(lower) / width)
    np.testing.assert_allclose(unknowns.point(named), z, rtol=0.0, atol=8 * rounding)


LOG = replace(
    THREE_TANK,
    parameters=(Variable('p1', 'm', 0.5, 8.0, scale='log'), *THREE_TANK.parameters[1:]),
)


def test_on_a_log_scale_equal_steps_are_equal_ratios() -> None:
    unknowns = Unknowns.of(LOG)
    z = np.full((3, 6), 0.25)
    z[:, 3] = 0.0, 0.5, 1.0
    p = unknowns.values(z)[1]
    np.testing.assert_allclose(p, [[0.5, 2.0, 8.0], [0.25] * 3, [0.25] * 3], rtol=1e-15)
    np.testing.assert_allclose(unknowns.scale.values(z[:, 3], 3), p[0], rtol=0.0)
    middle = dict(zip(unknowns.names, [1.0, 1.0, 1.0, 2.0, 0.25, 1.0], strict=True))
    assert unknowns.point(middle)[3:].tolist() == pytest.approx([0.5, 0.25, 1.0])
    outside = {**middle, 'p1': -1.0}
    assert unknowns.point(outside)[3] == 0.0


def test_slopes_are_those_of_the_values_and_steps_those_taken() -> None:
    unknowns = Unknowns.of(LOG)
    z, h = np.full((1, 6), 0.3), np.full((1, 6), 1e-6)
    x0, p, steps = unknowns.perturbed(z, h)
    taken = np.concatenate([x0, p])
    moved = np.diag(taken[:, 1:] - taken[:, :1])
    np.testing.assert_allclose(moved / steps[0], unknowns.scale.slopes(z)[0], rtol=1e-5)
    np.testing.assert_allclose(unknowns.scale.places(taken[:, 4])[3] - 0.3, steps[0, 3], rtol=1e-8)
    assert unknowns.scale.slopes(z[:, 3], 3) == unknowns.scale.slopes(z)[:, 3]


@pytest.mark.parametrize('pair', [(0.0, 1.0), (-1.0, 1.0), (0.5, math.inf)])
def test_a_log_scale_needs_positive_finite_bounds(pair: tuple[float, float]) -> None:
    said = f'p1: bounds {pair[0]} and {pair[1]} must be positive and finite on a log scale'
    with pytest.raises(ValueError, match=re.escape(said)):
        Unknowns.of(LOG, bounds={'p1': pair})


def test_points_outside_are_clipped_and_nan_is_in_the_middle() -> None:
    unknowns = Unknowns.of(THREE_TANK, states=[], fixed={'h1': 1.0, 'h2': 1.0, 'h3': 1.0})
    point = unknowns.point({'p1': -3.0, 'p2': 7.0, 'p3': math.nan})
    assert point.tolist() == [0.0, 1.0, 0.5]


@pytest.mark.parametrize('half', [1e-10, 1e-7, 50.0])
@pytest.mark.parametrize('h', [1e-11, -1e-6])
def test_a_step_changes_the_value_in_a_box_however_narrow(half: float, h: float) -> None:
    unknowns = Unknowns.of(THREE_TANK, bounds={'h1': (50.0 - half, 50.0 + half)})
    x0, p, steps = unknowns.perturbed(np.full((1, 6), 0.5), np.full((1, 6), h))
    taken = np.concatenate([x0, p])
    moved = np.diag(taken[:, 1:] - taken[:, :1])
    assert (np.sign(moved) == np.sign(h)).all()
    np.testing.assert_allclose(steps[0] * unknowns.scale.width, moved, rtol=1e-12)


def test_without_a_bound_the_search_begins_near_the_nominal_value_and_may_leave() -> None:
    unknowns = Unknowns.of(
        THREE_TANK,
        parameters=['p1', 'p2', 'p3'],
        bounds={'p1': (-math.inf, math.inf), 'p2': (0.2, math.inf), 'h1': (-math.inf, 50.0)},
    )
    box = dict(
        zip(
            unknowns.names,
            zip(unknowns.scale.lower, unknowns.scale.upper, strict=True),
            strict=True,
        )
    )
    limits = dict(zip(unknowns.names, unknowns.limits.T.tolist(), strict=True))
    assert box['p1'] == (-9.0, 11.0) and limits['p1'] == [-math.inf, math.inf]
    assert box['p2'] == (0.2, 11.0) and limits['p2'] == [0.0, math.inf]
    assert box['h1'] == (40.0, 50.0) and limits['h1'] == [-math.inf, 1.0]
    assert box['h3'] == (0.0, 100.0) and limits['h3'] == [0.0, 1.0]
    far = unknowns.point({'h1': 0.0, 'h2': 0.0, 'h3': 0.0, 'p1': 31.0, 'p2': 0.0, 'p3': 0.0})
    assert far.tolist() == [-4.0, 0.0, 0.0, 2.0, 0.0, 0.0]


def known(**changes: Any) -> Model:
    p1 = Variable('p1', 'm', 0.5, 8.0, scale='log', **changes)
    h2 = replace(THREE_TANK.states[1], prior=(40.0, 5.0))
    states = (THREE_TANK.states[0], h2, THREE_TANK.states[2])
    return replace(THREE_TANK, states=states, parameters=(p1, *THREE_TANK.parameters[1:]))


def test_on_a_log_scale_a_walk_is_one_of_the_logarithm() -> None:
    linear = replace(THREE_TANK.parameters[1], walk=0.02)
    walking = known(walk=0.1)
    parameters = (walking.parameters[0], linear, walking.parameters[2])
    walks = Unknowns.of(replace(walking, parameters=parameters)).walks
    np.testing.assert_allclose(walks, [0.1 / math.log(16.0), 0.02, math.nan])  # p2 is 1 wide
    assert Unknowns.of(known(walk=math.inf)).walks[0] == math.inf


def test_priors_are_in_boxes_and_on_a_log_scale_of_the_logarithm() -> None:
    mean, sd = Unknowns.of(known(prior=(2.0, 0.1))).priors
    np.testing.assert_allclose(mean, [math.nan, 0.4, math.nan, 0.5, math.nan, math.nan])
    share = 0.05 / math.log(16.0)
    np.testing.assert_allclose(sd, [math.nan, 0.05, math.nan, share, math.nan, math.nan])
    mean, sd = Unknowns.of(known(), bounds={'h2': (20.0, 60.0)}).priors
    np.testing.assert_allclose((mean[1], sd[1]), (0.5, 0.125))
    assert np.isnan(np.concatenate([mean, sd])).sum() == 10
    assert [each.size for each in Unknowns.of(THREE_TANK, states=(), fixed={
        'h1': 1.0, 'h2': 1.0, 'h3': 1.0}).priors] == [3, 3]  # fmt: skip


def test_a_priors_mean_lies_within_the_bounds() -> None:
    said = 'h2: widen the bounds, or correct the prior: its mean 40.0 is outside [0.0, 30.0]'
    with pytest.raises(ValueError, match=re.escape(said)):
        Unknowns.of(known(), bounds={'h2': (0.0, 30.0)})
    assert Unknowns.of(known(), bounds={'h2': (0.0, 40.0)}).dimension == 6
    assert Unknowns.of(known(), fixed={'h2': 50.0}).dimension == 5  # nobody asks for it


def test_without_bounds_a_search_begins_about_the_priors_mean() -> None:
    free = replace(THREE_TANK.parameters[0], lower=-math.inf, upper=math.inf, prior=(5e3, 10.0))
    model = replace(THREE_TANK, parameters=(free, *THREE_TANK.parameters[1:]))
    scale = Unknowns.of(model).scale
    assert (scale.lower[3], scale.upper[3]) == (5e3 - 5e4, 5e3 + 5e4)


def test_only_what_is_estimated_can_be_given_something() -> None:
    unknowns = Unknowns.of(THREE_TANK, fixed={'p1': 0.5})
    unknowns.check_estimated('a prior', ['p2', 'h1'])
    with pytest.raises(ValueError, match=r'^p1 cannot have a prior: it is not estimated$'):
        unknowns.check_estimated('a prior', ['p2', 'p1'])
    with pytest.raises(ValueError, match="no state or parameter 'p22'"):
        unknowns.check_estimated('a prior', ['p22'])


@pytest.mark.parametrize(
    ('bounds', 'nominal', 'box'),
    [
        ((-math.pi, math.pi), None, (-math.pi, math.pi)),
        ((0.0, 7.0), None, (3.5 - math.pi, 3.5 + math.pi)),
        ((-math.inf, math.inf), None, (-math.pi, math.pi)),
        ((0.0, math.inf), 3.0, (3.0 - math.pi, 3.0 + math.pi)),
    ],
)
def test_the_box_of_a_state_that_wraps_is_one_period_without_limits(
    bounds: Any, nominal: Any, box: Any
) -> None:
    yaw = Variable('h1', 'rad', *bounds, nominal=nominal, period=2.0 * math.pi)
    unknowns = Unknowns.of(replace(THREE_TANK, states=(yaw, *THREE_TANK.states[1:])))
    assert (unknowns.scale.lower[0], unknowns.scale.upper[0]) == pytest.approx(box)
    np.testing.assert_array_equal(unknowns.limits[:, :2], [[-math.inf, 0.0], [math.inf, 1.0]])


def test_bounds_of_less_than_a_period_limit_a_state_modulo_the_period() -> None:
    yaw = Variable('h1', 'rad', 2.0, 4.0, period=2.0 * math.pi)
    unknowns = Unknowns.of(replace(THREE_TANK, states=(yaw, *THREE_TANK.states[1:])))
    np.testing.assert_array_equal(unknowns.limits, [[0.0] * 6, [1.0] * 6])
    values = dict.fromkeys(unknowns.names, 0.5)
    for angle, place in ((3.0, 0.5), (3.0 - 4.0 * math.pi, 0.5), (-3.0, 0.64), (0.0, 0.0)):
        assert unknowns.point({**values, 'h1': angle})[0] == pytest.approx(place, abs=0.002)
