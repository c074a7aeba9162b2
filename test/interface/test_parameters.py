"""Tables of parameters: every row is in order, and no two get in each other's way."""

import math
from dataclasses import replace

import pytest

from obs_ros import Variable
from obs_ros.core.parameter_spec import markdown_table
from obs_ros.interface import parameters as tables
from obs_ros.interface.bindings import signal_parameters
from obs_ros.interface.parameters import is_foreign, observer_parameters, own_prefix, walk_unit
from obs_ros.models import MODELS, load_model
from obs_ros.observers.base import OBSERVERS, load_observer
from plant_sim import fault_settings
from plant_sim import settings as plant_settings

TANKS = load_model('three_tank')
ALL_SPECS = (
    *tables.CHOICE, *tables.LIVE, *tables.COMMON, *tables.model_parameters(TANKS),
    *tables.prior_parameters(TANKS),
    *plant_settings.CHOICE, *plant_settings.COMMON, *fault_settings.fault_parameters(TANKS),
    *fault_settings.instrument_parameters(TANKS),
)  # fmt: skip


@pytest.mark.parametrize('spec', ALL_SPECS, ids=lambda spec: spec.name)
def test_every_default_is_allowed_and_described(spec):
    assert spec.coerce(spec.default) is spec.default or spec.coerce(spec.default) == spec.default
    assert spec.default != () and spec.description
    assert f'`{spec.name}`' in markdown_table([spec])


@pytest.mark.parametrize('observer', OBSERVERS)
@pytest.mark.parametrize('model', MODELS)
def test_no_parameter_is_a_value_and_a_prefix(observer, model):
    """`ros2 param dump` nests them by their dots."""
    model = load_model(model)
    names = {
        spec.name
        for spec in (
            *tables.CHOICE,
            *tables.observer_parameters(model, observer),
            *signal_parameters(model),
        )
    }  # fmt: skip
    assert len(names) > 10 and not clashing(names)


def clashing(names):
    return [(a, b) for a in names for b in names if b.startswith(f'{a}.')]


@pytest.mark.parametrize('observer', OBSERVERS)
def test_only_observers_of_windows_have_windows_deadlines_and_predictions(observer):
    names = {spec.name for spec in observer_parameters(TANKS, observer)}
    windowed = not load_observer(observer).immediate
    for name in ('window.duration', 'deadline', 'prediction.enabled', 'search.method'):
        assert (name in names) == windowed
    assert {'seed', 'stale_after', 'bounds.p1', 'fixed.h1', 'noise.h2', 'initial.p3'} <= names
    own = {name for name in names if name.startswith(f'{observer}.')}
    assert len(own) == (0 if windowed else len(vars(load_observer(observer).Settings())))


def test_an_observers_own_parameters_begin_with_its_name():
    assert own_prefix('ekf') == 'ekf.' and own_prefix('my.module:Mine') == 'Mine.'


@pytest.mark.parametrize(
    ('name', 'foreign'),
    [
        ('use_sim_time', True), ('start_type_description_service', True),
        ('qos_overrides./plant/output.subscription.depth', True), ('seed', False),
        ('use_sim_times', False), ('my.qos_overrides.x', False),
    ],
)  # fmt: skip
def test_parameters_that_every_node_has_are_known(name, foreign):
    assert is_foreign(name) == foreign


@pytest.mark.parametrize('observer', OBSERVERS)
def test_observers_that_take_them_have_walks_and_priors(observer):
    names = {spec.name for spec in observer_parameters(TANKS, observer)}
    taken = observer in ('sliding_window', 'ekf', 'ukf')
    assert tables.takes_priors(load_observer(observer)) == taken
    for name in ('walk.h1', 'walk.p1', 'prior.h1', 'prior.p1'):
        assert (name in names) == taken


def test_walks_and_priors_begin_as_the_model_has_them():
    model = replace(TANKS, parameters=(
        Variable('p1', 'm', 0.1, 1.0, scale='log', walk=0.01, prior=(0.5, 0.1)),
        replace(TANKS.parameters[1], walk=math.inf), TANKS.parameters[2],
    ))  # fmt: skip
    rows = {spec.name: spec for spec in tables.prior_parameters(model)}
    assert [rows[f'walk.{n}'].default for n in ('h1', 'p1', 'p2')] == [0.0, 0.01, math.inf]
    assert rows['prior.p1'].default == (0.5, 0.1) and rows['prior.h1'].default == (0.0, 0.0)
    assert rows['walk.h1'].unit == 'cm/sqrt(s)' and rows['walk.p1'].unit == '1/sqrt(s)'
    assert 'the logarithm of p1' in rows['walk.p1'].description
    assert rows['walk.p2'].coerce(math.inf) == math.inf
    for name, wrong in (('walk.h1', math.inf), ('walk.p1', -1.0), ('prior.h1', (1.0, 2e100))):
        with pytest.raises(ValueError, match=f'^{name} must be '):
            rows[name].coerce(wrong)


def test_a_walk_is_per_root_of_a_second():
    rate = Variable('k', '1/s', lower=1e-6, upper=1.0, scale='log')
    walks = [walk_unit(each) for each in (Variable('share'), Variable('v', 'm/s'), rate)]
    assert walks == ['1/sqrt(s)', 'm/s/sqrt(s)', '1/sqrt(s)']
