import math
import time
from functools import partial
from itertools import pairwise

import pytest
import yaml
from ros import Waiting, figures, set_parameter, vector
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String
from std_srvs.srv import SetBool, Trigger

from obs_ros.ros.messages import LATCHED
from plant_sim.node import Simulator
from plant_sim.scenarios import SCENARIOS, load_scenario
from plant_sim.sensors import Sensor
from plant_sim.simulation import Simulation

TOPICS = ('output', 'input', 'state', 'parameters')


def seconds(message):
    return message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec


@pytest.fixture
def paused(ros):
    """A simulator at 100 times real time, not yet running, and what it publishes.

    It waits for those who listen, and they have found it.
    """
    clock = Waiting()
    node = ros.start(partial(Simulator, clock=clock), speed=100, enabled=False, seed=4)
    heard = {topic: ros.listen(f'/plant/{topic}') for topic in TOPICS}
    clock.behind = lambda: min(len(messages) for messages in heard.values()) < node.sent - 5
    return node, heard


def test_it_publishes_the_scenario_sample_by_sample(ros, paused):
    _, heard = paused
    clocks = ros.listen('/clock', Clock)
    assert ros.call('/simulator/enable', SetBool, data=True).success
    ros.spin_until(lambda: min(len(messages) for messages in heard.values()) >= 20)
    reference = Simulation(load_scenario('three_tank'), seed=4)
    for k in range(20):
        instant = reference.sample()
        assert {seconds(heard[topic][k]) for topic in TOPICS} == {instant.t}
        assert tuple(heard['output'][k].position) == instant.y
        assert tuple(heard['state'][k].position) == instant.x
        assert vector(heard['input'][k]) == {'Q1': 30.0, 'Q2': 30.0}
        assert vector(heard['parameters'][k]) == {'p1': 1.0, 'p2': 1.0, 'p3': 1.0}
    ros.spin_until(lambda: clocks and clocks[-1].clock.sec >= 19)
    ticks = [c.clock.sec + 1e-9 * c.clock.nanosec for c in clocks]
    assert ticks == sorted(ticks) and set(range(1, 19)) <= {round(t, 9) for t in ticks}


def test_it_keeps_its_speed(ros):
    wall = [7.0]
    node = ros.start(partial(Simulator, clock=lambda: wall[0]), speed=100)
    outputs = ros.listen('/plant/output')
    wall[0] += 0.255
    ros.spin_until(lambda: node.sent == 26)  # at 0, 1, ... 25 s
    wall[0] += 0.25
    ros.spin_until(lambda: outputs and seconds(outputs[-1]) == 50.0)
    assert node.sent == 51


def test_stamps_are_wall_time_at_speed_one(ros):
    before = time.time()
    ros.start(Simulator, rate=50)
    outputs = ros.listen('/plant/output')
    ros.spin_until(lambda: len(outputs) > 10)
    assert before <= seconds(outputs[0]) <= time.time()
    steps = [seconds(b) - seconds(a) for a, b in pairwise(outputs)]
    assert steps == pytest.approx([0.02] * len(steps), abs=1e-6)
    assert ros.node.count_publishers('/clock') == 0


def test_a_fault_is_injected_and_taken_away_while_it_runs(ros, paused):
    node, heard = paused
    ros.call('/simulator/enable', SetBool, data=True)
    assert set_parameter(node, 'plant.p1', 0.25).successful
    ros.spin_until(lambda: heard['parameters'] and heard['parameters'][-1].position[0] == 0.25)
    assert set_parameter(node, 'plant.p1', math.nan).successful
    ros.spin_until(lambda: heard['parameters'][-1].position[0] == 1.0)


def test_a_sensor_breaks_and_is_mended_while_it_runs(ros, paused):
    node, heard = paused
    assert set_parameter(node, 'sensor.h2.outlier_period', 2.0).successful
    assert set_parameter(node, 'sensor.h2.outlier_value', -7.0).successful
    assert set_parameter(node, 'sensor.h1.delay', -2.0).successful
    ros.call('/simulator/enable', SetBool, data=True)
    ros.spin_until(lambda: len(heard['output']) > 20)
    assert figures(ros.health())['faults'] == (
        'sensor.h1.delay=-2, sensor.h2.outlier_period=2, sensor.h2.outlier_value=-7'
    )
    assert set_parameter(node, 'sensor.h2.outlier_period', 0.0).successful
    ros.spin_until(lambda: heard['output'][-1].position[1] != heard['output'][-3].position[1] != -7)
    reference = Simulation(load_scenario('three_tank'), seed=4)
    reference.sensors = {
        'h1': Sensor(delay=-2.0),
        'h2': Sensor(outlier_period=2.0, outlier_value=-7.0),
    }
    for message in heard['output'][:20]:
        assert tuple(message.position) == reference.sample().y
    assert [m.position[1] == -7.0 for m in heard['output'][:20]] == [False, False] + [
        True, False
    ] * 9  # fmt: skip


def test_a_sensor_is_as_declared_until_it_is_set(ros):
    """Signals that are declared for both nodes are those of the plant; a delay is told as truth."""
    node = ros.start(Simulator, speed=100, enabled=False, **{
        'signals.h1.resolution': 4.0, 'signals.Q1.delay': [0.0, 9.0], 'actuator.Q1.delay': 3.0,
    })  # fmt: skip
    heard = {topic: ros.listen(f'/plant/{topic}') for topic in TOPICS}
    assert node.get_parameter('sensor.h1.resolution').value == 4.0
    assert figures(ros.health())['faults'] == 'actuator.Q1.delay=3'
    assert ros.call('/simulator/enable', SetBool, data=True).success
    ros.spin_until(lambda: len(heard['output']) > 20 and heard['parameters'])
    assert vector(heard['parameters'][-1]) == {'p1': 1.0, 'p2': 1.0, 'p3': 1.0, 'Q1.delay': 3.0}
    assert {message.position[0] % 4.0 for message in heard['output'][:20]} == {0.0}
    assert set_parameter(node, 'sensor.h1.resolution', 0.0).successful
    ros.spin_until(lambda: heard['output'][-1].position[0] % 4.0)


def test_messages_carry_names_that_nobody_wants(ros, paused):
    node, heard = paused
    ros.call('/simulator/enable', SetBool, data=True)
    ros.spin_until(lambda: heard['input'])
    assert set_parameter(node, 'further_names', 2).successful
    ros.spin_until(lambda: len(heard['input'][-1].name) == len(heard['output'][-1].name) == 4)
    for topic, own in (('input', ['Q1', 'Q2']), ('output', ['h1', 'h2'])):
        message = heard[topic][-1]
        assert message.name == ['further_1', 'further_2', *own]
        assert list(message.position[:2]) == [0.0, 0.0] and len(message.position) == 4
    assert list(heard['state'][-1].name) == ['h1', 'h2', 'h3']


def test_reset_starts_the_same_run_again(ros, paused):
    _, heard = paused
    ros.call('/simulator/enable', SetBool, data=True)
    ros.spin_until(lambda: len(heard['output']) > 10)
    assert ros.call('/simulator/reset', Trigger).success
    stamps = [seconds(m) for m in heard['output']]
    ros.spin_until(lambda: [seconds(m) for m in heard['output']].count(0.0) == 2)
    again = [seconds(m) for m in heard['output']].index(0.0, len(stamps) - 1)
    assert heard['output'][again].position == heard['output'][0].position


def test_pausing_stops_samples_and_loses_none(ros, paused):
    node, heard = paused
    for _ in range(2):
        ros.call('/simulator/enable', SetBool, data=True)
        count = len(heard['output'])
        ros.spin_until(lambda n=count: len(heard['output']) > n + 5)
        ros.call('/simulator/enable', SetBool, data=False)
        count = node.sent
        ros.spin_until(lambda n=count: len(heard['output']) == n)
    status = ros.health()
    assert status.level == status.WARN and 'paused' in status.message
    assert node.sent == count
    assert [seconds(m) for m in heard['output']] == [float(k) for k in range(count)]


def test_the_speed_changes_while_it_runs_where_time_is_simulated(ros, paused):
    node, heard = paused
    ros.call('/simulator/enable', SetBool, data=True)
    ros.spin_until(lambda: len(heard['output']) > 5)
    assert set_parameter(node, 'speed', 400).successful
    ros.spin_until(lambda: len(heard['output']) > 200)
    stamps = [seconds(m) for m in heard['output']]
    assert stamps == [float(k) for k in range(len(stamps))]


def test_it_says_when_it_cannot_keep_up(ros):
    ros.start(Simulator, speed=1e6)

    def slow():
        status = ros.health()
        return status if 'cannot keep up' in status.message else None

    status = ros.spin_until(slow)
    assert status.level == status.WARN
    assert 0.0 < float(figures(status)['rate_hz']) < float(figures(status)['wanted_rate_hz'])


@pytest.mark.parametrize(
    ('name', 'value', 'reason'),
    [
        ('plant.p1', 1.5, 'plant.p1 must be 0 to 1, not 1.5'),
        ('speed', 0, 'speed must be 0.001 to 1e6'),
        ('speed', 2.0, 'publish_clock'),
        ('sensor.h1.delay', 2000.0, 'sensor.h1.delay must be -1000 to 1000 s, not 2000.0'),
        ('sensor.h1.range', [3.0, 1.0], 'sensor.h1.range must be [lower, upper], not [3.0, 1.0]'),
        ('sensor.h1.outlier_length', 0, 'sensor.h1.outlier_length must be 1 to 1000000'),
        ('actuator.Q1.delay', -1.0, 'actuator.Q1.delay must be 0 to 1000 s, not -1.0'),
        ('further_names', 101, 'further_names must be 0 to 100, not 101'),
        ('noise_reference', 'meassured', "did you mean 'measured'?"),
        ('scenario', 'os:path', 'read-only'),
    ],
)
def test_a_wrong_value_is_refused_and_nothing_changes(ros, name, value, reason):
    node = ros.start(Simulator)
    answer = set_parameter(node, name, value)
    assert not answer.successful and reason in answer.reason
    assert set_parameter(node, 'plant.p2', 1).successful


@pytest.mark.parametrize(
    ('parameters', 'reason'),
    [
        ({'scenario': 'three_tnak'}, "unknown scenario 'three_tnak': did you mean 'three_tank'?"),
        ({'speed': -1.0}, 'speed must be 0.001 to 1e6, not -1.0'),
        ({'plant__p1': 'open'}, "plant.p1 must be a number, not 'open'"),
    ],
)
def test_wrong_values_at_start(ros, parameters, reason):
    with pytest.raises(ValueError) as caught:
        ros.start(Simulator, **parameters)
    assert reason in str(caught.value)


def test_info_is_there_for_those_who_come_late(ros, paused):
    texts = ros.listen('/simulator/info', String, LATCHED)
    info = yaml.safe_load(ros.spin_until(lambda: texts)[0].data)
    assert info['scenario'] == 'three_tank' and info['sample_period'] == 1.0
    assert info['settings']['seed'] == 4 and info['stamps'] == 'plant time'


@pytest.mark.parametrize('name', SCENARIOS)
def test_it_plays_every_scenario_as_it_is_played_offline(ros, name):
    ros.start(Simulator, scenario=name, speed=2, enabled=False, seed=4)
    heard = {topic: ros.listen(f'/plant/{topic}') for topic in TOPICS}
    ros.call('/simulator/enable', SetBool, data=True)
    ros.spin_until(lambda: min(len(messages) for messages in heard.values()) >= 3)
    reference = Simulation(load_scenario(name), seed=4)
    for k in range(3):
        instant = reference.sample()
        played = [tuple(heard[topic][k].position) for topic in TOPICS]
        assert played == [instant.y, instant.u, instant.x, instant.p]


def test_a_mismatch_is_changed_while_it_runs(ros):
    node = ros.start(Simulator, scenario='glycolytic_oscillator_mismatch')
    parameters = ros.listen('/plant/parameters')
    ros.spin_until(lambda: parameters and vector(parameters[-1]) == {'a': 0.8, 'd': 1.0})
    assert set_parameter(node, 'plant.a', 0.9).successful
    ros.spin_until(lambda: vector(parameters[-1]) == {'a': 0.9, 'd': 1.0})
    assert 'must be 0.5 to 1.5' in set_parameter(node, 'plant.a', 2.0).reason


def test_reset_clears_the_integral_of_a_controller(ros):
    ros.start(Simulator, scenario='jet_engine_case1', speed=2)
    inputs = ros.listen('/plant/input')
    ros.spin_until(lambda: len(inputs) > 20)
    assert ros.call('/simulator/reset', Trigger).success
    ros.spin_until(lambda: [seconds(m) for m in inputs].count(0.0))
    at = [seconds(m) for m in inputs].index(0.0)
    # e = Psi - r = 0.5 - 2.6: 5 e + 2 T e.
    assert inputs[at].position[0] == pytest.approx(-5.02 * 2.1)
