"""Every fault that a stream of samples can have, end to end: sent, told, and survived.

A fault spoils the messages of a sound run of three tanks. What the node says of it on /diagnostics
stands in the table, and so does what becomes of the estimates. None that is wrong may pass for
right, ever: farther than six standard deviations from the truth, unless the outcome says so.
"""

import math
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
import yaml
from diagnostic_msgs.msg import DiagnosticArray
from patience import patience
from plants import tank_outputs
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile, ReliabilityPolicy
from ros import figures, set_parameter
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String

from obs_ros.core.estimate import Outcome
from obs_ros.horizon.moving_horizon import MovingHorizon
from obs_ros.horizon.solver import Solver
from obs_ros.ros import diagnostics
from obs_ros.ros.estimator import Estimator
from obs_ros.ros.messages import LATCHED, time_message

WINDOW, WINDOWS, SIGMA = 60, 3, 0.01  # s, number, cm
X0, TRUTH = (50.0, 40.0, 45.0), {'p1': 0.6, 'p2': 0.5, 'p3': 0.7}
LEVELS, FEEDS = ('h1', 'h2'), ('Q1', 'Q2')
NOISE = {'noise__h1': SIGMA, 'noise__h2': SIGMA}
SURE = 6.0  # standard deviations
BEST_EFFORT = ReliabilityPolicy.BEST_EFFORT
FLAGGED = (Outcome.MODEL_MISMATCH, Outcome.DEADLINE, Outcome.DIVERGED)


class Message(NamedTuple):
    """One message to be sent: stream, stamp (s), names and values."""

    stream: str
    t: float
    names: tuple[str, ...]
    values: tuple[float, ...]


Run = list[Message]


def run(interval: float = 1.0, window: int = WINDOW, seed: int = 0) -> Run:
    """Three windows of the tanks, inputs first."""
    t = np.arange(0.0, WINDOWS * window + interval / 2, interval)
    noise = np.random.default_rng(seed).standard_normal((t.size, 2))
    levels = tank_outputs(t, X0, tuple(TRUTH.values())) + SIGMA * noise
    messages = []
    for time, level in zip(t.tolist(), levels.tolist()):
        messages.append(Message('input', time, FEEDS, (30.0, 30.0)))
        messages.append(Message('output', time, LEVELS, tuple(level)))
    return messages


def of(stream: str, messages: Run, change: Callable[[int, Message], Sequence[Message]]) -> Run:
    """Put what `change(k, message)` returns in place of each message of a stream, k its number."""
    spoilt, k = [], 0
    for message in messages:
        if message.stream != stream:
            spoilt.append(message)
            continue
        spoilt += change(k, message)
        k += 1
    return spoilt


def dropped(messages: Run) -> Run:
    rng = np.random.default_rng(1)
    last = messages[-2:]
    return [m for m in messages[:-2] if rng.random() > 0.2] + last


def duplicated(messages: Run) -> Run:
    return [m for k, m in enumerate(messages) for _ in range(1 + (k % 6 == 0))]


def reordered(messages: Run) -> Run:
    swapped = list(messages)
    for k in range(20, len(swapped) - 40, 20):
        swapped[k], swapped[k + 2] = swapped[k + 2], swapped[k]
    return swapped


def late(messages: Run) -> Run:
    """Ten samples of the first window come in the second: that has been taken."""
    held, rest = messages[20:40], messages[:20] + messages[40:]
    for k, message in enumerate(held):
        rest.insert(160 + 5 * k, message)
    return rest


def stray(stamp: float) -> Callable[[Run], Run]:
    return lambda messages: of(
        'output', messages, lambda k, m: [m._replace(t=stamp) if k % 30 == 20 else m]
    )


def no_stamps(messages: Run) -> Run:
    return [m._replace(t=0.0) for m in messages]


def other_clock(messages: Run) -> Run:
    return of('input', messages, lambda k, m: [m._replace(t=m.t + 1e9)])


def jump(by: float) -> Callable[[Run], Run]:
    """The stamps of the last two windows are others; the plant starts again, as it does there."""
    half = len(messages := run()) // 3
    return lambda _: [
        *(m._replace(t=m.t + 1000.0) for m in messages[:half]),
        *(m._replace(t=m.t + 1000.0 + by) for m in messages),
    ]


def entries(value: float, every: int) -> Callable[[Run], Run]:
    """One of the two levels is `value` in every so many messages."""
    return lambda messages: of(
        'output',
        messages,
        lambda k, m: [m._replace(values=(value, m.values[1])) if k % every == 5 else m],
    )


def all_nan(messages: Run) -> Run:
    return of(
        'output', messages,
        lambda k, m: [m._replace(values=(math.nan, math.inf)) if k % 30 == 5 else m],
    )  # fmt: skip


def besides(**wrong) -> Callable[[Run], Run]:
    """Wrong messages, among the right ones."""
    return lambda messages: of(
        'output', messages, lambda k, m: [m._replace(**wrong), m] if k % 30 == 5 else [m]
    )


def scaled(stream: str, factors: tuple[float, float]) -> Callable[[Run], Run]:
    def change(_: int, m: Message) -> list[Message]:
        return [m._replace(values=tuple(f * v for f, v in zip(factors, m.values)))]

    return lambda messages: of(stream, messages, change)


def stuck(*places: int, since: int = WINDOW) -> Callable[[Run], Run]:
    """Levels stand still, by default from the second window on."""

    def spoil(messages: Run) -> Run:
        held = messages[2 * WINDOW + 1].values

        def change(k: int, m: Message) -> list[Message]:
            values = [held[i] if i in places and k > since else v for i, v in enumerate(m.values)]
            return [m._replace(values=tuple(values))]

        return of('output', messages, change)

    return spoil


def stopped(stream: str) -> Callable[[Run], Run]:
    return lambda messages: of(stream, messages, lambda k, m: [m] if k < 80 else [])


@dataclass(frozen=True)
class Fault:
    """What is sent, what must be said, and which estimates must come of it.

    `counts` are least figures on /diagnostics, `says` a part of the message; `right` tells that the
    last window must give a confident estimate, `windows` how many are published at most.
    """

    spoil: Callable[[Run], Run]
    counts: dict[str, int] = field(default_factory=dict)
    says: str = ''
    outcome: str = 'converged'
    right: bool = True
    windows: int = WINDOWS
    noise_known: bool = True
    settings: dict[str, object] = field(default_factory=dict)
    interval: float = 1.0
    window: int = WINDOW


def flagged(spoil: Callable[[Run], Run], outcome: str, says: str, **more) -> Fault:
    return Fault(spoil, outcome=outcome, says=says, right=False, **more)


MISMATCH = 'model_mismatch'
UNSKILLED = 'no better than holding the last value'
STALE = {'stale_after': 0.5}
FAULTS = {
    'none': Fault(list),
    'dropped': Fault(dropped),
    'duplicated': Fault(duplicated, {'samples.duplicate': 60}),
    'reordered': Fault(reordered, {'samples.reordered': 10}),
    'late': Fault(late, {'samples.late': 20}),
    'zero stamps now and then': Fault(stray(0.0), {'samples.late': 4}),
    'zero stamps always': flagged(
        no_stamps, 'collecting', 'let the publisher set header.stamp', windows=0,
        counts={'samples.duplicate': 300},
    ),
    'future stamps now and then': Fault(stray(1e6), {'samples.ahead': 5}),
    'streams on two clocks': flagged(
        other_clock, 'collecting', 'use one clock for both publishers', windows=0
    ),
    'stamps jump back': Fault(jump(-1000.0), {'samples.reset': 1}),
    'stamps jump ahead': Fault(jump(1e6), {'samples.reset': 1}),
    'NaN': Fault(entries(math.nan, 6), {'samples.nan': 30}),
    'infinity': Fault(entries(-math.inf, 6), {'samples.nan': 30}),
    'nothing but NaN': Fault(all_nan, {'samples.all_nan': 6}),
    'huge values': Fault(entries(1e300, 6), {'samples.huge': 30}),
    'values beyond a million boxes': Fault(entries(1.1e8, 6), {'samples.huge': 30}),
    'wrong names': Fault(besides(names=('h1', 'h9')), {'output.missing_name': 6}),
    'missing names': Fault(besides(names=('h1',), values=(1.0,)), {'output.missing_name': 6}),
    'further names': Fault(
        besides(names=('h1', 'x', 'h2'), values=(1.0, 2.0, 3.0)), {'output.other_names': 6}
    ),
    'wrong sizes': Fault(besides(values=(1.0, 2.0, 3.0)), {'output.wrong_length': 6}),
    'outputs in m': flagged(scaled('output', (0.01, 0.01)), MISMATCH, UNSKILLED),
    'outputs in m, noise unknown': flagged(
        scaled('output', (0.01, 0.01)), MISMATCH, UNSKILLED, noise_known=False
    ),
    'one output in mm': flagged(scaled('output', (10.0, 1.0)), MISMATCH, 'times the noise'),
    'inputs in l/s': flagged(
        scaled('input', (1e-3, 1e-3)), MISMATCH, 'contradicted the model', window=100
    ),
    'inputs ten times': flagged(scaled('input', (10.0, 10.0)), MISMATCH, UNSKILLED),
    'a stuck sensor': flagged(
        stuck(0), 'stale_output', 'h1 repeats the same value', counts={'samples.stuck': 100}
    ),
    'a sensor stuck from the start, noise unknown': flagged(
        stuck(0, since=-1),
        'stale_output',
        'h1 repeats the same value',
        counts={'samples.stuck': 180},
        noise_known=False,
    ),
    'all sensors stuck': flagged(
        stuck(0, 1), 'stale_output', 'withheld', counts={'withheld': 1, 'samples.stuck': 200},
        windows=1,
    ),
    'all sensors stuck, noise learned': flagged(
        stuck(0, 1), 'stale_output', 'withheld', counts={'withheld': 1}, windows=1,
        noise_known=False,
    ),
    'the output stops': flagged(
        stopped('output'), 'stale_output', 'no plant/output', windows=1, settings=STALE
    ),
    'ten times the rate': Fault(list, {'output.received': 1801}, interval=0.1),
    'a rate too high for the memory': Fault(
        list, {'samples.overflow': 100}, interval=0.1, settings={'window__capacity': 500}
    ),
}  # fmt: skip


class Bench:
    """An estimator, what it concludes, and the streams that it is fed by."""

    def __init__(
        self, ros, monkeypatch, *overrides, heard=True, streams=('input', 'output'), **settings
    ):
        monkeypatch.setattr(diagnostics, 'PERIOD', 0.1)
        self.ros = ros
        cli = [word for override in overrides for word in ('-p', override)]
        self.estimator = ros.start(
            Estimator, *(['--ros-args', *cli] if cli else []),
            **{'window__duration': float(WINDOW), **settings},
        )  # fmt: skip
        self.concluded = []
        conclude = self.estimator.estimation.progress.conclude

        def spy(estimate, latency, published):
            self.concluded.append((estimate, published))
            conclude(estimate, latency, published)

        monkeypatch.setattr(self.estimator.estimation.progress, 'conclude', spy)
        self.parameters = ros.listen('/estimator/parameters')
        self.arrays = ros.listen('/diagnostics', DiagnosticArray)
        self.speakers = {s: ros.speak(f'/plant/{s}', heard=heard) for s in streams}
        ros.spin_until(lambda: self.estimator.estimation.progress.ready, timeout=60.0)

    def play(self, messages: Run) -> None:
        """Send the messages, and give the estimator time to solve every window by itself."""
        self.send(messages, lambda: self.estimator.estimation.idle)

    def send(self, messages: Run, idle: Callable[[], bool] = lambda: True) -> None:
        """Send a few messages at a time: the streams wait in queues of their own."""
        heard = self.estimator.estimation.streams.subscriptions
        expected = {name: subscription.received for name, subscription in heard.items()}
        for k, message in enumerate(messages, 1):
            self.speakers[message.stream](*message[1:])
            expected[message.stream] += 1
            if k % 20 == 0 or k == len(messages):
                self.ros.spin_until(
                    lambda: all(heard[s].received >= n for s, n in expected.items()) and idle(),
                    timeout=30.0,
                )

    def told(self, outcome: str):
        """Wait for the outcome on /diagnostics; return its message and figures."""
        del self.arrays[:]

        def found():
            # The first may have been on its way already.
            statuses = [array.status[0] for array in self.arrays[1:]]
            return [s for s in statuses if figures(s)['outcome'] == outcome]

        try:
            status = self.ros.spin_until(found)[0]
        except AssertionError:
            last = self.arrays[-1].status[0]
            pytest.fail(f'{last.message}, {figures(last)}')
        return status.message, figures(status)

    def wrong(self) -> list[str]:
        """Say which published estimates pass for right, and are not."""
        return [
            f'{name} = {value} +- {estimate.stddev[name]} ({estimate.outcome}) at {estimate.t1}'
            for estimate, published in self.concluded
            if published and estimate.outcome not in FLAGGED
            for name, value in estimate.parameters.items()
            if abs(value - TRUTH[name]) > SURE * estimate.stddev[name]  # False for NaN
        ]


@pytest.mark.parametrize('name', FAULTS)
def test_a_fault_is_told_and_no_wrong_estimate_published(ros, monkeypatch, name):
    fault = FAULTS[name]
    noise = NOISE if fault.noise_known else {}
    settings = {'window__duration': float(fault.window), **noise, **fault.settings}
    bench = Bench(ros, monkeypatch, **settings)
    messages = fault.spoil(run(fault.interval, fault.window))
    bench.play(messages)
    message, told = bench.told(fault.outcome)
    assert fault.says in message
    for figure, least in fault.counts.items():
        assert int(told[figure]) >= least, (figure, told)
    assert not bench.wrong()
    published = [estimate for estimate, published in bench.concluded if published]
    assert len(published) <= fault.windows + (told['samples.reset'] != '0')
    assert int(told['published']) == len(published)
    if fault.right:
        last = published[-1]
        assert last.t1 == messages[-1].t
        deviations = [last.stddev[name] for name in TRUTH]
        assert all(0.0 < deviation < 0.1 for deviation in deviations)
    else:
        assert told['outcome'] != 'converged'


def test_an_input_that_stops_is_told_while_the_output_goes_on(ros, monkeypatch):
    bench = Bench(ros, monkeypatch, **NOISE, **STALE)
    messages = stopped('input')(run())
    bench.play(messages[:-60])
    rest = iter(messages[-60:])

    def stale():
        if message := next(rest, None):
            bench.play([message])
        return [a for a in bench.arrays if figures(a.status[0])['outcome'] == 'stale_input']

    found = ros.spin_until(stale)[0].status[0]
    assert found.message == 'stale_input: does a publisher run? no plant/input for more than 0.5 s'
    assert len(bench.parameters) == 1 and not bench.wrong()


class Others:
    """A second publisher of every stream, of another plant."""

    def __init__(self, ros):
        self.speakers = {s: ros.speak(f'/plant/{s}') for s in ('input', 'output')}

    def say(self, message: Message) -> None:
        self.speakers[message.stream](message.t, message.names, [0.9 * v for v in message.values])


def test_two_publishers_in_turns_are_told_and_estimates_withheld(ros, monkeypatch):
    bench = Bench(ros, monkeypatch, **NOISE)
    other = Others(ros)
    for message in run():
        bench.play([message])
        other.say(message._replace(t=message.t + 0.5))
    message, told = bench.told('mixed')
    assert 'stop all but one of the 2 publishers' in message
    assert told['output.publishers'] == '2'
    assert not bench.parameters and told['published'] == '0'


def test_two_publishers_that_send_in_bursts_are_told_too(ros, monkeypatch):
    """Ten at a time, their clocks .3 s apart: time seems to jump back again and again."""
    bench = Bench(ros, monkeypatch, **NOISE)
    other = Others(ros)
    messages = run()
    for k in range(0, len(messages), 20):
        burst = messages[k : k + 20]
        bench.play(burst)
        for message in burst:
            other.say(message._replace(t=message.t - 0.3))
    message, told = bench.told('mixed')
    assert '2 publishers' in message
    assert told['published'] == '0' and told['output.lost'] == '0'


def test_a_publisher_that_takes_over_is_no_second_one(ros, monkeypatch):
    """As when the simulator is killed and started again: the old one may be listed for long."""
    bench = Bench(ros, monkeypatch, **NOISE)
    messages = run()
    bench.play(messages[:201])
    bench.speakers = Others(ros).speakers
    bench.play([m._replace(t=m.t - 5000.0) for m in messages])
    _, told = bench.told('converged')
    assert told['output.publishers'] == '2' and told['samples.reset'] == '1'
    assert not bench.wrong() and bench.concluded[-1][0].t1 == messages[-1].t - 5000.0


def test_an_estimator_that_starts_again_recovers_within_a_window(ros, monkeypatch):
    messages = run()
    bench = Bench(ros, monkeypatch, **NOISE)
    bench.play(messages[:202])
    ros.stop(bench.estimator)
    again = Bench(ros, monkeypatch, **NOISE)
    again.play(messages[202:])
    first = next(estimate for estimate, published in again.concluded if published)
    assert first.t0 == messages[202].t and first.t1 == messages[202].t + WINDOW
    assert not bench.wrong() and not again.wrong()


QOS = '/plant/output.subscription'


def test_a_publisher_whose_durability_is_another_is_told(ros, monkeypatch):
    bench = Bench(ros, monkeypatch, f'qos_overrides.{QOS}.durability:=transient_local', heard=False)
    message, told = bench.told('waiting')
    assert told['output.reliable'] == 'true', 'that would not help'
    assert message == (
        'waiting for plant/output: a publisher of plant/output is not heard: '
        'its QoS durability is another'
    )


def test_the_quality_of_service_can_be_overridden(ros, monkeypatch):
    bench = Bench(
        ros, monkeypatch, f'qos_overrides.{QOS}.reliability:=best_effort',
        'qos_overrides./estimator/state.publisher.depth:=7',
    )  # fmt: skip
    assert bench.told('waiting')[1]['output.reliable'] == 'false'
    assert bench.told('waiting')[1]['input.reliable'] == 'true'
    (info,) = ros.node.get_publishers_info_by_topic('/estimator/state')
    assert (
        bench.estimator.get_parameter('qos_overrides./estimator/state.publisher.depth').value == 7
    )
    assert info.qos_profile.reliability == ReliabilityPolicy.RELIABLE


def test_a_best_effort_publisher_is_heard_and_said_to_be_one(ros, monkeypatch):
    bench = Bench(ros, monkeypatch)
    assert bench.told('waiting')[1]['output.reliable'] == 'true'
    unsure = ros.speak('/plant/output', QoSProfile(depth=5, reliability=BEST_EFFORT), heard=False)
    output = bench.estimator.estimation.streams.subscriptions['output']

    def heard():
        unsure(1.0, LEVELS, (1.0, 1.0))
        return output.received

    ros.spin_until(heard)
    assert bench.told('waiting')[1]['output.reliable'] == 'false'
    bench.speakers['output'](2.0, LEVELS, (1.0, 1.0))
    ros.spin_until(lambda: output.stamp == 2 * 10**9)


def test_a_clock_that_stands_still_stops_nothing(ros, monkeypatch):
    bench = Bench(ros, monkeypatch, use_sim_time=True, **NOISE)
    clock = ros.node.create_publisher(Clock, '/clock', 10)
    ros.spin_until(clock.get_subscription_count)
    clock.publish(Clock(clock=time_message(7 * 10**9)))
    ros.spin_until(lambda: bench.estimator.get_clock().now().nanoseconds == 7 * 10**9)
    bench.play(run())
    _, told = bench.told('converged')
    assert told['published'] == '3' and not bench.wrong()
    assert {array.header.stamp.sec for array in bench.arrays} == {7}


def test_simulated_time_on_and_off_forgets_nothing(ros, monkeypatch):
    bench = Bench(ros, monkeypatch, **NOISE)
    messages = run()
    for part, simulated in (
        (slice(0, 90), True),
        (slice(90, 200), False),
        (slice(200, None), True),
    ):
        bench.play(messages[part])
        assert set_parameter(bench.estimator, 'use_sim_time', simulated).successful
    _, told = bench.told('converged')
    assert told['published'] == '3' and told['samples.reset'] == '0'
    assert [estimate.t1 for estimate, _ in bench.concluded] == [60.0, 120.0, 180.0]


def test_a_solver_slower_than_the_period_skips_windows_and_stays_right(ros, monkeypatch):
    bench = Bench(ros, monkeypatch, **NOISE)
    begun, go, solve = threading.Event(), threading.Event(), MovingHorizon.solve

    def slow(*arguments):
        begun.set()
        assert go.wait(patience(20.0))
        return solve(*arguments)

    monkeypatch.setattr(MovingHorizon, 'solve', slow)
    messages = run()
    bench.send(messages[:140])  # 70 s: the first window is closed
    ros.spin_until(begun.is_set)
    bench.send(messages[140:])
    go.set()
    ros.spin_until(lambda: len(bench.concluded) == 2)
    _, told = bench.told('converged')
    assert told['skipped'] == '1' and not bench.wrong()
    assert [estimate.t1 for estimate, _ in bench.concluded] == [60.0, 180.0]


def test_several_parameters_change_at_once_with_the_next_window(ros, monkeypatch):
    bench = Bench(ros, monkeypatch, **NOISE)
    messages = run()
    bench.play(messages[:160])
    before = bench.estimator.estimation.observer
    answer = bench.estimator.set_parameters_atomically(
        [
            Parameter('fixed.p1', value=0.6),
            Parameter('bounds.p2', value=[0.3, 0.8]),
            Parameter('search.population', value=64),
            Parameter('deadline', value=2.0),
        ]
    )
    assert answer.successful and bench.estimator.estimation.observer is not before
    ros.spin_until(lambda: bench.estimator.estimation.progress.ready)
    bench.play(messages[160:])
    _, told = bench.told('converged')
    # The very window that was half full is solved with them, and no sample is lost.
    assert [estimate.t1 for estimate, _ in bench.concluded] == [60.0, 120.0, 180.0]
    assert bench.concluded[0][0].stddev['p1'] > 0.0 == bench.concluded[1][0].stddev['p1']
    assert told['samples.reset'] == '0' and not bench.wrong()


def test_every_parameter_that_is_not_read_only_changes_live(ros, monkeypatch):
    bench = Bench(ros, monkeypatch)
    estimator = bench.estimator
    values = {
        'deadline': 0.5, 'stale_after': 9.0, 'prediction.enabled': False, 'prediction.rate': 5.0,
        'window.duration': 50.0, 'window.period': 25.0, 'window.capacity': 5000,
        'parameters': ['p1', 'p2'], 'states': ['h1', 'h2', 'h3'], 'learn_noise': True,
        'fitness': 'euclidean', 'seed': 7, 'search.method': 'chaotic_de', 'search.chaos': 'tent',
        'search.population': 30, 'search.generations': 9, 'search.strategy': 'best/1/bin',
        'search.differential_weight': 0.6, 'search.crossover': 0.8,
        'bounds.p1': [0.1, 0.9], 'fixed.p3': 0.7, 'noise.h1': 0.02, 'initial.h3': 44.0,
        'walk.h1': 0.1, 'walk.p2': math.inf, 'prior.h2': [40.0, 2.0], 'prior.p1': [0.5, 0.1],
        'process_noise': 'off', 'loss': 'squares',
    }  # fmt: skip
    assert set_parameter(estimator, 'process_noise', 'auto').successful
    declared = set(estimator.get_parameters_by_prefix(''))
    families = ('bounds.', 'fixed.', 'noise.', 'initial.', 'walk.', 'prior.', 'qos_overrides.',
                'use_sim_time', 'start_type', 'model', 'observer', 'signals.', 'merge_wait',
                'managed', 'checkpoint')  # fmt: skip
    assert {n for n in declared if not n.startswith(families)} <= set(values)
    answer = estimator.set_parameters_atomically([Parameter(n, value=v) for n, v in values.items()])
    assert answer.successful, answer.reason
    infos = ros.listen('/estimator/info', String, LATCHED)
    info = yaml.safe_load(ros.spin_until(lambda: infos)[-1].data)
    for name, value in values.items():
        taken = estimator.get_parameter(name).value
        assert (list(taken) if isinstance(value, list) else taken) == value
        assert info['settings'][name] == value
    for name in ('model', 'observer'):
        assert not set_parameter(estimator, name, 'ekf').successful


def test_initial_values_are_a_start_of_the_next_window(ros, monkeypatch):
    starts = []
    fit = Solver.fit

    def spy(self, window, problem, rng, deadline, warm):
        starts.append(None if warm is None else self.unknowns.values(warm[None])[0][:, 0].tolist())
        return fit(self, window, problem, rng, deadline, warm)

    monkeypatch.setattr(Solver, 'fit', spy)
    bench = Bench(ros, monkeypatch)
    messages = run()
    bench.play(messages[:124])
    assert starts == [None]
    changes = {'initial.h1': 51.0, 'initial.h2': 42.0, 'initial.h3': 47.0}
    answer = bench.estimator.set_parameters_atomically(
        [Parameter(name, value=value) for name, value in changes.items()]
    )
    assert answer.successful
    ros.spin_until(lambda: bench.estimator.estimation.progress.ready)
    bench.play(messages[124:])
    assert starts[1] == pytest.approx([51.0, 42.0, 47.0])
    assert [estimate.t1 for estimate, _ in bench.concluded] == [60.0, 120.0, 180.0]
    assert not set_parameter(bench.estimator, 'fixed.h1', 50.0).successful, (
        'it has an initial value'
    )


def test_a_model_that_diverges_is_withheld(ros, monkeypatch):
    names = {'model': 'plants:BLOW_UP', 'bounds__x': [3.9, 4.0]}
    bench = Bench(ros, monkeypatch, window__duration=2.0, streams=('output',), **names)
    bench.play([Message('output', 0.1 * k, ('y',), (4.0 + 0.01 * (k % 3),)) for k in range(25)])
    message, told = bench.told('diverged')
    assert 'withheld' in message and told['withheld'] == '1' and not bench.parameters


@pytest.mark.slow
@pytest.mark.parametrize('full', [True, False], ids=['disk full', 'no folder'])
def test_where_no_kernel_can_be_stored_it_runs_and_says_so(tmp_path, full):
    folder = tmp_path / 'cache' if full else Path(os.devnull) / 'cache'
    script = UNSTORED.format(limit='resource.RLIMIT_FSIZE, (20_000, 20_000)' if full else '')
    environment = {**os.environ, 'OBS_ROS_CACHE': str(folder),
                   'PYTHONPATH': os.pathsep.join(sys.path)}  # fmt: skip
    ended = subprocess.run(
        [sys.executable, '-c', script],
        env=environment,
        capture_output=True,
        text=True,
        timeout=patience(60.0),
    )
    assert ended.returncode == 0, ended.stderr
    outcome, trouble = ended.stdout.splitlines()
    assert outcome == 'converged'
    assert 'compiling in every process' in trouble and str(folder) in trouble


UNSTORED = """
import resource
from plants import VESSEL
import numpy as np
from obs_ros import Record, solve_window
from obs_ros.core.kernel_cache import cache_trouble
limits = ({limit})
if limits:
    resource.setrlimit(*limits)
t = np.arange(0.0, 30.0)
u = np.where(t % 10 < 5, 1.0, 0.0)
x = np.concatenate([[2.0], 2.0 + np.cumsum(0.5 - u[:-1])])
y = x + 0.3 * u + 0.01 * np.random.default_rng(0).standard_normal(30)
print(solve_window(VESSEL, Record(t, u, y), noise={{'y': 0.01}}).outcome)
print(cache_trouble())
"""
