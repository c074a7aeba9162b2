"""Parameter files: one names every parameter, and every scenario has one that both nodes accept."""

import math
from pathlib import Path

import pytest
import yaml

from obs_ros.node.estimator import Estimator
from plant_sim.node import Simulator
from plant_sim.scenarios import SCENARIOS, load_scenario

FILES = {p.stem: p for p in sorted((Path(__file__).parents[1] / 'config').glob('*.yaml'))}
REFERENCE = FILES['three_tank']
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
    assert 'output./tank1/level/joint_states' in node._feeds


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


@pytest.mark.parametrize('scenario', SCENARIOS)
def test_every_scenario_has_a_file_for_both_nodes(ros, scenario):
    """As the files say: scenario and model, where they are others, on the command line."""
    path, model = file_of(scenario), load_scenario(scenario).model
    choices = {'simulator': ('scenario', scenario), 'estimator': ('model', model)}
    for name, (choice, wanted) in choices.items():
        file = ('--ros-args', '--params-file', str(path))
        node = ros.start(NODES[name], *file, '-p', f'{choice}:={wanted}')
        assert node.get_parameter(choice).value == wanted
        assert node.model.name == model
