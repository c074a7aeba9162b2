"""The estimator with observers that take their step in the callback."""

import math

import numpy as np
import pytest
from arx import course, pushes
from node.fakes import FakeImmediate
from plants import tank_outputs
from ros import figures, set_parameter, vector

from obs_ros.ros.estimator import Estimator

FAKE = 'node.fakes:FakeImmediate'
LEVELS, FEEDS = ('h1', 'h2'), ('Q1', 'Q2')


class Bench:
    """An estimator with an immediate observer, and what it says."""

    def __init__(self, ros, observer=FAKE, **parameters):
        self.estimator = ros.start(Estimator, observer=observer, **parameters)
        self.state = ros.listen('/estimator/state')
        self.state_stddev = ros.listen('/estimator/state_stddev')
        self.solver = ros.listen('/estimator/solver')
        self.output = ros.speak('/plant/output')
        self.input = ros.speak('/plant/input')


@pytest.fixture
def bench(ros):
    FakeImmediate.go.set()
    bench = Bench(ros)
    ros.spin_until(lambda: bench.estimator.estimation.progress.ready)
    return bench


def test_every_output_is_answered_with_an_estimate_and_the_observers_figures(ros, bench):
    bench.input(1, FEEDS, (30, 30))
    ros.spin_until(lambda: bench.estimator.estimation.streams.subscriptions['input'].received)
    for t in range(1, 21):
        bench.output(t, LEVELS, (t, -t))
    ros.spin_until(lambda: len(bench.state) == 20 and len(bench.solver) == 20)
    assert [m.header.stamp.sec for m in bench.state] == list(range(1, 21))
    assert [m.position[0] for m in bench.state] == list(range(1, 21))
    assert vector(bench.state_stddev[0])['h1'] == 0.25
    assert math.isnan(vector(bench.state_stddev[0])['h2'])
    assert vector(bench.solver[0])['gain'] == 0.5
    assert figures(ros.health(outcome='converged'))['published'] == '20'


def test_samples_that_come_while_it_compiles_are_counted_and_not_taken(ros):
    FakeImmediate.go.clear()
    bench = Bench(ros)
    for t in (1, 2, 3):
        bench.output(t, LEVELS, (t, t))
    ros.spin_until(lambda: bench.estimator.estimation.progress.too_early == 3)
    assert not bench.state
    FakeImmediate.go.set()
    ros.spin_until(lambda: bench.estimator.estimation.progress.ready)
    bench.input(4, FEEDS, (30, 30))
    ros.spin_until(lambda: bench.estimator.estimation.streams.subscriptions['input'].received)
    bench.output(5, LEVELS, (5, 5))
    ros.spin_until(lambda: bench.state)
    assert [m.header.stamp.sec for m in bench.state] == [5]
    assert figures(ros.health(outcome='converged'))['too_early'] == '3'


def test_an_exception_in_a_step_is_told_and_survived(ros, bench):
    bench.input(1, FEEDS, (30, 30))
    ros.spin_until(lambda: bench.estimator.estimation.streams.subscriptions['input'].received)
    bench.output(1, LEVELS, (666, 0))
    status = ros.health(outcome='failed')
    assert 'the number of the beast' in status.message
    bench.input(2, FEEDS, (30, 30))
    ros.spin_until(lambda: bench.estimator.estimation.streams.subscriptions['input'].received == 2)
    bench.output(2, LEVELS, (2, 0))
    ros.spin_until(lambda: bench.state)
    assert figures(ros.health(outcome='converged'))['failed'] == '1'


def test_its_settings_are_parameters_and_those_of_windows_are_not(ros, bench):
    prefix = 'FakeImmediate'
    node = bench.estimator
    assert node.get_parameter(f'{prefix}.gain').value == 0.5
    assert list(node.get_parameter(f'{prefix}.table').value) == [1.0, 2.0]
    assert not any(node.has_parameter(n) for n in ('window.duration', 'search.method', 'deadline'))
    for name, value, reason in (
        ('gain', 1.5, 'FakeImmediate.gain must be 0 to 1, not 1.5'),
        ('mode', 'fany', "unknown FakeImmediate.mode 'fany': did you mean 'fancy'?"),
        ('table', [1.0], 'FakeImmediate.table must have 2 entries, not 1'),
    ):
        answer = set_parameter(node, f'{prefix}.{name}', value)
        assert not answer.successful and reason in answer.reason
    assert set_parameter(node, f'{prefix}.gain', 1).successful
    assert set_parameter(node, 'initial.h3', 20.0).successful
    made = FakeImmediate.made[-1]
    assert made.settings.gain == 1.0 and made.initial[2] == 20.0


def test_the_kalman_filter_follows_three_tanks_live(ros):
    bench = Bench(ros, 'ekf', noise__h1=0.01, noise__h2=0.01, fixed__p1=0.6, fixed__p3=0.7)
    ros.spin_until(lambda: bench.estimator.estimation.progress.ready, timeout=60.0)
    levels = tank_outputs(np.arange(100.0), (50.0, 40.0, 45.0), (0.6, 0.5, 0.7))
    for t, (h1, h2) in enumerate(levels):
        bench.input(t, FEEDS, (30, 30))
        bench.output(t, LEVELS, (h1, h2))
    ros.spin_until(lambda: bench.state and bench.state[-1].header.stamp.sec == 99)
    assert vector(bench.state[-1])['h1'] == pytest.approx(levels[-1, 0], abs=0.05)
    assert 0.0 < vector(bench.state_stddev[-1])['h3'] < 1.0


def test_a_model_that_does_not_suit_is_refused_at_start(ros):
    with pytest.raises(ValueError, match='observer form'):
        ros.start(Estimator, observer='adaptive_luenberger')


@pytest.mark.parametrize(
    ('observer', 'model', 'figures_of_its_own'),
    [
        ('gao', 'linear_second_order', {'generation', 'best_fitness', 'L1', 'L2', 'frozen'}),
        ('gase', 'observer_form_third_order', {'generation', 'cost'}),
    ],
)
def test_the_genetic_observers_tell_how_their_search_goes(ros, observer, model, figures_of_its_own):
    bench = Bench(ros, observer, model=model)
    ros.spin_until(lambda: bench.estimator.estimation.progress.ready, timeout=60.0)
    for k in range(1, 4):
        bench.input(k, ('u',), (1.0,))
        ros.spin_until(
            lambda k=k: bench.estimator.estimation.streams.subscriptions['input'].received == k
        )
        bench.output(k, ('x1',), (0.5,))
        ros.spin_until(lambda k=k: len(bench.solver) == k)
    told = [vector(message) for message in bench.solver]
    assert figures_of_its_own <= set(told[-1])
    assert all(math.isfinite(told[-1][name]) for name in figures_of_its_own)
    bred = {'gao': 1.0, 'gase': 10.0}[observer]  # generations for a sample
    assert told[-1]['generation'] - told[-2]['generation'] == bred


def test_a_discrete_model_is_filtered_at_its_nodes_and_counts_what_lies_between(ros, monkeypatch):
    monkeypatch.setenv('OBS_ROS_BACKEND', 'numpy')  # nothing to compile for a few steps
    bench = Bench(ros, observer='ekf', model='arx:ARX', noise__y=0.02, merge_wait=0.0)
    ros.spin_until(lambda: bench.estimator.estimation.progress.ready)
    states, y = course(u := pushes(12))
    for k, off in enumerate([0.0, 0.003, -0.004, 0.0, 0.0, 0.03, 0.0, 0.002, 0.0, 0.0, 0.0, 0.0]):
        bench.input(1.0 + 0.1 * k, ('u',), (u[k],))
        ros.spin_until(
            lambda k=k: bench.estimator.estimation.streams.subscriptions['input'].received == k + 1
        )
        bench.output(1.0 + 0.1 * k + off, ('y',), (y[k],))
        heard = k + 1
        ros.spin_until(
            lambda n=heard: bench.estimator.estimation.streams.subscriptions['output'].received == n
        )
    ros.spin_until(lambda: len(bench.state) == 11)
    stamps = [m.header.stamp.sec + 1e-9 * m.header.stamp.nanosec for m in bench.state]
    nodes = [k for k in range(12) if k != 5]
    assert stamps == pytest.approx([1.0 + 0.1 * k for k in nodes], abs=1e-6)
    assert vector(bench.state[-1])['now'] == pytest.approx(states[11, 0], abs=0.1)
    health = figures(ros.health(outcome='converged'))
    assert health['samples.off_grid'] == '1' and health['samples.late'] == '0'
