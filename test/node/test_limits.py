"""Every number that a remote caller may set is bounded, so that none stops a node or fills it."""

import math
import re
import tracemalloc

import pytest
from ros import set_parameter

from obs_ros.core.parameter_spec import ParameterSpec
from obs_ros.interface.bindings import signal_parameters
from obs_ros.interface.parameters import CHOICE, observer_parameters
from obs_ros.interface.settings import build_observer
from obs_ros.models import MODELS, load_model
from obs_ros.observers.base import OBSERVERS, load_observer
from plant_sim.fault_settings import fault_parameters, instrument_parameters
from plant_sim.node import Simulator
from plant_sim.scenarios import SCENARIOS, load_scenario
from plant_sim.settings import CHOICE as SCENARIO
from plant_sim.settings import COMMON, check_rate

# A bound of a variable or sensor may be infinite: there is none then. And infinite is what no noise
# has.
UNBOUNDED = re.compile(r'bounds\..*|signals\..*\.range|snr_db')
MEMORY = 200e6  # bytes that an observer may take when it is made


def numeric(spec: ParameterSpec) -> bool:
    entry = spec.default[0] if isinstance(spec.default, tuple) else spec.default
    return isinstance(entry, int | float) and not isinstance(entry, bool)


def suited():
    """Each observer with each model that suits it."""
    for observer in OBSERVERS:
        for model in MODELS:
            suits = getattr(load_observer(observer), 'suits', lambda model: None)
            try:
                suits(load_model(model))
            except ValueError:
                continue
            yield observer, model


@pytest.mark.parametrize(('observer', 'model'), list(suited()))
def test_every_number_of_an_estimator_is_bounded(observer, model):
    plant = load_model(model)
    specs = (*CHOICE, *observer_parameters(plant, observer), *signal_parameters(plant))
    found = [spec for spec in specs if numeric(spec)]
    assert len(found) > 5
    for spec in found:
        if not UNBOUNDED.fullmatch(spec.name):
            assert math.isfinite(spec.lower) or spec.positive, spec.name
            assert math.isfinite(spec.upper), spec.name


@pytest.mark.parametrize('scenario', SCENARIOS)
def test_every_number_of_a_simulator_is_bounded(scenario):
    model = load_model(load_scenario(scenario).model)
    faults = (*fault_parameters(model), *instrument_parameters(model))
    for spec in (*SCENARIO, *COMMON, *faults):
        if numeric(spec) and not UNBOUNDED.fullmatch(spec.name):
            assert math.isfinite(spec.lower) and math.isfinite(spec.upper), spec.name


@pytest.mark.parametrize(('observer', 'model'), list(suited()))
def test_no_allowed_number_fills_the_memory(observer, model):
    """Each at its bounds, alone and all together; what does not go together is refused."""
    plant = load_model(model)
    specs = observer_parameters(plant, observer)
    common = {'observer': observer} | {spec.name: spec.default for spec in specs}
    found = [k for k in specs if numeric(k) and not UNBOUNDED.fullmatch(k.name)
             and not isinstance(k.default, tuple)]  # fmt: skip
    most = {k.name: type(k.default)(k.upper) for k in found if not k.nan}
    trials = [most] + [{k.name: type(k.default)(v)} for k in found for v in (k.lower, k.upper)]
    made = 0
    for trial in trials:
        tracemalloc.start()
        try:
            build_observer(plant, common | trial)
            made += 1
        except ValueError:
            pass
        finally:
            _, peak = tracemalloc.get_traced_memory()
            tracemalloc.stop()
        assert peak < MEMORY, trial
    assert made > len(trials) / 3


@pytest.mark.parametrize(
    'change', [{'window.duration': 1e9}, {'window.period': 1e9}, {'window.duration': 2e6}]
)
def test_a_window_holds_steps_that_end(change):
    """Between two samples nothing can interrupt the model."""
    model = load_model('jet_engine')
    assert model.max_step < 0.2
    values = {k.name: k.default for k in observer_parameters(model, 'sliding_window')}
    values |= {'observer': 'sliding_window', **change}
    with pytest.raises(ValueError, match=r'^shorten window.duration or window.period: .* at most'):
        build_observer(model, values)


def test_a_rate_of_the_simulator_leaves_time_for_services(ros):
    node = ros.start(Simulator)
    answer = set_parameter(node, 'rate', 1e-9)
    assert not answer.successful and answer.reason.startswith('raise rate: ')
    assert set_parameter(node, 'rate', 0.1).successful
    assert set_parameter(node, 'rate', 1000.0).successful
    answer = set_parameter(node, 'noise_reference', 'measured')
    assert not answer.successful and answer.reason.startswith('lower rate, or ')
    for rate in (1e6, -1.0, math.inf):
        assert not set_parameter(node, 'rate', rate).successful
    for speed in (0.0, 1e7, math.inf):
        assert not set_parameter(node, 'speed', speed).successful


@pytest.mark.parametrize('scenario', SCENARIOS)
def test_every_scenario_may_measure_its_noise(scenario):
    found = load_scenario(scenario)
    values = {'rate': 0.0, 'noise_reference': 'measured'}
    check_rate(found, load_model(found.model), values)
