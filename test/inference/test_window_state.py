"""Tests of obs_ros.inference.window_state."""

from dataclasses import replace

import numpy as np
from plants import OSCILLATOR, window_of

from obs_ros import Record
from obs_ros.core.prior_knowledge import with_knowledge
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.inference.prior import Prior
from obs_ros.inference.window_state import WindowState

T = np.linspace(3.0, 5.0, 31)
RECORD = Record(T, np.sin(T), np.cos(T)[:, None] * np.array([1.0, 2.0]))
Z = np.full((1, 4), 0.4)


def state() -> WindowState:
    objective = window_of(OSCILLATOR, RECORD, 0.1)
    return WindowState(RECORD, objective, Prior.box(objective.unknowns), noise_known=True)


def test_it_knows_its_times() -> None:
    window = state()
    assert (window.start, window.duration) == (3.0, 2.0)


def test_rescaled_it_is_another_window_and_the_first_stays() -> None:
    window = state()
    before = window.objective.costs(Z)
    wider = window.rescaled(np.array([2.0, 2.0]))
    np.testing.assert_allclose(wider.objective.costs(Z), before / 4.0, rtol=1e-12)
    np.testing.assert_array_equal(window.objective.costs(Z), before)
    assert wider.objective.evaluations == window.objective.evaluations == 3


def test_its_posterior_has_the_squares_of_residuals_and_prior() -> None:
    window = state()
    expected = window.objective.costs(Z) + window.prior.squares(Z)
    np.testing.assert_allclose(window.posterior.costs(Z), expected, rtol=1e-12)


def test_by_itself_it_has_the_squares_of_given_priors_but_none_of_boxes() -> None:
    plain = state()
    assert plain.with_given_priors is plain.objective
    model = with_knowledge(OSCILLATOR, None, {'push': (1.0, 0.1)})
    unknowns = Unknowns.of(model)
    window = replace(plain, prior=Prior.known(unknowns, start=True))
    off = (2.0 * Z[0, 3] - 1.0) / 0.1  # push lies in [0, 2]
    found = window.with_given_priors.costs(Z)
    np.testing.assert_allclose(found, plain.objective.costs(Z) + off**2, rtol=1e-12)
    other = replace(window, objective=replace(plain.objective, fitness='euclidean'))
    assert other.with_given_priors is other.objective
