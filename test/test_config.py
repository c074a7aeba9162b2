"""The parameter files name every parameter of the nodes, with values that they accept."""

from pathlib import Path

import pytest
import yaml

from obs_ros.node.estimator import Estimator
from plant_sim.node import Simulator

FILES = sorted((Path(__file__).parents[1] / 'config').glob('*.yaml'))


def flat(tree, prefix=''):
    for key, value in tree.items():
        if isinstance(value, dict):
            yield from flat(value, f'{prefix}{key}.')
        else:
            yield prefix + key


@pytest.mark.parametrize('path', FILES, ids=lambda path: path.name)
@pytest.mark.parametrize('kind', [Simulator, Estimator])
def test_every_parameter_is_there_and_accepted(ros, capfd, path, kind):
    node = ros.start(kind, '--ros-args', '--params-file', str(path))
    listed = set(
        flat(yaml.safe_load(path.read_text())[f'/**/{node.get_name()}']['ros__parameters'])
    )
    declared = set(node.get_parameters_by_prefix(''))
    assert listed == declared - {'use_sim_time', 'start_type_description_service'}
    assert 'there is no parameter' not in capfd.readouterr().err
