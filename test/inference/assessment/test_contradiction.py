"""Tests of obs_ros.inference.assessment.contradiction, on a plant linear in its unknowns."""

from dataclasses import replace

import numpy as np
import pytest
from jump_windows import DESIGN, LOWER, SIGMA, WIDTH, T, U, solved
from plants import INTEGRATOR, integrator_design, window_of

from obs_ros import Record
from obs_ros.core.prior_knowledge import with_knowledge
from obs_ros.core.typing import Array
from obs_ros.inference.assessment.contradiction import (
    SETTINGS,
    Contradiction,
    ContradictionSettings,
    contradictions,
)
from obs_ros.inference.jumps.hypothesis import Hypothesis, hypothesis_at
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.inference.prior import Prior

TRUTH = np.array([1.0, 1.3, -0.4])
EVERYTHING = ContradictionSettings(deviations=0.0)


def record(seed: int = 0, u: Array = U) -> Record:
    noise = np.random.default_rng([seed, 8]).standard_normal(T.size)
    return Record(T, u, integrator_design(T, u) @ TRUTH + SIGMA * noise)


def fitted(window: Record, **priors: tuple[float, float]) -> Hypothesis:
    objective = window_of(with_knowledge(INTEGRATOR, None, priors), window, SIGMA, backend=None)
    prior = Prior.known(objective.unknowns, start=True)
    return solved(PiecewiseProblem(objective, prior), np.full(3, 0.5))


def alone(window: Record, place: int, **priors: tuple[float, float]) -> tuple[float, float]:
    """Value and deviation of an unknown by window and other priors, in closed form."""
    prior = Prior.known(Unknowns.of(with_knowledge(INTEGRATOR, None, priors)), start=True)
    target = (window.y[:, 0] - integrator_design(window.t, window.u[:, 0]) @ LOWER) / SIGMA
    design = integrator_design(window.t, window.u[:, 0]) * WIDTH / SIGMA
    precision, mean = prior.precision.copy(), prior.mean
    precision[place] = precision[:, place] = 0.0
    covariance = np.linalg.inv(design.T @ design + precision)
    z = covariance @ (design.T @ target + precision @ mean)
    deviation = np.sqrt(covariance[place, place])
    return LOWER[place] + WIDTH[place] * z[place], WIDTH[place] * deviation


@pytest.mark.parametrize(
    ('name', 'mean', 'sd'),
    [('gain', 1.0, 0.05), ('gain', 1.0, 1e-3), ('drift', 0.2, 0.3), ('x', 0.0, 0.02)],
)
def test_a_prior_is_held_against_what_the_rest_says(name: str, mean: float, sd: float) -> None:
    window = record()
    place = ['x', 'gain', 'drift'].index(name)
    (found,) = contradictions(fitted(window, **{name: (mean, sd)}), settings=EVERYTHING)
    value, deviation = alone(window, place, **{name: (mean, sd)})
    assert found.place == place
    assert found.value == pytest.approx(value, rel=1e-5)
    assert found.apart == pytest.approx(abs(value - mean) / np.hypot(sd, deviation), rel=1e-4)


def test_priors_are_held_against_each_other_too() -> None:
    """A window at rest tells of the sum of two parameters; each prior says which the other is."""
    window = record(u=np.ones(T.size))
    priors = {'gain': (0.5, 0.1), 'drift': (-0.4, 0.02)}
    both = contradictions(fitted(window, **priors))
    assert [found.place for found in both] == [1, 2]
    for found in both:
        value, _ = alone(window, found.place, **priors)
        assert found.value == pytest.approx(value, rel=1e-4)
    assert both[0].value == pytest.approx(1.3, abs=0.05)
    assert both[0].apart == pytest.approx(both[1].apart, rel=0.02)


def test_a_search_that_stopped_short_changes_nothing() -> None:
    """The window hardly tells gain from drift: a tenth of the prior's deviation is far there."""
    window = record(u=np.ones(T.size))
    priors = {'drift': (-0.4, 0.02)}
    best = fitted(window, **priors)
    expected = contradictions(best, settings=EVERYTHING)[0]
    off = best.point + np.array([0.0, -1.0, 1.0]) * 0.001
    short = contradictions(hypothesis_at(best.problem, off), settings=EVERYTHING)[0]
    assert short.apart == pytest.approx(expected.apart, abs=0.01)


def test_right_priors_are_contradicted_three_times_in_a_thousand() -> None:
    apart = []
    rng = np.random.default_rng(1)
    for seed in range(300):
        mean = 1.3 + 0.05 * rng.standard_normal()
        found = contradictions(fitted(record(seed), gain=(mean, 0.05)), settings=EVERYTHING)
        apart += [each.apart for each in found]
    # Of 300 absolute normal deviates, 4 sigma about their means.
    assert np.mean(np.square(apart)) == pytest.approx(1.0, abs=4.0 * np.sqrt(2.0 / 300))
    assert np.count_nonzero(np.array(apart) > SETTINGS.deviations) <= 5


def test_a_correlated_residual_counts_for_less() -> None:
    window = record()
    best = fitted(window, gain=(1.0, 0.01))
    value, deviation = alone(window, 1, gain=(1.0, 0.01))
    (found,) = contradictions(best, inflation=9.0)
    assert found.apart == pytest.approx((value - 1.0) / np.hypot(0.01, 3.0 * deviation), rel=1e-4)


def test_without_a_given_prior_there_is_none() -> None:
    assert contradictions(fitted(record())) == []
    assert contradictions(fitted(record(), gain=(0.2, 60.0)), settings=EVERYTHING) == []


def test_words_name_value_prior_and_distance() -> None:
    states = (replace(INTEGRATOR.states[0], unit='cm'),)
    model = with_knowledge(replace(INTEGRATOR, states=states), None, {'x': (3.0, 0.25)})
    model = with_knowledge(model, None, {'gain': (1.0, 0.1)})
    unknowns = Unknowns.of(model)
    assert Contradiction(0, 1.23456, 7.04).words(unknowns) == (
        'x = 1.23 cm contradicts its prior 3 cm (sd 0.25) by 7 standard deviations'
    )
    assert Contradiction(1, 2.0, 4.46).words(unknowns) == (
        'gain = 2 contradicts its prior 1 (sd 0.1) by 4.5 standard deviations'
    )


def test_the_design_is_the_windows() -> None:
    """What stands in closed form above is the plant that is fitted."""
    np.testing.assert_allclose(
        fitted(record()).linearisation.jacobian, DESIGN, rtol=1e-5, atol=1e-5
    )
