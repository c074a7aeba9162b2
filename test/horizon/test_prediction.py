"""Predictions against the plant's own solution."""

from dataclasses import replace

import numpy as np
import pytest
from arx import ARX, A, B, course, pushes, samples
from plants import VESSEL, tank_outputs, with_interpolation

from obs_ros.core.estimate import Estimate, Outcome
from obs_ros.core.model import names
from obs_ros.core.record import Sample
from obs_ros.horizon.prediction import Prediction, PredictionSettings
from obs_ros.inference.innovation_gate import InnovationGateSettings
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.models.three_tank import THREE_TANK
from obs_ros.samples.gate import GateSettings

S = 10**9


def estimate(model, t, state, parameters=()):
    state = dict(zip(names(model.states), state))
    return Estimate(
        parameters=dict(zip(names(model.parameters), parameters)), initial_state=state, state=state,
        stddev={}, outcome=Outcome.CONVERGED, message='', t0=0.0, t1=t, stamp=round(t * S),
    )  # fmt: skip


def vessel(load=0.5):
    """x' = d - u: the state is a sum of the inputs held."""
    return lambda t, x: estimate(VESSEL, t, (x,), (load, 0.0))


def absorb(prediction, *samples):
    return [
        prediction.absorb(Sample(round(t * S), **{kind: np.array([float(value)])}))
        for t, kind, value in samples
    ]


@pytest.fixture
def prediction():
    return Prediction(VESSEL)


def test_there_is_none_before_an_estimate(prediction):
    assert absorb(prediction, (0, 'u', 1), (0, 'y', 0), (1, 'y', 0)) == [None] * 3
    assert prediction.now() is None


def test_it_goes_on_from_the_estimate_under_the_inputs_since(prediction):
    absorb(prediction, (0, 'u', 1), (0, 'y', 0), (1, 'y', 0), (1.5, 'u', 3), (2, 'y', 0))
    prediction.start(vessel()(1.0, 10.0))
    # From 1 to 1.5 x' = 0.5 - 1, to 2 it is 0.5 - 3.
    assert prediction.now().state == {'x': pytest.approx(10.0 - 0.25 - 1.25)}
    assert absorb(prediction, (4, 'y', 0)) == [4 * S]
    assert prediction.now().state == {'x': pytest.approx(8.5 - 5.0)}
    assert prediction.now().state == {'x': pytest.approx(8.5 - 5.0)}, 'no time has passed'


def test_an_estimate_between_two_outputs_is_carried_from_there(prediction):
    absorb(prediction, (0, 'u', 1), (0, 'y', 0), (1.5, 'u', 3), (1.8, 'u', 0), (2, 'y', 0))
    prediction.start(vessel()(1.6, 10.0))
    assert prediction.now().state == {'x': pytest.approx(10.0 - 2.5 * 0.2 + 0.5 * 0.2)}


def test_linear_inputs_are_cut_where_they_are():
    prediction = Prediction(with_interpolation(VESSEL, 'linear'))
    absorb(prediction, (0, 'u', 0), (0, 'y', 0), (4, 'u', 4), (4, 'y', 0))
    prediction.start(vessel(0.0)(1.0, 10.0))
    assert prediction.now().state == {'x': pytest.approx(10.0 - (16.0 - 1.0) / 2.0)}


def test_known_delays_put_inputs_and_outputs_at_their_own_times():
    model = replace(
        VESSEL,
        inputs=[replace(v, delay=0.5) for v in VESSEL.inputs],
        outputs=[replace(v, delay=2.0) for v in VESSEL.outputs],
    )
    prediction = Prediction(model)
    # Acting from 0.5 and 1.5 s on; measured at 1 and 2 s.
    samples = (0, 'u', 1), (1, 'u', 3), (3, 'y', 0), (4, 'y', 0)
    assert absorb(prediction, *samples) == [None] * 4
    prediction.start(vessel()(1.0, 10.0))
    assert prediction.now().stamp == 2 * S
    assert prediction.now().state == {'x': pytest.approx(10.0 - 0.25 - 1.25)}
    assert absorb(prediction, (6, 'y', 0)) == [4 * S]
    assert prediction.now().state == {'x': pytest.approx(8.5 - 5.0)}


def test_samples_after_an_estimate_are_shifted_by_the_delays_that_it_tells():
    model = replace(
        VESSEL,
        inputs=[replace(v, delay=(0.0, 1.0)) for v in VESSEL.inputs],
        outputs=[replace(v, delay=(0.0, 3.0)) for v in VESSEL.outputs],
    )
    prediction = Prediction(model)
    absorb(prediction, (0, 'u', 1), (0, 'y', 0), (1, 'y', 0), (2, 'y', 0), (3, 'y', 0))
    prediction.start(estimate(model, 3.0, (10.0,), (0.5, 0.0, 0.5, 2.0)))
    assert prediction.now().stamp == 3 * S and prediction.now().state == {'x': 10.0}
    # Acting from 4.5 s on; measured at 2, 4 and 6 s.
    absorb(prediction, (4, 'u', 3), (4, 'y', 0), (6, 'y', 0), (8, 'y', 0))
    now = prediction.now()
    assert now.stamp == 6 * S
    assert now.state == {'x': pytest.approx(10.0 - 0.5 * 1.5 - 2.5 * 1.5)}


def test_a_newer_estimate_takes_over(prediction):
    absorb(prediction, (0, 'u', 1), *((t, 'y', 0) for t in range(10)))
    prediction.start(vessel()(2.0, 10.0))
    assert prediction.now().state == {'x': pytest.approx(10.0 - 3.5)}
    prediction.start(vessel(1.0)(7.0, 5.0))
    assert prediction.now().state == {'x': pytest.approx(5.0)}
    assert prediction.since == 7 * S


def test_one_that_is_not_usable_or_too_old_ends_it(prediction):
    absorb(prediction, (5, 'u', 1), *((t, 'y', 0) for t in range(5, 9)))
    for wrong in (
        vessel()(7.0, np.nan),
        vessel()(4.0, 1.0),
        replace(vessel()(7.0, 1.0), stamp=None),
    ):
        prediction.start(vessel()(7.0, 1.0))
        assert prediction.now() is not None
        prediction.start(wrong)
        assert prediction.now() is None and absorb(prediction, (8.5, 'y', 0)) == [None]


def test_what_diverges_is_withheld_and_counted(prediction):
    absorb(prediction, (0, 'u', 1), (0, 'y', 0))
    prediction.start(vessel(1e308)(0.0, 1e308))
    absorb(prediction, (5, 'y', 0))
    assert prediction.now() is None and prediction.diverged == 1
    absorb(prediction, (6, 'y', 0))
    assert prediction.now() is None and prediction.diverged == 1


def test_a_new_timeline_ends_it(prediction):
    absorb(prediction, (1000, 'u', 1), (1000, 'y', 0))
    prediction.start(vessel()(1000.0, 1.0))
    back = [(t, kind, 0) for t in range(5) for kind in 'uy']
    absorb(prediction, *back)
    assert prediction.now() is None


def test_a_stray_stamp_is_not_predicted_to(prediction):
    absorb(prediction, (0, 'u', 1), (0, 'y', 0), (1, 'y', 0))
    prediction.start(vessel()(1.0, 1.0))
    assert absorb(prediction, (1e9, 'y', 0)) == [None]
    assert prediction.now().state == {'x': 1.0}


def test_it_keeps_up_where_nobody_asks(prediction):
    most = PredictionSettings().at_once
    absorb(prediction, (0, 'u', 1), (0, 'y', 0))
    prediction.start(vessel()(0.0, 0.0))
    absorb(prediction, *((0.1 * k, 'y', 0) for k in range(1, 2 * most)))
    assert prediction.now().state == {'x': pytest.approx(-0.5 * 0.1 * (2 * most - 1))}


def pushed(t, x, sd=0.1):
    """An estimate of the vessel, load 0.5, that process noise explains."""
    return replace(
        estimate(VESSEL, t, (x,), (0.5, 0.0)), covariance=np.diag([sd, 0.01, 0.0]) ** 2,
        walks={'x': 0.2, 'd': 0.0, 'g': 0.0}, noise={'y': 0.1},
    )  # fmt: skip


@pytest.mark.parametrize('stamp', [1.0, 1.6])
def test_an_estimate_that_comes_late_is_corrected_by_the_outputs_since(stamp):
    early, late = ungated(Prediction(VESSEL)), ungated(Prediction(VESSEL))
    outputs = [(t, 'y', 0.3 * t) for t in range(2, 8)]
    for each in (early, late):
        absorb(each, (0, 'u', 1), (0, 'y', 0), (1, 'y', 0), (1.3, 'u', 2))
    if stamp > 1.0:  # known as soon as there is an interval that holds it
        absorb(early, outputs.pop(0))
        absorb(late, (2, 'y', 0.6))
    early.start(pushed(stamp, 0.0))
    absorb(early, *outputs)
    absorb(late, *outputs)
    late.start(pushed(stamp, 0.0))
    assert early.now() == late.now()
    state = early.now().state['x']
    assert abs(state - 2.1) < 0.5 < abs(vessel_alone(stamp) - 2.1)
    assert early.now().stddev['x'] < 0.12


def ungated(prediction):
    """The prediction, corrected by outputs however far they lie from what it expects."""
    prediction.limit(GateSettings(), innovations=InnovationGateSettings(limit=0.0))
    return prediction


def vessel_alone(stamp):
    before, after = 0.5 * max(1.3 - stamp, 0.0), 1.5 * (7.0 - max(stamp, 1.3))
    return -before - after


def test_residuals_are_those_of_the_newest_output(prediction):
    absorb(prediction, (0, 'u', 1), (0, 'y', 0))
    prediction.start(pushed(0.0, 1.0))
    assert np.isnan([*prediction.now().residual.values()]).all()
    absorb(prediction, (1, 'y', 0.8))
    found = prediction.now()
    # x(1) = 1 + 0.5 - 1; its variance 0.1^2 + 0.2^2 and that of the load.
    assert found.residual == {'y': pytest.approx(0.3)}
    assert found.residual_stddev == {'y': pytest.approx(np.sqrt(0.06 + 0.01**2), rel=1e-9)}
    assert found.stamp == S
    plain = Prediction(VESSEL)
    absorb(plain, (0, 'u', 1), (0, 'y', 0))
    plain.start(replace(pushed(0.0, 1.0), walks={}))
    absorb(plain, (1, 'y', 0.8))
    assert plain.now().residual == {'y': pytest.approx(0.3)}
    assert plain.now().residual_stddev == {'y': pytest.approx(np.sqrt(0.02 + 0.01**2))}
    assert plain.now().state == {'x': pytest.approx(0.5)}


def test_deviations_above_a_tenth_of_the_bounds_are_withheld(prediction):
    absorb(prediction, (0, 'u', 1), (0, 'y', 0))
    for high, known in ((1.01, True), (0.99, False)):
        unknowns = Unknowns.of(VESSEL, bounds={'x': (0.0, high)})
        prediction.limit(GateSettings(), unknowns)
        prediction.start(pushed(0.0, 1.0))
        assert np.isfinite(prediction.now().stddev['x']) == known
    prediction.start(replace(pushed(0.0, 1.0), covariance=np.empty((0, 0))))
    assert np.isnan(prediction.now().stddev['x'])


def test_an_outlier_corrects_nothing_and_is_told(prediction):
    """The plant stays at 1.0; its sensor shows 4.0 once, and then for good."""
    plain = ungated(Prediction(VESSEL))
    for each in (prediction, plain):
        absorb(each, (0, 'u', 0.5), (0, 'y', 1.0))
        each.start(pushed(0.0, 1.0))
        absorb(each, *((0.1 * k, 'y', moving(k, 1.0)) for k in range(1, 10)))
        before = each.now()
        absorb(each, (1.0, 'y', 4.0))
        spiked = each.now()
        assert spiked.residual['y'] == pytest.approx(3.0, abs=0.02)
        assert spiked.residual_stddev['y'] < 0.2
        moved = abs(spiked.state['x'] - before.state['x'])
        assert (moved < 1e-3) == (each is prediction) and (moved > 0.5) == (each is plain)
        assert (spiked.stddev['x'] > before.stddev['x']) == (each is prediction)
    patience = InnovationGateSettings().patience
    later = [(1.0 + 0.1 * k, 'y', moving(k, 4.0)) for k in range(1, 2 * patience)]
    absorb(prediction, *later[: patience - 1])
    assert prediction.now().state['x'] == pytest.approx(1.0, abs=0.02)
    absorb(prediction, *later[patience - 1 :])
    assert prediction.now().state['x'] == pytest.approx(4.0, abs=0.2)


def moving(k, value):
    """A value that no stuck sensor would repeat."""
    return value + 0.01 * (k % 3)


def test_an_outlier_is_left_out_by_an_estimate_that_comes_late_too(prediction):
    late = Prediction(VESSEL)
    outputs = [(0.1 * k, 'y', 9.0 if k == 12 else moving(k, 1.0)) for k in range(1, 30)]
    for each in (prediction, late):
        absorb(each, (0, 'u', 0.5), (0, 'y', 1.0))
    prediction.start(pushed(0.0, 1.0))
    absorb(prediction, *outputs)
    absorb(late, *outputs)
    late.start(pushed(0.0, 1.0))
    assert late.now() == prediction.now()
    assert late.now().state['x'] == pytest.approx(1.0, abs=0.02)


def test_a_sensor_that_is_stuck_corrects_no_more(prediction):
    ungated(prediction)
    absorb(prediction, (0, 'u', 0.5), *((0.1 * k, 'y', 0.1 * (k % 3)) for k in range(3)))
    prediction.start(pushed(0.2, 0.0, sd=1e-3))
    absorb(prediction, *((0.1 * k, 'y', 5.0) for k in range(3, 12)))
    near = prediction.now().state['x']
    assert near > 4.5
    absorb(prediction, *((0.1 * k, 'y', 5.0) for k in range(12, 40)))
    assert np.isnan(prediction.now().residual['y'])
    assert prediction.now().state['x'] == pytest.approx(near, abs=1e-9)
    absorb(prediction, (4.0, 'y', 0.0))
    assert prediction.now().state['x'] < 1.0


def test_it_follows_three_tanks(backend):
    prediction = Prediction(THREE_TANK, backend)
    levels = tank_outputs(np.arange(200.0), (50.0, 40.0, 45.0), (0.6, 0.5, 0.7))
    for t, level in enumerate(levels):
        prediction.absorb(Sample(t * S, u=np.array([30.0, 30.0])))
        prediction.absorb(Sample(t * S, y=level))
        if t == 0:
            prediction.start(estimate(THREE_TANK, 0.0, (50.0, 40.0, 45.0), (0.6, 0.5, 0.7)))
    state = prediction.now().state
    assert [state['h1'], state['h2']] == pytest.approx(levels[-1].tolist(), abs=1e-9)


@pytest.mark.parametrize('noisy', [False, True])
def test_an_angle_is_predicted_within_its_period(noisy):
    """x' = d - u = -1 turns on over four periods; outputs correct it where the noise is known."""
    turn = 3.0
    model = replace(
        VESSEL, name='turning_vessel', states=[replace(VESSEL.states[0], period=turn)],
        outputs=[replace(VESSEL.outputs[0], period=turn)],
    )  # fmt: skip
    prediction = Prediction(model, 'numpy')
    wrapped = [(1.2 - 0.5 * t + 0.5 * turn) % turn - 0.5 * turn for t in range(25)]
    absorb(prediction, (0, 'u', 1), (0, 'y', wrapped[0]))
    begun = estimate(model, 0.0, (1.2,), (0.5, 0.0))
    if noisy:
        begun = replace(
            begun, covariance=np.diag([0.01, 0.0, 0.0]), noise={'y': 0.1}, walks={'x': 0.1}
        )
    prediction.start(begun)
    for t in range(1, 25):
        absorb(prediction, (t, 'y', wrapped[t]))
        now = prediction.now()
        assert -0.5 * turn <= now.state['x'] < 0.5 * turn
        assert now.state['x'] == pytest.approx(wrapped[t], abs=1e-9)
        assert now.residual['y'] == pytest.approx(0.0, abs=1e-9)


def test_a_time_that_counts_from_the_windows_start_goes_on_in_the_prediction() -> None:
    """x' = t, from a window that began at 1000 s and ended at 1004 s with x = 8, to 1006 s."""
    model = replace(VESSEL, time='window', dynamics=lambda t, x, u, p: (t + 0.0 * u[0],))
    prediction = Prediction(model)
    absorb(prediction, (1000, 'u', 0), (1004, 'y', 8), (1005, 'y', 12))
    prediction.start(replace(estimate(model, 1004, (8.0,), (0.5, 0.0)), t0=1000.0))
    absorb(prediction, (1006, 'y', 18), (1006.5, 'u', 0))
    assert prediction.now().state['x'] == pytest.approx(8.0 + (6.0**2 - 4.0**2) / 2.0, rel=1e-12)


@pytest.mark.parametrize('off', [0, 4_000_000])
def test_a_discrete_model_is_predicted_from_node_to_node(off):
    """Outputs at every second node, two of them only just; the estimate has a phase of its own."""
    u = pushes(30)
    states, y = course(u)
    y[1::2] = np.nan
    offsets = np.zeros(30)
    offsets[[20, 22]] = 0.05
    prediction = Prediction(ARX)
    for sample in samples(u, y, offsets)[:25]:
        prediction.absorb(sample)
    found = estimate(ARX, 1.0 + off / S, states[10], (*A, B))
    prediction.start(found)
    now = prediction.now()
    assert now.stamp == 24 * S // 10
    assert list(now.state.values()) == pytest.approx(states[24], rel=1e-9)
