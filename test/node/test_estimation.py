"""What an estimation makes on its node goes when it is closed, and when it cannot be made."""

import pytest
from node.fakes import FakeObserver
from ros import entities, solvers

from obs_ros.ros.estimation import Estimation
from obs_ros.ros.guarded import GuardedNode
from obs_ros.ros.parameters import Parameters
from obs_ros.ros.streams import Streams

GIVEN = {'observer': 'node.fakes:FakeObserver', 'window.duration': 2.0}


@pytest.fixture
def node(ros):
    return ros.start(lambda **options: GuardedNode('node', **options))


def test_closed_it_leaves_the_node_as_it_was(ros, node):
    before, threads = entities(node), solvers()
    parameters = Parameters(node, GIVEN, passing=True)
    estimation = Estimation(node, parameters)
    made = entities(node)
    assert made['publishers'] > before['publishers']
    ros.spin_until(lambda: len(solvers() - threads) == 1)
    assert made['subscriptions'] == before['subscriptions'], 'it does not listen yet'
    estimation.activate()
    assert entities(node)['subscriptions'] == before['subscriptions'] + 2
    assert estimation.close() and estimation.close(), 'twice is no harm'
    assert entities(node) == before
    changed = parameters.withdraw()
    assert {name: changed[name] for name in GIVEN} == GIVEN
    assert not node.has_parameter('model')
    ros.spin_until(lambda: not solvers() - threads)


@pytest.mark.parametrize('broken', [Streams, FakeObserver])
def test_one_that_cannot_be_made_leaves_nothing(ros, node, monkeypatch, broken):
    def fail(*arguments, **more):
        raise RuntimeError('broken')

    before, threads = entities(node), solvers()
    parameters = Parameters(node, GIVEN, passing=True)
    with monkeypatch.context() as patch, pytest.raises(RuntimeError, match='broken'):
        patch.setattr(broken, '__init__', fail)
        Estimation(node, parameters)
    assert entities(node) == before
    ros.spin_until(lambda: not solvers() - threads)
    parameters.withdraw()
    assert Estimation(node, Parameters(node, GIVEN, passing=True)).close()
