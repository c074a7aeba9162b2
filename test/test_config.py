"""Parameter files: one names every parameter, and every scenario has one that both nodes accept."""

import math
from pathlib import Path

import pytest
import yaml
from diagnostic_msgs.msg import DiagnosticArray
from ros import figures, set_parameter

from obs_ros.core.estimate import Outcome
from obs_ros.interface.fleet import FLEET as FLEET_PARAMETERS
from obs_ros.ros.estimator import Estimator
from obs_ros.ros.fleet import Fleet
from plant_sim.node import Simulator
from plant_sim.scenarios import SCENARIOS, load_scenario

FILES = {p.stem: p for p in sorted((Path(__file__).parents[1] / 'config').glob('*.yaml'))}
FLEET = FILES.pop('fleet')
REFERENCE = FILES['three_tank']
WALL = 2.0  # s that a window may take to fill
NODES = {'simulator': Simulator, 'estimator': Estimator}


def flat(tree, prefix=''):
    for key, value in tree.items():
        if isinstance(value, dict):
            yield from flat(value, f'{prefix}{key}.')
        else:
            yield prefix + key, value


def listed(path, name):
    return dict(flat(yaml.safe_load(path.read_text())[f'/**/{name}']['ros__parameters']))


def file_of(scenario):
    """The file of the scenario, or of the family that its name begins with."""
    return FILES[max((stem for stem in FILES if scenario.startswith(stem)), key=len)]


def same(one, other):
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(same, one, other))
    return one == other or (isinstance(one, float) and math.isnan(one) and math.isnan(other))


@pytest.mark.parametrize('name', NODES)
def test_the_reference_file_lists_every_parameter(ros, name):
    node = ros.start(NODES[name], '--ros-args', '--params-file', str(REFERENCE))
    declared = {p for p in node.get_parameters_by_prefix('') if not p.startswith('qos_overrides.')}
    assert set(listed(REFERENCE, name)) == {
        parameter for parameter in declared
        if not parameter.startswith(('use_sim_time', 'start_type_description_service', 'signals.'))
    }  # fmt: skip


def test_the_reference_file_shows_every_part_of_a_binding_as_a_comment(ros):
    block = REFERENCE.read_text().split('    # signals:')[1].split('\n    merge_wait')[0]
    signals = yaml.safe_load(f'signals:{block}'.replace('\n    #', '\n'))
    given = {name.replace('.', '__'): value for name, value in flat(signals)}
    node = ros.start(Estimator, **given)
    declared = {f'signals.h1.{part}' for part in node.get_parameters_by_prefix('signals.h1')}
    assert {name for name, _ in flat(signals)} == declared
    assert 'output./tank1/level/joint_states' in node.estimation.streams.subscriptions


@pytest.mark.parametrize('path', FILES.values(), ids=FILES)
def test_both_nodes_take_every_value_of_every_file(ros, capfd, path):
    assert set(yaml.safe_load(path.read_text())) == {'/**/simulator', '/**/estimator'}
    for name, kind in NODES.items():
        node = ros.start(kind, '--ros-args', '--params-file', str(path))
        for parameter, value in listed(path, name).items():
            assert node.has_parameter(parameter), parameter
            taken = node.get_parameter(parameter).value
            assert same(list(taken) if isinstance(value, list) else taken, value), parameter
    assert 'ignored, as' not in capfd.readouterr().err


def test_the_file_of_a_fleet_gives_parameters_to_it_to_all_plants_and_to_one(ros):
    fleet = ros.start(Fleet, '--ros-args', '--params-file', str(FLEET))
    given = listed(FLEET, 'fleet')
    assert set(given) == {spec.name for spec in FLEET_PARAMETERS}
    assert [*fleet.estimators] == given['plants'] and not fleet.refused
    sections = yaml.safe_load(FLEET.read_text())
    for name, estimator in fleet.estimators.items():
        own = sections.get(f'{name}/estimator', {'ros__parameters': {}})['ros__parameters']
        for parameter, value in {**listed(FLEET, 'estimator'), **dict(flat(own))}.items():
            assert estimator.get_parameter(parameter).value == value
    deviations = [each.get_parameter('noise.h1').value for each in fleet.estimators.values()]
    assert deviations == [0.0, 0.01]


@pytest.mark.parametrize('scenario', SCENARIOS)
def test_every_scenario_has_a_file_for_both_nodes(ros, scenario):
    """As the files say: scenario and model, where they are others, on the command line."""
    path, model = file_of(scenario), load_scenario(scenario).model
    choices = {'simulator': ('scenario', scenario), 'estimator': ('model', model)}
    for name, (choice, wanted) in choices.items():
        file = ('--ros-args', '--params-file', str(path))
        node = ros.start(NODES[name], *file, '-p', f'{choice}:={wanted}')
        assert node.get_parameter(choice).value == wanted
        assert getattr(node, 'estimation', node).model.name == model


@pytest.mark.parametrize('path', FILES.values(), ids=FILES)
def test_both_nodes_live_with_every_file_until_there_is_an_estimate(ros, path):
    """Unchanged but for the speed of the longer windows; the nodes' own word on it is read, too."""
    file = ('--ros-args', '--params-file', str(path))
    estimator = ros.start(Estimator, *file)
    window = listed(path, 'estimator').get('window.duration', 0.0)
    speed = max(listed(path, 'simulator').get('speed', 1.0), window / WALL)
    told = ros.listen('/diagnostics', DiagnosticArray)
    ros.spin_until(lambda: estimator.estimation.progress.ready, timeout=30.0)
    simulator = ros.start(Simulator, *file, '-p', f'speed:={speed}')
    ros.spin_until(lambda: estimator.estimation.progress.published, timeout=30.0)
    assert set_parameter(simulator, 'enabled', False).successful  # what follows says nothing new

    def judged():
        statuses = {status.name: status for array in told for status in array.status}
        outcomes = {figures(status).get('outcome') for status in statuses.values()}
        return statuses.keys() == {'/estimator', '/simulator'} and outcomes & set(Outcome)

    ros.spin_until(judged, timeout=30.0)
    assert estimator.estimation.progress.published and not estimator.estimation.progress.failed


def test_the_tanks_give_their_first_estimate_soon():
    """Within the time that somebody who follows the README waits for it."""
    simulated = listed(REFERENCE, 'estimator')['window.duration']
    assert simulated / listed(REFERENCE, 'simulator')['speed'] <= 15.0
