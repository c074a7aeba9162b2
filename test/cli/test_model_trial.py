"""A trial rollout begins at the nominal values, and moves the inputs that it is told to."""

import numpy as np
import pytest
from arx import ARX

from obs_ros.cli.model_trial import TrialSettings, axis, simulated
from obs_ros.models import load_model

TANKS = load_model('three_tank')


@pytest.mark.parametrize(
    ('given', 'expected'),
    [
        ((), (1000.0, 1.0)), ((50.0,), (50.0, 1.0)), ((50.0, 0.5), (50.0, 0.5)),
        ((None, 2.0), (1000.0, 2.0)),
    ],
)  # fmt: skip
def test_the_axis_is_given_or_that_of_the_models_step(given, expected):
    assert axis(TANKS, *given) == expected


def test_a_model_without_a_step_gets_so_many_samples():
    plain = load_model('linear_second_order')
    settings = TrialSettings(duration=8.0, samples=16)
    if np.isfinite(plain.max_step):
        plain = type(plain)(**{**vars(plain), 'max_step': np.inf})
    assert axis(plain, settings=settings) == (8.0, 0.5)


@pytest.mark.parametrize(
    ('given', 'reason'),
    [((1.0, 1.0), 'too short'), ((20.0, 1.0), 'more than 10 samples'), ((-1.0,), 'positive time')],
)
def test_an_axis_that_cannot_be_is_refused(given, reason):
    with pytest.raises(ValueError, match=reason):
        axis(TANKS, *given, settings=TrialSettings(most_samples=10))


def test_inputs_move_about_their_nominal_values_and_values_replace_them():
    trial = simulated(TANKS, 100.0, 1.0, {'h1': 20.0, 'Q2': 10.0}, {'Q1': 4.0}, {}, backend='numpy')
    q1, q2 = trial.record.u.T
    assert (q2 == 10.0).all() and q1.max() == pytest.approx(34.0) and q1.min() >= 26.0
    assert trial.x0[0] == 20.0 and trial.states.shape == (101, 3) and trial.steps >= 100
    np.testing.assert_array_equal(trial.record.y, trial.states[:, :2])
    with pytest.raises(ValueError, match='p1 = 2 is outside its bounds 0 to 1'):
        simulated(TANKS, 100.0, 1.0, {'p1': 2.0}, {}, {}, backend='numpy')


def test_a_discrete_model_is_sampled_at_its_nodes():
    assert axis(ARX) == (100.0, 0.1)
    assert axis(ARX, None, 0.3) == (100.0, 0.3)
    with pytest.raises(ValueError, match='--period must be a multiple of the period of model'):
        axis(ARX, None, 0.25)
    trial = simulated(ARX, 3.0, 0.3, {'now': 1.0}, {}, {}, backend='numpy')
    assert trial.steps == 30 and trial.error == 0.0
    with pytest.raises(ValueError, match=r'which give the next state, 0\.1 s later'):
        simulated(ARX, 500.0, 0.1, {'a1': 2.0, 'a2': 1.0, 'now': 1.0}, {}, {}, backend='numpy')
