"""The health of real streams: any model, bound to topics in any way, at every stage of a life."""

import functools
import re

import pytest
from interface.test_health import estimate
from sensor_msgs.msg import JointState

from obs_ros.core.estimate import Outcome
from obs_ros.core.model import Model, Variable, names
from obs_ros.interface.bindings import HEADER, Binding
from obs_ros.interface.field_path import FieldPath
from obs_ros.interface.health import examine
from obs_ros.interface.progress import Progress
from obs_ros.interface.readers import NAMED_VECTOR
from obs_ros.interface.status import Level
from obs_ros.interface.worker import Finished
from obs_ros.ros.guarded import GuardedNode
from obs_ros.ros.messages import STREAM, named_vector
from obs_ros.ros.streams import Streams, check_bindings

# Whether each output (input) is bound to a topic of its own, as the example's are.
OUTPUTS = [(False,), (True,), (False, False), (True, False), (True, True)]
INPUTS = [(), *OUTPUTS]
WINDOW = 100.0


def plant(outputs, inputs):
    return Model(
        name='plant',
        states=(Variable('x'),),
        inputs=[Variable(f'u{k}') for k in range(len(inputs))],
        outputs=[Variable(f'y{k}') for k in range(len(outputs))],
        dynamics=lambda t, x, u, p: (-x[0] + sum(u),),
        output=lambda t, x, u, p: tuple(x[0] for _ in outputs),
    )


def bindings_of(model, bound):
    variables = (*model.outputs, *model.inputs)
    path = FieldPath.parse('position[0]')
    return {
        v.name: Binding(v.name, f'rig/{v.name}', NAMED_VECTOR, path, 1.0, 0.0, HEADER)
        for v, is_bound in zip(variables, bound, strict=True)
        if is_bound
    }  # fmt: skip


class Bench:
    """Streams on a node, and who publishes what they listen to."""

    def __init__(self, ros, outputs, inputs):
        self.ros, self.model = ros, plant(outputs, inputs)
        node = ros.start(functools.partial(GuardedNode, 'bench'))
        self.bound = bindings_of(self.model, (*outputs, *inputs))
        check_bindings(node, self.model, self.bound)
        self.streams = Streams(node, self.model, self.bound, 0.0, lambda sample, arrival: None)
        self.streams.open()
        self.heard = list(self.streams.subscriptions.values())
        self.publishers = {}

    def topics(self):
        return {each.topic for each in self.heard}

    def send(self, heard, stamp):
        """Publish on the topic of a subscription, and wait until it has it."""
        publisher = self.publishers.get(heard.topic)
        if publisher is None:
            publisher = self.ros.node.create_publisher(JointState, heard.topic, STREAM)
            self.publishers[heard.topic] = publisher
            self.ros.spin_until(publisher.get_subscription_count)
        group = self.model.inputs if heard.role == 'input' else self.model.outputs
        entries = [name for name in names(group) if name not in self.bound] or ['any']
        before = heard.received
        publisher.publish(
            named_vector(round(stamp * 1e9), entries or ['any'], [1.0] * len(entries) or [1.0])
        )
        self.ros.spin_until(lambda: heard.received > before)

    def told(self, progress, stale_after=1e9, **changes):
        """Return the health of windows; that of an immediate observer must be told, too."""
        settings = {'observer': 'x', 'stale_after': stale_after, 'window.duration': WINDOW}
        health = examine(progress, self.streams.status(), settings, changes, None)
        del settings['window.duration']
        assert examine(progress, self.streams.status(), settings, changes, None).message
        # Whatever looks like a topic is one.
        words = re.findall(r'/?(?:plant|rig)/\w+', health.message)
        assert set(words) <= self.topics(), health.message
        return health


@pytest.mark.parametrize('outputs', OUTPUTS, ids=str)
@pytest.mark.parametrize('inputs', INPUTS, ids=str)
def test_every_stage_has_its_word(ros, outputs, inputs):
    bench = Bench(ros, outputs, inputs)
    heard = bench.heard
    roles = [each.role for each in heard]
    assert roles == sorted(roles, reverse=True), 'outputs first'
    assert len(bench.topics()) == len(heard) == len(bench.streams.subscriptions)
    progress = Progress(enabled=False)
    assert bench.told(progress).message.startswith('paused')
    progress.enabled = True
    assert bench.told(progress).message.startswith('compiling')
    progress.ready = True
    for each in heard:
        health = bench.told(progress)
        assert health.message.startswith(f'waiting for {each.topic}: ')
        bench.send(each, 1000.0)
    # Nothing is apart, so the window is collected; then each topic in turn is ahead by more.
    assert bench.told(progress).message.startswith('collecting the first window: 0 of 100 s')
    for k, each in enumerate(heard):
        bench.send(each, 1000.0 + 150.0 * (k + 1))
        health = bench.told(progress)
        if len(heard) > 1:
            first = min(f.stamp for f in heard)
            oldest = [f.topic for f in heard if f.stamp == first]
            assert health.level is Level.WARN
            assert f'{each.topic} is stamped ' in health.message
            assert health.message.rpartition(' s after ')[2] in oldest
        else:
            assert health.level is Level.OK
    for each in heard:
        bench.send(each, 2000.0)
    first = heard[0]
    bench.send(first, 2050.0)
    progress.collected = 20.0
    health = bench.told(progress)
    assert health.message.startswith('collecting the first window: 20 of 100 s')
    if len(heard) > 1:
        assert health.message.endswith(f' is 50 s behind {first.topic}')
    assert bench.told(progress, overflow=1).message.startswith('shorten window.duration')
    assert bench.told(progress, duplicate=99).message.startswith('let the publisher set')
    assert bench.told(progress, all_nan=99).message.startswith('look at what is measured')
    assert bench.told(progress, stale_after=0.0).message.startswith('stale_output: ')
    progress.fail(Finished('estimate', None, ZeroDivisionError('no')))
    assert bench.told(progress).level is Level.ERROR
    for outcome in Outcome:
        progress.conclude(estimate(outcome), 0.1, True)
        assert bench.told(progress).message == f'{outcome.value}: as told'
    progress.restart()
    assert bench.told(progress).message.startswith('compiling')


def test_a_stale_input_is_told_from_a_stale_output(ros, monkeypatch):
    bench = Bench(ros, (True,), (True,))
    for each in bench.heard:
        bench.send(each, 1.0)
    output, input_ = bench.heard
    monkeypatch.setattr(output, '_arrival', 1e12)
    health = bench.told(Progress(ready=True), stale_after=0.0)
    assert health.figures['outcome'] == 'stale_input' and input_.topic in health.message
