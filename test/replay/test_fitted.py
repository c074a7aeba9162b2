"""Outputs along the fitted path."""

import numpy as np
from ball_and_beam import BALL

from obs_ros import Model, Variable
from obs_ros.core.estimate import Estimate, Jump, Outcome
from obs_ros.core.record import Sample
from obs_ros.models import load_model
from obs_ros.replay.fitted import fitted_outputs, outputs_of_states
from obs_ros.replay.history import History


def test_outputs_that_are_states_are_known_by_what_they_do():
    assert outputs_of_states(BALL) == {0: 0}
    suspension = load_model('suspension')
    # zd is the difference of two states.
    assert outputs_of_states(suspension) == {0: 0, 2: 1}


def test_outputs_that_are_no_state_follow_the_path_and_the_parameters_before_a_jump():
    def output(t, x, u, p):
        return (p[0] * x[0] + u[0],)

    model = Model(
        name='gain', states=(Variable('x', lower=-9, upper=9),), inputs=(Variable('u'),),
        outputs=(Variable('y'),), parameters=(Variable('k', lower=0, upper=9),),
        dynamics=lambda t, x, u, p: (-p[0] * x[0] + u[0],), output=output,
    )  # fmt: skip
    history = History(model)
    for second, u in enumerate((1.0, 2.0, 4.0)):
        history.record(Sample(second * 10**9, u=np.array([u])))
    jump = Jump(1.5, 0.1, {'k': 3.0}, {'k': 0.1}, new=True, stamp=1_500_000_000)
    history.add(
        Estimate(
            {'k': 5.0}, {'x': 1.0}, {'x': 3.0}, {}, Outcome.CONVERGED, '', 0.0, 2.0, jumps=(jump,),
            times=np.arange(3.0), states=np.array([[1.0], [2.0], [3.0]]), stamp=2_000_000_000,
        )
    )  # fmt: skip
    np.testing.assert_allclose(history.path.rows, [[1.0, 2.0], [2.0, 2.0], [3.0, 5.0]])
    np.testing.assert_allclose(fitted_outputs(history)[:, 0], [2.0 + 1.0, 4.0 + 2.0, 15.0 + 4.0])


def test_outputs_that_wrap_are_fitted_within_their_period():
    outputs = (Variable('y', period=4.0),)
    model = Model(
        name='wrapping', states=(Variable('x', lower=-99, upper=99),), outputs=outputs,
        dynamics=lambda t, x, u, p: (1.0 + 0.0 * x[0],), output=lambda t, x, u, p: (x[0],),
    )  # fmt: skip
    history = History(model)
    history.add(
        Estimate(
            {}, {'x': 1.0}, {'x': 9.0}, {}, Outcome.CONVERGED, '', 0.0, 2.0,
            times=np.arange(3.0), states=np.array([[1.0], [2.0], [9.0]]), stamp=2_000_000_000,
        )
    )  # fmt: skip
    assert fitted_outputs(history)[:, 0].tolist() == [1.0, -2.0, 1.0]
