"""Many nodes in one thread: all is served, by turns, and the process wakes at most so often."""

import time

import pytest
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.task import Future
from ros import set_parameter
from std_msgs.msg import Int64
from std_srvs.srv import Trigger

from obs_ros.ros.guarded import GuardedNode
from obs_ros.ros.paced_executor import Pace, PacedExecutor

DEEP = QoSProfile(depth=1000)
EAGER = Pace(wake=0.0, services=0.0, events=0.0)


class Heard:
    """A node that hears numbers on its topic."""

    def __init__(self, name, context):
        self.node = GuardedNode(name, context=context)
        self.numbers = []
        self.node.create_subscription(Int64, name, lambda m: self.numbers.append(m.data), DEEP)


@pytest.fixture
def paced(ros):
    """A function that returns an executor at some pace, with nodes of these names."""
    made = []

    def paced(*names, pace=EAGER):
        executor = PacedExecutor(context=ros.context, pace=pace)
        nodes = [Heard(name, ros.context) for name in names]
        for each in nodes:
            executor.add_node(each.node)
        made.append((executor, nodes))
        return executor, *nodes

    yield paced
    for executor, nodes in made:
        executor.shutdown()
        for each in nodes:
            each.node.destroy_node()


def numbers(ros, topic, count):
    publisher = ros.node.create_publisher(Int64, topic, DEEP)
    ros.spin_until(publisher.get_subscription_count)
    for k in range(count):
        publisher.publish(Int64(data=k))


def until(ros, executor, predicate):
    def spun():
        executor.spin_once(0.02)
        return predicate()

    return ros.spin_until(spun)


def test_messages_timers_guards_and_services_are_served(ros, paced):
    executor, one, other = paced('one', 'other')
    ticks, woken = [], []
    one.node.create_timer(0.01, lambda: ticks.append(1))
    guard = other.node.create_guard_condition(lambda: woken.append(1))
    other.node.create_service(Trigger, 'ask', lambda _, response: response)
    guard.trigger()
    numbers(ros, 'one', 3)
    numbers(ros, 'other', 2)
    until(ros, executor, lambda: len(one.numbers) == 3 and len(other.numbers) == 2)
    until(ros, executor, lambda: len(ticks) > 2 and woken)
    assert (one.numbers, other.numbers, woken) == ([0, 1, 2], [0, 1], [1])
    client = ros.node.create_client(Trigger, 'ask')
    ros.spin_until(client.service_is_ready)
    future = client.call_async(Trigger.Request())
    until(ros, executor, future.done)
    assert set_parameter(one.node, 'use_sim_time', True).successful


def test_a_topic_that_floods_keeps_no_other_waiting(ros, paced):
    executor, flooded, calm = paced('flooded', 'calm')
    numbers(ros, 'flooded', 100)
    numbers(ros, 'calm', 1)
    until(ros, executor, lambda: calm.numbers)
    assert len(flooded.numbers) < 20  # one for each wake; the sender spins between
    until(ros, executor, lambda: len(flooded.numbers) == 100)


def test_it_wakes_at_most_so_often(paced):
    executor, node = paced('node', pace=Pace(wake=0.05, services=0.0))
    guard = node.node.create_guard_condition(lambda: guard.trigger())  # always ready
    guard.trigger()
    begun = time.monotonic()
    for _ in range(5):
        executor.spin_once()
    assert time.monotonic() - begun > 4 * 0.05 - 0.001


def test_a_spin_lasts_no_longer_than_it_is_told(ros, paced):
    executor, node = paced('node', pace=Pace(wake=1e3, services=1e3))
    done = []
    node.node.create_guard_condition(lambda: done.append(1)).trigger()
    executor.spin_once(0.0)
    executor.spin_once(0.0)  # else a thousand seconds
    assert done == [1]


def test_callbacks_of_a_node_that_a_callback_ends_do_not_run_and_no_other_is_forgotten(ros, paced):
    executor, one, two, three = paced('one', 'two', 'three')
    woken = []

    def end(own, other):
        woken.append(own.node.get_name())
        if other.node.get_name() not in woken:
            executor.remove_node(other.node)
            other.node.destroy_node()

    for own, other in (one, two), (two, one):
        own.node.create_guard_condition(lambda own=own, other=other: end(own, other)).trigger()
    three.node.create_guard_condition(lambda: woken.append('three')).trigger()
    for _ in range(4):
        executor.spin_once(0.02)
    assert sorted(woken) in (['one', 'three'], ['three', 'two'])


def test_a_callback_that_awaits_goes_on_later(ros, paced):
    executor, node = paced('node')
    answer, done = Future(), []

    async def ask():
        done.append(await answer)

    executor.create_task(ask)
    executor.spin_once(0.0)
    assert done == []
    node.node.create_guard_condition(lambda: answer.set_result('late')).trigger()
    until(ros, executor, lambda: done)
    assert done == ['late']


def test_the_exception_of_a_task_is_raised(paced):
    executor, _ = paced('node')
    executor.create_task(lambda: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        executor.spin_once(0.0)


def test_the_exception_of_a_callback_is_raised_and_others_go_on(ros, paced):
    executor, one, other = paced('one', 'other')
    Node.create_guard_condition(one.node, lambda: 1 / 0).trigger()
    with pytest.raises(ZeroDivisionError):
        until(ros, executor, lambda: False)
    numbers(ros, 'other', 1)
    until(ros, executor, lambda: other.numbers)


def test_it_ends_with_the_context(ros, paced):
    executor, _ = paced('node')
    ros.context.try_shutdown()
    with pytest.raises(ExternalShutdownException):
        executor.spin_once(0.0)


def test_publishers_whose_qos_does_not_match_are_told(ros, paced, capfd):
    executor, node = paced('node')
    ros.node.create_publisher(Int64, 'node', QoSProfile(depth=1, reliability=2))  # best effort
    until(ros, executor, lambda: 'incompatible QoS' in capfd.readouterr().err)
    assert node.numbers == []
