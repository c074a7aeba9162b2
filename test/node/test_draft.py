"""Parameters of a node that is not configured yet."""

from rclpy.node import Node
from ros import set_parameter

from obs_ros.interface.parameters import CHOICE
from obs_ros.ros.draft import Draft
from obs_ros.ros.parameters import given_at_start


def make_node(**options):
    return Node('node', automatically_declare_parameters_from_overrides=True, **options)


def test_what_was_given_can_be_mended_and_taken_back_and_nothing_else_be_set(ros):
    node = ros.start(make_node, gain=3, noise__h1=-1.0)
    draft = Draft(node, given_at_start(node))
    assert not node.has_parameter('gain')
    draft.open()
    assert set_parameter(node, 'gain', 'another type').successful
    assert set_parameter(node, 'noise.h1', None).successful
    assert set_parameter(node, 'model', 'jet_engine').successful
    refused = set_parameter(node, 'observer', 'planted.code:Observer')
    assert not refused.successful and refused.reason.startswith('start the node with observer')
    defaults = {spec.name: spec.default for spec in CHOICE}
    assert draft.close() == {**defaults, 'model': 'jet_engine', 'gain': 'another type'}
    assert not any(node.has_parameter(name) for name in ('gain', 'model', 'noise.h1'))
    draft.open({'gain': 2.0})
    assert draft.close()['gain'] == 2.0


def test_closed_from_the_start_it_hands_on_what_was_given(ros):
    node = ros.start(make_node, gain=3)
    assert Draft(node, given_at_start(node)).close() == {'gain': 3}
