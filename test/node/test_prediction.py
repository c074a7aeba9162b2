"""~/prediction: the state now, between the windows."""

import numpy as np
import pytest
from horizon.test_disturbance import INTERVAL, SIGMA, record
from node.test_faults import FEEDS, LEVELS, NOISE, X0, Bench, Message
from plants import tank_outputs
from ros import set_parameter, vector

P = (0.6, 0.5, 0.7)


def tanks(first, last):
    """Messages from `first` to `last` (s) without noise, and the levels h1, h2 (K, 2)."""
    levels = tank_outputs(np.arange(0.0, last + 1.0), X0, P)
    messages = [
        message
        for t in range(first, last + 1)
        for message in (
            Message('input', float(t), FEEDS, (30.0, 30.0)),
            Message('output', float(t), LEVELS, tuple(levels[t].tolist())),
        )
    ]
    return messages, levels


def test_between_windows_the_state_is_carried_to_every_output(ros, monkeypatch):
    bench = Bench(ros, monkeypatch)
    predictions, states = ros.listen('/estimator/prediction'), ros.listen('/estimator/state')
    bench.play(tanks(0, 60)[0])
    ros.spin_until(lambda: states)
    messages, levels = tanks(61, 119)
    bench.play(messages)
    ros.spin_until(lambda: len(predictions) == 59)
    assert [m.header.stamp.sec for m in predictions] == list(range(61, 120))
    assert len(states) == 1 and states[0].header.stamp.sec == 60
    for message in predictions:
        state = vector(message)
        truth = levels[message.header.stamp.sec]
        assert [state['h1'], state['h2']] == pytest.approx(truth.tolist(), abs=1e-3)
    _, told = bench.told('converged')
    assert told['predicted'] == '59' and float(told['prediction_horizon_s']) == 59.0
    assert 0.0 < float(told['prediction_latency_s']) < 5.0


def test_where_process_noise_is_known_outputs_correct_the_prediction(ros, monkeypatch):
    long, last = record(700), 399
    bench = Bench(
        ros, monkeypatch, model='plants:LAG', process_noise='auto',
        window__duration=INTERVAL * last,
    )  # fmt: skip
    topics = ('prediction', 'prediction_stddev', 'residual')
    predictions, stddevs, residuals = (ros.listen(f'/estimator/{topic}') for topic in topics)
    messages = [
        message
        for t, u, y in zip(long.t, long.u, long.y, strict=True)
        for message in (Message('input', t, ('u',), u), Message('output', t, ('y',), y))
    ]
    bench.play(messages[: 2 * last + 2])
    ros.spin_until(lambda: bench.concluded)
    assert bench.concluded[0][0].walks['x'] > 0.0
    bench.play(messages[2 * last + 2 :])
    ros.spin_until(lambda: len(residuals) == 300)
    outputs = [round(1e9 * t) for t in long.t[last + 1 :]]
    for heard, name in ((predictions, 'x'), (stddevs, 'x'), (residuals, 'y')):
        assert {tuple(m.name) for m in heard} == {(name,)}
        assert [1e9 * m.header.stamp.sec + m.header.stamp.nanosec for m in heard] == outputs
    # As deviations foretell: in open loop they would be a dozen times as large.
    scaled = np.array([m.position[0] / m.effort[0] for m in residuals])
    assert scaled.std() == pytest.approx(1.0, abs=0.15)
    off = np.array([m.position[0] for m in predictions]) - long.y[last + 1 :, 0]
    assert off.std() < SIGMA and {m.position[0] < SIGMA for m in stddevs} == {True}


def test_the_rate_of_predictions_and_whether_there_are_any_change_live(ros, monkeypatch):
    bench = Bench(ros, monkeypatch, prediction__rate=0.1)
    predictions, states = ros.listen('/estimator/prediction'), ros.listen('/estimator/state')
    bench.play(tanks(0, 60)[0])
    ros.spin_until(lambda: states)
    bench.play(tanks(61, 100)[0])
    ros.spin_until(lambda: predictions and predictions[-1].header.stamp.sec == 91)
    assert [m.header.stamp.sec for m in predictions] == [61, 71, 81, 91]
    assert set_parameter(bench.estimator, 'prediction.enabled', False).successful
    bench.play(tanks(101, 125)[0])
    ros.spin_until(lambda: len(states) == 2)
    assert set_parameter(bench.estimator, 'prediction.enabled', True).successful
    assert set_parameter(bench.estimator, 'prediction.rate', 0).successful
    ros.spin_until(lambda: bench.estimator.estimation.idle)
    bench.play(tanks(126, 190)[0])
    # Begun anew, it waits for the next estimate, which did not take another observer.
    ros.spin_until(lambda: len(states) == 3 and predictions[-1].header.stamp.sec == 190)
    assert min(m.header.stamp.sec for m in predictions[4:]) > 180


def test_a_stream_that_stops_ends_predictions(ros, monkeypatch):
    bench = Bench(ros, monkeypatch, stale_after=0.3, **NOISE)
    predictions, states = ros.listen('/estimator/prediction'), ros.listen('/estimator/state')
    bench.play(tanks(0, 60)[0])
    ros.spin_until(lambda: states)
    ros.spin_until(lambda: bench.estimator.estimation.stale)
    bench.send([m for m in tanks(61, 80)[0] if m.stream == 'output'])
    _, told = bench.told('stale_input')
    assert told['predicted'] == '0' and not predictions
