"""A fleet: estimators of many plants in one process, each as if it were alone."""

import math
import sys

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from node.fakes import FakeObserver
from patience import patience
from plants import tank_outputs
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile
from ros import figures, set_parameter, vector
from sensor_msgs.msg import JointState

from obs_ros.ros import fleet
from obs_ros.ros.fleet import Fleet
from obs_ros.ros.messages import named_vector
from obs_ros.ros.paced_executor import PacedExecutor

FAKE = 'node.fakes:FakeObserver'
LEVELS, FEEDS = ('h1', 'h2'), ('Q1', 'Q2')
EIGHT = tuple(f'/line/p{k}' for k in range(8))
WINDOW = 20  # samples, s
TRUTH = {'p1': 0.6, 'p2': 0.5, 'p3': 0.7}


class Line:
    """A fleet in an executor of its own, and publishers for each of its plants."""

    def __init__(self, ros, *cli, **parameters):
        self.ros = ros
        overrides = [Parameter(k.replace('__', '.'), value=v) for k, v in parameters.items()]
        self.fleet = Fleet(context=ros.context, parameter_overrides=overrides, cli_args=[*cli])
        self.executor = PacedExecutor(context=ros.context)
        for node in self.fleet.nodes:
            self.executor.add_node(node)
        self.publishers = {}
        self.sent = {}

    def until(self, predicate):
        def spun():
            self.executor.spin_once(0.02)
            return predicate()

        return self.ros.spin_until(spun, 30.0)

    def connect(self, *plants):
        for plant in plants:
            self.publishers[plant] = [
                self.ros.node.create_publisher(
                    JointState, f'{plant}/plant/{stream}', QoSProfile(depth=5000)
                )
                for stream in ('input', 'output')
            ]
            self.sent.setdefault(plant, 0)
        self.until(
            lambda: all(p.get_subscription_count() for q in plants for p in self.publishers[q])
        )

    def disconnect(self, plant):
        for publisher in self.publishers.pop(plant):
            self.ros.node.destroy_publisher(publisher)

    def change(self, *plants):
        """Set `plants`, and wait until these run and no others."""
        assert set_parameter(self.fleet, 'plants', [*plants] or ['']).successful
        self.until(lambda: [*self.fleet.estimators] == [*plants])

    def send(self, plant, t, levels, feeds=(30.0, 30.0)):
        for publisher, names, values in zip(
            self.publishers[plant], (FEEDS, LEVELS), (feeds, levels), strict=True
        ):
            publisher.publish(named_vector(round(t * 1e9), names, values))
        self.sent[plant] += 1

    def received(self, plant):
        streams = self.fleet.estimators[plant].estimation.streams.subscriptions.values()
        return min(each.received for each in streams)

    def close(self):
        self.ros.spin_until(self.fleet.close)
        self.executor.shutdown()
        self.fleet.destroy_node()


@pytest.fixture
def line(ros):
    """A function that starts the fleet."""
    lines = []

    def line(*cli, **parameters):
        lines.append(Line(ros, *cli, **parameters))
        return lines[-1]

    yield line
    for each in lines:
        each.close()


def fake(line, plants=('/a', '/b'), **more):
    made = line(plants=list(plants), observer=FAKE, window__duration=2.0, **more)
    made.until(
        lambda: all(each.estimation.progress.ready for each in made.fleet.estimators.values())
    )
    return made


def test_each_plant_has_the_topics_parameters_and_services_of_an_estimator(ros, line):
    fleet = fake(line, deadline=0.5)
    names = [node.get_fully_qualified_name() for node in fleet.fleet.nodes]
    assert names == ['/fleet', '/a/estimator', '/b/estimator']
    heard = {plant: [] for plant in ('/a', '/b')}
    for plant, messages in heard.items():
        ros.node.create_subscription(JointState, f'{plant}/estimator/state', messages.append, 10)
    fleet.connect('/a', '/b')
    for t in (1.0, 2.0):
        fleet.send('/a', t, (t, t))
    fleet.until(lambda: heard['/a'])
    assert vector(heard['/a'][0]) == {'h1': 2.0, 'h2': 2.0, 'h3': 2.0}
    assert heard['/b'] == []
    for node in fleet.fleet.estimators.values():
        assert node.get_parameter('deadline').value == 0.5
        assert not node.has_parameter('plants') and not node.has_parameter('workers')
    assert not fleet.fleet.has_parameter('deadline')


def test_a_file_gives_parameters_to_all_plants_and_to_one(tmp_path, line):
    path = tmp_path / 'fleet.yaml'
    path.write_text(
        f"/**:\n  ros__parameters:\n    plants: ['/a', '/b', '/c']\n    observer: {FAKE}\n"
        '    window: {duration: 2.0}\n'
        '/b/estimator:\n  ros__parameters:\n    window: {duration: 4.0}\n'
        '/c/estimator:\n  ros__parameters:\n    observer: ekf\n'
    )
    estimators = line('--ros-args', '--params-file', str(path)).fleet.estimators
    durations = [estimators[p].get_parameter('window.duration').value for p in ('/a', '/b')]
    assert durations == [2.0, 4.0]
    assert estimators['/c'].get_parameter('observer').value == 'ekf'


def test_plants_come_and_go_while_the_others_run(line):
    fleet = fake(line)
    old = fleet.fleet.estimators['/a']
    fleet.change('/b', '/c/d', '/e')
    assert old.context.ok() and old not in fleet.executor.get_nodes()
    fleet.until(lambda: fleet.fleet.estimators['/e'].estimation.progress.ready)
    fleet.connect('/e')
    for t in (1.0, 2.0):
        fleet.send('/e', t, (t, t))
    fleet.until(lambda: fleet.fleet.estimators['/e'].estimation.progress.published == 1)
    fleet.change()
    assert fleet.fleet.nodes == [fleet.fleet]


def test_a_plant_whose_solve_goes_on_can_be_ended(line):
    fleet = fake(line)
    fleet.connect('/a')
    held = next(
        f for f in FakeObserver.made[::-1] if f is fleet.fleet.estimators['/a'].estimation.observer
    )
    held.go.clear()
    for t in (1.0, 2.0):
        fleet.send('/a', t, (t, t))
    fleet.until(lambda: fleet.fleet.estimators['/a'].estimation.lag is not None)
    fleet.change('/b')
    held.go.set()
    fleet.connect('/b')
    for t in (1.0, 2.0):
        fleet.send('/b', t, (t, t))
    fleet.until(lambda: fleet.fleet.estimators['/b'].estimation.progress.published == 1)


def test_a_folder_has_a_file_for_each_plant_that_it_takes_up_when_it_comes_back(tmp_path, line):
    fleet = line(
        plants=['/a', '/b'], observer='node.fakes:RememberingFake', window__duration=2.0,
        checkpoint=str(tmp_path),
    )  # fmt: skip
    estimators = fleet.fleet.estimators
    fleet.until(lambda: all(each.estimation.progress.ready for each in estimators.values()))
    fleet.connect('/a', '/b')
    for t in (1.0, 2.0):
        fleet.send('/a', t, (t, t))
    fleet.until((tmp_path / 'a.estimator.checkpoint').exists)
    assert not (tmp_path / 'b.estimator.checkpoint').exists()
    fleet.change('/b')
    fleet.change('/b', '/a')
    assert fleet.fleet.refused == {}
    assert estimators['/a'].estimation.observer.before == 2
    assert estimators['/b'].estimation.observer.before == 0


def test_one_file_is_not_for_two_plants(tmp_path, line):
    fleet = line(
        plants=['/a', '/b'], observer='node.fakes:RememberingFake', window__duration=2.0,
        checkpoint=str(tmp_path / 'tank'),
    )  # fmt: skip
    assert list(fleet.fleet.estimators) == ['/a']
    assert 'give each node a file of its own, or name a folder' in fleet.fleet.refused['/b']


@pytest.mark.parametrize(
    ('names', 'reason'),
    [
        (['/a', '/a'], "'/a' stands twice"),
        (['a'], "name each as '/line1/tank_a'"),
        ([f'/p{k}' for k in range(257)], 'start a second fleet'),
    ],
)
def test_wrong_names_are_refused_and_nothing_changes(line, names, reason):
    fleet = fake(line)
    refused = set_parameter(fleet.fleet, 'plants', names)
    assert not refused.successful and reason in refused.reason
    assert [*fleet.fleet.estimators] == ['/a', '/b']
    with pytest.raises(ValueError, match=reason):
        line(plants=names)


def test_workers_are_for_the_start_only(line):
    fleet = fake(line)
    assert not set_parameter(fleet.fleet, 'workers', 5).successful
    assert not set_parameter(fleet.fleet.estimators['/a'], 'model', 'pendulum').successful


def test_one_plant_that_cannot_start_is_told_and_harms_no_other(ros, tmp_path, line):
    path = tmp_path / 'fleet.yaml'
    path.write_text('/b/estimator:\n  ros__parameters:\n    deadline: -1.0\n')
    fleet = line('--ros-args', '--params-file', str(path), plants=['/a', '/b'], observer=FAKE)
    assert [*fleet.fleet.estimators] == ['/a']
    told = fleet.fleet.refused['/b']
    assert told == '/b: deadline must be > 0, <= 3600 s, not -1.0'
    names = [name for name, space in fleet.fleet.get_node_names_and_namespaces() if space == '/b']
    assert names == []


def test_where_none_can_start_there_is_no_fleet(line):
    with pytest.raises(ValueError, match='/a: unknown model'):
        line(plants=['/a', '/b'], model='nix')


def test_a_remap_that_would_give_all_plants_one_name_is_refused(line):
    with pytest.raises(ValueError, match='take __ns away'):
        line('--ros-args', '-r', '__ns:=/x', plants=['/a', '/b'], observer=FAKE)


def test_the_health_of_the_fleet(ros, line):
    fleet = fake(line, workers=3)
    statuses = []
    fleet.executor.add_node(ros.node)
    ros.node.create_subscription(
        DiagnosticArray, '/diagnostics', lambda m: statuses.append(m.status[0]), 100
    )

    def newest(**wanted):
        for status in statuses:
            if status.name == '/fleet' and wanted.items() <= figures(status).items():
                return status
        return None

    told = fleet.until(lambda: newest(plants='2', workers='3'))
    assert told.level == b'\x00' and told.message.startswith('2 plants, the slowest')
    assert {s.name for s in statuses} <= {'/fleet', '/a/estimator', '/b/estimator'}
    fleet.fleet.estimators['/b'].estimation.observer.skipped = 2
    told = fleet.until(lambda: newest(skipped='2'))
    assert told.level == b'\x01' and 'windows skipped: give it more workers' in told.message
    assert figures(told)['skipped./b'] == '2'


def test_plants_that_misbehave_harm_no_other(tmp_path, line):
    """One floods, one sends NaN, one raises, one is killed and comes again: the others go on."""
    flooding, silent, raising, killed, *others = EIGHT
    path = tmp_path / 'fleet.yaml'
    path.write_text(f'{raising}/estimator:\n  ros__parameters:\n    observer: {FAKE}\n')
    fleet = line(
        '--ros-args', '--params-file', str(path), plants=[*EIGHT], noise__h1=0.01, noise__h2=0.01,
        window__duration=float(WINDOW), deadline=patience(5.0), stale_after=patience(60.0),
    )  # fmt: skip
    estimators = fleet.fleet.estimators
    estimators[raising].estimation.observer.value = RuntimeError('the number of the beast')
    fleet.connect(*EIGHT)
    fleet.until(lambda: all(each.estimation.progress.ready for each in estimators.values()))
    rng, windows = np.random.default_rng(0), 4
    t = np.arange(0.0, windows * WINDOW + 1.0)
    levels = tank_outputs(t, (50.0, 40.0, 45.0), tuple(TRUTH.values()))
    measured = levels + 0.01 * rng.standard_normal((t.size, 2))
    for k, level in enumerate(measured.tolist()):
        for plant in (*others, raising):
            fleet.send(plant, float(k), level)
        fleet.send(silent, float(k), (math.nan, math.nan))
        for i in range(100):  # to the 10 Hz of the others 1 kHz
            fleet.send(flooding, k + i / 100, level)
        if k == WINDOW + 5:
            fleet.disconnect(killed)
        if k == 2 * WINDOW:
            fleet.connect(killed)
        if killed in fleet.publishers:
            fleet.send(killed, float(k), level)
        if k and k % WINDOW == 0:
            fleet.until(lambda n=k // WINDOW: all(
                estimators[p].estimation.progress.published == n for p in others
            ))  # fmt: skip
    fleet.until(lambda: all(fleet.received(p) == fleet.sent[p] for p in EIGHT))
    for plant in others:
        progress, counts = (
            estimators[plant].estimation.progress,
            estimators[plant].estimation.observer.counts,
        )
        assert (progress.published, progress.failed) == (windows, 0)
        assert {name: n for name, n in counts.items() if n} == {}
        found = progress.estimate.parameters
        assert found == pytest.approx(TRUTH, abs=0.2)
    assert estimators[silent].estimation.progress.published == 0
    assert (
        sum(estimators[silent].estimation.observer.counts.values()) == t.size
    )  # one reason for each
    assert estimators[raising].estimation.progress.failed > 0
    assert (
        estimators[raising].estimation.progress.error == "RuntimeError('the number of the beast')"
    )
    assert estimators[killed].estimation.progress.published >= 2
    assert fleet.received(flooding) == 100 * t.size


def test_solves_get_their_turn_beside_busy_callbacks(monkeypatch):
    seen = []
    before = sys.getswitchinterval()
    monkeypatch.setattr(fleet, 'run', lambda *_, **__: seen.append(sys.getswitchinterval()) or 0)
    try:
        assert fleet.main() == 0
    finally:
        sys.setswitchinterval(before)
    assert seen == [pytest.approx(fleet.TURN, rel=0.01)] and before > fleet.TURN
