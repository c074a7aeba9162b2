"""The live page's node: which estimators it finds, what it hears of them, and what it leaves."""

import collections
import dataclasses
import json
import urllib.parse
import urllib.request
from functools import partial

import numpy as np
import pytest
from interface.test_vectors import ESTIMATE, TANKS
from patience import patience
from rclpy.node import Node
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from obs_ros.horizon.prediction import Predicted
from obs_ros.pages.board import BoardSettings
from obs_ros.ros.info import model_info, publish_info, settings_info
from obs_ros.ros.messages import LATCHED, STREAM
from obs_ros.ros.publication import EstimatePublisher
from obs_ros.ros.view import View

SECOND = 10**9
OF_ITSELF = ('info', 'outcome')  # topics
KNOWN = json.dumps({**model_info(TANKS), **settings_info({'observer': 'sliding_window'})})
CONVERGED = json.dumps({'stamp_ns': SECOND, 'outcome': 'converged', 'message': 'found'})
OWN_SERVICES = ('rcl_interfaces/', 'type_description_interfaces/')  # rclpy's, of parameters


class Stand(Node):
    """Stands for an estimator: the same topics, and it says what a test tells it to."""

    def __init__(self, namespace, **options):
        super().__init__('estimator', namespace=namespace, **options)
        publish_info(self)(json.loads(KNOWN))
        self._publisher = EstimatePublisher(self, TANKS, predicting=True)
        self.create_subscription(JointState, 'plant/output', lambda message: None, 1)

    def say(self, t):
        estimate = dataclasses.replace(ESTIMATE, stamp=t * SECOND, message=f'at {t}')
        self._publisher.publish(estimate, latency=0.25, skipped=0)

    def predict(self, stamp, level, residual):
        deviations, spread = dict.fromkeys(ESTIMATE.state, 0.1), {'h1': 0.1, 'h2': 0.1}
        self._publisher.publish_prediction(
            Predicted(stamp, {**ESTIMATE.state, 'h3': level}, deviations, residual, spread)
        )


def start(ros, namespace):
    return ros.start(partial(Stand, namespace))


@pytest.fixture
def view(ros):
    return ros.start(View, port=0)


def asked(view, **query):
    """Return what the server says, as a browser gets it."""
    text = urllib.parse.urlencode(query, doseq=True)
    address = f'{view.server.address}data?{text}'
    with urllib.request.urlopen(address, timeout=patience(5.0)) as response:
        return json.load(response)


def curve(view, name, kind, variable, role):
    """Return times and values of one curve, none where there is none."""
    for shown in asked(view, of=name)['shown']:
        for panel in shown['panels']:
            if (panel['kind'], panel['name']) == (kind, variable):
                for each in panel['curves']:
                    if each['role'] == role:
                        return each['t'], each['v']
    return [], []


def drawn(answer):
    """Return times and values of all curves of the first estimator in an answer."""
    return collections.defaultdict(lambda: ([], []), {
        (panel['kind'], panel['name'], each['role']): (each['t'], each['v'])
        for panel in answer['shown'][0]['panels'] for each in panel['curves']
    })  # fmt: skip


def is_well(view, name):
    return {each['name']: each['well'] for each in asked(view)['estimators']}.get(name)


def test_estimators_are_found_and_heard_side_by_side(ros, view):
    stands = {f'{space}/estimator': start(ros, space) for space in ('/a', '/b')}
    ros.spin_until(lambda: view.board.names == [*stands])
    for k, stand in enumerate(stands.values()):
        ros.spin_until(
            lambda stand=stand: stand.count_subscribers(f'{stand.get_namespace()}/estimator/state')
        )
        for t in (4, 10 + k):
            stand.say(t)
    for k, name in enumerate(stands):
        t, values = ros.spin_until(
            lambda name=name, k=k: (found := curve(view, name, 'parameter', 'p3', 'estimate'))
            and found[0] == [0.0, 6.0 + k] and found
        )  # fmt: skip
        assert values == [ESTIMATE.parameters['p3']] * 2
    found = asked(view, of=[*stands])
    assert [shown['outcome']['message'] for shown in found['shown']] == ['at 10', 'at 11']
    ros.spin_until(lambda: asked(view)['shown'][0]['jumps'])
    (jump, *_) = asked(view)['shown'][0]['jumps']
    assert jump['names'] == ['p3', 'p2'] and jump['probability'] == 0.96


def test_measurements_and_truth_are_those_beside_the_estimator(ros, view):
    stand = start(ros, '/a')
    truth, output = ros.speak('/a/plant/parameters', heard=False), ros.speak('/a/plant/output')
    ros.spin_until(lambda: stand.count_subscribers('/a/plant/parameters'))
    ros.spin_until(lambda: stand.count_subscribers('/a/plant/output') == 2)
    output(1.0, ['h1', 'h2'], [20.0, 15.0])
    truth(1.0, ['p1', 'p2', 'p3'], [1.0, 0.9, 0.8])
    for kind, name, role, value in (
        ('state', 'h2', 'measured', 15.0), ('parameter', 'p3', 'truth', 0.8),
    ):  # fmt: skip
        sought = partial(curve, view, '/a/estimator', kind, name, role)
        assert ros.spin_until(lambda sought=sought: sought()[1]) == [value]


def test_an_estimator_that_hears_another_plant_now_has_the_measurements_of_that(ros, view):
    other = '--ros-args', '-r', 'plant/output:=/other/output'
    for arguments, topic in (((), '/a/plant/output'), (other, '/other/output')):
        stand = ros.start(partial(Stand, '/a'), *arguments)
        ros.spin_until(lambda stand=stand, topic=topic: stand.count_subscribers(topic) == 2)
        ros.spin_until(lambda topic=topic: asked(view)['shown'][0]['plant'] == topic)
        ros.stop(stand)
    ros.spin_until(lambda: view.count_subscribers('/other/output') == 1)
    ros.spin_until(lambda: view.count_subscribers('/a/plant/output') == 0)


def test_topics_of_a_plant_are_bounded(ros, view, monkeypatch):
    monkeypatch.setattr('obs_ros.ros.view.MOST_TOPICS', 2)
    stand = start(ros, '/a')
    for k in range(3):
        stand.create_subscription(JointState, f'plant/more{k}', lambda message: None, 1)
    ros.spin_until(lambda: asked(view)['shown'])
    ros.spin_until(lambda: len(asked(view)['shown'][0]['plant'].split()) == 2)


def test_a_restart_is_told_and_outlived(ros, view):
    for t in (9, 11):
        stand = start(ros, '/a')
        ros.spin_until(lambda stand=stand: stand.count_subscribers('/a/estimator/state'))
        ros.spin_until(lambda stand=stand: stand.count_subscribers('/a/estimator/state_stddev'))
        stand.say(t)
        ros.spin_until(lambda: is_well(view, '/a/estimator'))
        if t == 9:
            ros.stop(stand)
            ros.spin_until(lambda: is_well(view, '/a/estimator') is False)
            (told,) = asked(view)['estimators']
            assert told['words'].startswith('gone for')
    t, _ = ros.spin_until(
        lambda: (found := curve(view, '/a/estimator', 'state', 'h1', 'estimate'))
        and len(found[0]) == 2 and found
    )  # fmt: skip
    assert t == [0.0, 2.0]


@pytest.mark.slow
def test_no_spike_of_a_plant_at_1_khz_goes_unseen(ros, view):
    stand, output = start(ros, '/a'), ros.speak('/a/plant/output', heard=False)
    ros.spin_until(lambda: stand.count_subscribers('/a/plant/output') == 2)
    for topic in ('prediction', 'prediction_stddev', 'residual'):
        ros.spin_until(lambda topic=topic: stand.count_subscribers(f'/a/estimator/{topic}'))
    rng = np.random.default_rng(0)
    count, apart, block = 4000, 200, 200
    quiet = rng.normal(0.0, 0.01, (3, count))
    # Each lasts one sample; one up and one down in turn, none in the last block.
    grid = np.arange(apart, count - block, apart)
    at = grid + rng.integers(0, apart // 2, (3, grid.size))
    size = rng.uniform(3.0, 9.0, at.shape) * (-1.0) ** np.arange(at.shape[1])
    for row, places, values in zip(quiet, at, size, strict=True):
        row[places] = values
    sought = (
        ('state', 'h1', 'measured'),
        ('state', 'h3', 'prediction'),
        ('residual', 'h2', 'residual'),
    )

    def behind(k):
        """Whether a stream is more than half a block behind: its last messages may be lost."""
        known = drawn(view.board.answer({'span': ['0.4'], 'points': ['10']}))
        return any(known[key][0][-1:] < [(k - block // 2) / 1000] for key in sought)

    for k, (level, predicted, residual) in enumerate(quiet.T.tolist()):
        output(1.0 + k / 1000, ['h1', 'h2'], [level, 0.0])
        stand.predict(SECOND + k * SECOND // 1000, predicted, {'h1': 0.0, 'h2': residual})
        if k % block == block - 1:
            ros.spin_until(lambda k=k: not behind(k))
    answer = asked(view, points=100)
    known, lost = drawn(answer), answer['shown'][0]['lost']
    unseen = 0
    for key, places, values in zip(sought, at, size, strict=True):
        t, v = known[key]
        assert len(t) <= 200
        seen = {*zip(np.round(np.multiply(t, 1000)).astype(int).tolist(), v, strict=True)}
        spikes = zip(places.tolist(), [float(f'{value:.7g}') for value in values], strict=True)
        unseen += sum(spike not in seen for spike in spikes)
    assert unseen <= lost < count // 100


def test_messages_that_are_lost_are_told(ros, view):
    stand, output = start(ros, '/a'), ros.speak('/a/plant/output', heard=False)
    ros.spin_until(lambda: stand.count_subscribers('/a/plant/output') == 2)
    output(1.0, ['h1'], [0.0])
    ros.spin_until(lambda: curve(view, '/a/estimator', 'state', 'h1', 'measured')[0])
    assert asked(view)['shown'][0]['lost'] == 0
    for k in range(1500):  # 1000 wait for the page at most
        output(1.001 + k / 1000, ['h1'], [0.0])
    ros.spin_until(lambda: asked(view)['to'] > 1.4)
    assert 500 <= asked(view)['shown'][0]['lost'] < 1500


def test_it_reads_only(ros, view):
    name = view.get_name()
    published = dict(view.get_publisher_names_and_types_by_node(name, '/'))
    assert {*published} == {'/parameter_events', '/rosout'}
    assert view.get_client_names_and_types_by_node(name, '/') == []
    services = dict(view.get_service_names_and_types_by_node(name, '/'))
    assert all(kinds[0].startswith(OWN_SERVICES) for kinds in services.values())


def test_more_than_fit_are_named_and_follow_when_there_is_room(ros):
    first = start(ros, '/a')
    view = ros.start(partial(View, BoardSettings(most=1)), port=0)
    ros.spin_until(lambda: view.board.names == ['/a/estimator'])
    start(ros, '/b')
    (note,) = ros.spin_until(lambda: asked(view)['notes'])
    assert '/b/estimator' in note and '-p estimators' in note
    ros.stop(first)
    ros.spin_until(lambda: view.board.names == ['/b/estimator'])
    ros.spin_until(lambda: asked(view)['notes'] == [])


def test_only_those_named_are_shown(ros):
    start(ros, '/a')
    start(ros, '/b')
    view = ros.start(View, port=0, estimators=['/b/estimator'])
    ros.spin_until(lambda: view.board.names)
    assert view.board.names == ['/b/estimator']


def says(ros, name):
    """Return publishers of ~/info and ~/outcome, of an estimator that is only these."""
    ros.node.create_publisher(JointState, f'{name}/solver', STREAM)
    return [ros.node.create_publisher(String, f'{name}/{of}', LATCHED) for of in OF_ITSELF]


def test_an_outcome_that_was_told_before_its_info_is_heard(ros, view):
    info, outcome = says(ros, '/x')
    outcome.publish(String(data=CONVERGED))
    ros.spin_until(info.get_subscription_count)
    start(ros, '/a')
    ros.spin_until(lambda: view.board.names == ['/a/estimator'])  # so long after
    info.publish(String(data=KNOWN))
    ros.spin_until(lambda: is_well(view, '/x'))


def test_what_strangers_write_is_counted_and_ends_nothing(ros, view):
    info, outcome = says(ros, '/x')
    for k, text in enumerate(('[', '{a: 1}'), start=1):
        info.publish(String(data=text))
        ros.spin_until(lambda k=k: view.failures.count == k)
    assert view.board.names == []
    info.publish(String(data=KNOWN))
    ros.spin_until(outcome.get_subscription_count)
    outcome.publish(String(data='['))
    ros.spin_until(lambda: view.failures.count == 3)
    outcome.publish(String(data='{a: 1}'))  # an outcome without a stamp is none
    start(ros, '/a').say(9)
    ros.spin_until(lambda: is_well(view, '/a/estimator'))
    assert view.failures.count == 3 and not is_well(view, '/x')


def test_a_port_that_is_taken_is_told_with_the_way_out(ros, view):
    taken = [Parameter('port', value=view.server.port)]
    with pytest.raises(ValueError, match='give another port, such as -p port:=0'):
        View(context=ros.context, parameter_overrides=taken)
