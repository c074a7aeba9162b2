"""Tests of obs_ros.horizon.given_priors, and of priors at the front door."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from plants import INTEGRATOR, LAG, integrator_design, square_wave, window_of

from obs_ros import Model, Outcome, Record, Variable, solve_window
from obs_ros.core.deadline import Deadline
from obs_ros.core.prior_knowledge import with_knowledge
from obs_ros.horizon.given_priors import under_given_priors
from obs_ros.inference.prior import Prior
from obs_ros.inference.window_state import WindowState
from obs_ros.optimization.acceptance import Acceptance
from obs_ros.optimization.result import Effort, Found

SIGMA = 0.05
T = 0.1 * np.arange(201)
U = square_wave(T, 1.7)


def product(scale: Any) -> Model:
    """Only the product of a and b is seen: x' = a b u."""
    factors = (Variable(name, lower=0.2, upper=10.0, scale=scale) for name in 'ab')
    return Model(
        name=f'product_{scale}', states=INTEGRATOR.states, inputs=INTEGRATOR.inputs,
        outputs=INTEGRATOR.outputs, parameters=tuple(factors), output=INTEGRATOR.output,
        dynamics=lambda t, x, u, p: (p[0] * p[1] * u[0],),
    )  # fmt: skip


def record(gain: float = 1.5, seed: int = 0) -> Record:
    noise = np.random.default_rng([seed, 3]).standard_normal(T.size)
    return Record(T, U, integrator_design(T, U) @ [1.0, gain, 0.0] + SIGMA * noise)


def closed_form(window: Record) -> tuple[float, float]:
    """The product and its deviation, by least squares of y on 1 and the integral of u."""
    design = integrator_design(window.t, window.u[:, 0])[:, :2]
    covariance = SIGMA**2 * np.linalg.inv(design.T @ design)
    fitted = covariance @ (design.T @ window.y[:, 0]) / SIGMA**2
    return float(fitted[1]), float(np.sqrt(covariance[1, 1]))


@pytest.mark.parametrize('known', [True, False], ids=['noise given', 'noise free'])
@pytest.mark.parametrize('scale', ['linear', 'log'])
def test_a_prior_of_one_factor_makes_both_known(scale: str, known: bool, backend: str) -> None:
    """What the window leaves open stays with the prior, whose share of b becomes one of a."""
    settings: dict[str, Any] = {'noise': {'y': SIGMA}} if known else {}
    without = solve_window(product(scale), record(), backend=backend, **settings)
    assert without.outcome is Outcome.NOT_IDENTIFIABLE
    assert np.isnan([without.stddev['a'], without.stddev['b']]).any()
    found = solve_window(
        product(scale), record(), backend=backend, priors={'b': (3.0, 0.15)}, **settings
    )
    ab, deviation = closed_form(record())
    assert found.outcome is Outcome.CONVERGED and found.weak == ()
    assert found.parameters['b'] == pytest.approx(3.0, abs=0.02)  # a seventh of a deviation
    assert found.parameters['a'] * found.parameters['b'] == pytest.approx(ab, abs=0.1 * deviation)
    # Ends of the posterior's profile: a normal b, or logarithm of b, times the narrow product.
    least, most = (3.0 - 1.96 * 0.15, 3.0 + 1.96 * 0.15)
    if scale == 'log':
        least, most = (3.0 * np.exp(side * 1.96 * 0.05) for side in (-1.0, 1.0))
    assert found.interval['b'] == pytest.approx((least, most), abs=0.02)
    assert found.stddev['b'] == pytest.approx((most - 3.0) / 1.96, rel=0.02)
    assert found.interval['a'] == pytest.approx((ab / most, ab / least), rel=0.01)
    assert found.stddev['a'] == pytest.approx((ab / least - ab / 3.0) / 1.96, rel=0.04)


@pytest.mark.parametrize('scale', ['linear', 'log'])
def test_intervals_hold_the_truth(scale: str) -> None:
    """a = 0.5, b = 3, of which each of 60 data sheets errs by its deviation of 0.15."""
    held = {'a': 0, 'b': 0}
    rng = np.random.default_rng(11)
    model = product(scale)
    for seed in range(60):
        mean = 3.0 + 0.15 * rng.standard_normal()
        found = solve_window(
            model, record(seed=seed), noise={'y': SIGMA}, priors={'b': (mean, 0.15)}
        )
        assert 'contradicts' not in found.message
        for name, truth in (('a', 0.5), ('b', 3.0)):
            held[name] += abs(found.parameters[name] - truth) < 1.96 * found.stddev[name]
    # 95 % of 60, and 3 sigma of chance.
    assert min(held.values()) >= 52, held


def test_both_backends_agree() -> None:
    priors = {'b': (3.0, 0.15), 'x': (1.1, 0.2)}
    one, other = (
        solve_window(product('log'), record(), noise={'y': SIGMA}, priors=priors, backend=name)
        for name in ('numpy', 'numba')
    )
    for field in ('parameters', 'stddev', 'initial_state', 'initial_stddev'):
        assert getattr(one, field) == pytest.approx(getattr(other, field), rel=1e-6), field


def test_a_parameter_without_a_prior_keeps_its_numbers_bit_for_bit() -> None:
    plain = solve_window(INTEGRATOR, record(), noise={'y': SIGMA})
    for walks, priors in (({}, {}), (None, {'gain': None}), ({'gain': 0.1}, None)):
        found = solve_window(INTEGRATOR, record(), noise={'y': SIGMA}, walks=walks, priors=priors)
        assert found.parameters == plain.parameters and found.stddev == plain.stddev
        assert (found.message, found.evaluations) == (plain.message, plain.evaluations)


def test_no_box_pulls_at_what_has_no_prior() -> None:
    """The gain is that of least squares in which the prior of the drift is one more row."""
    found = solve_window(INTEGRATOR, record(), noise={'y': 1.0}, priors={'drift': (0.1, 0.02)})
    design = np.vstack([integrator_design(T, U), [0.0, 0.0, 50.0]])
    expected = np.linalg.lstsq(design, np.append(record().y[:, 0], 5.0), rcond=None)[0]
    values = [found.initial_state['x'], *found.parameters.values()]
    # Of the noise that is given, a search leaves a hundredth of a deviation.
    np.testing.assert_allclose(values, expected, atol=2e-3)


@pytest.mark.parametrize('search', ['chaotic_de', 'ga'])
def test_searches_without_squares_take_them_too(search: Any) -> None:
    found = solve_window(product('log'), record(), search, noise={'y': SIGMA},
                         priors={'b': (3.0, 0.01)})  # fmt: skip
    assert found.parameters['b'] == pytest.approx(3.0, abs=0.05)
    # The cost is the residual's alone.
    residual = found.output_rms['y'] * np.sqrt(T.size) / SIGMA
    assert found.cost == pytest.approx(0.5 * residual**2, rel=1e-6)


def test_a_contradiction_comes_with_advice_first() -> None:
    found = solve_window(
        LAG, Record(T, U, np.zeros(T.size)), noise={'y': SIGMA}, priors={'x': (3.0, 0.2)}
    )
    assert 'check the prior, or the model: x = ' in found.message
    unknown = solve_window(INTEGRATOR, record(), noise={'y': SIGMA}, priors={'gain': (1.0, 0.05)})
    assert unknown.message.startswith('check the prior, or the model: gain = 1.49 ')
    assert 'contradicts its prior 1 (sd 0.05) by ' in unknown.message
    assert unknown.outcome is Outcome.CONVERGED and 1.4 < unknown.parameters['gain'] < 1.6


def test_process_noise_and_priors_go_together() -> None:
    """Walks of the state at the front door, and a prior of what these leave unknown."""
    rng = np.random.default_rng(5)
    push = np.append(0.0, np.cumsum(0.1 * np.sqrt(0.1) * rng.standard_normal(T.size - 1)))
    pushed = replace(record(), y=record().y[:, 0] + push)
    settings: dict[str, Any] = {'noise': {'y': SIGMA}, 'process_noise': 'given'}
    free = solve_window(product('log'), pushed, walks={'x': 0.1}, **settings)
    found = solve_window(
        product('log'), pushed, walks={'x': 0.1}, priors={'b': (3.0, 0.15)}, **settings
    )
    assert 'x by 0.1' in free.message and 'x by 0.1' in found.message
    assert free.outcome is Outcome.NOT_IDENTIFIABLE and found.outcome is Outcome.CONVERGED
    # The longer side of an interval whose logarithm is symmetric.
    assert found.stddev['b'] == pytest.approx(3.0 * np.expm1(1.96 * 0.05) / 1.96, rel=0.03)
    assert abs(found.parameters['a'] - 0.5) < 3.0 * found.stddev['a'] < 0.3


def posed(**priors: tuple[float, float]) -> tuple[WindowState, Found]:
    objective = window_of(with_knowledge(INTEGRATOR, None, priors), record(), SIGMA)
    prior = Prior.known(objective.unknowns, start=True)
    window = WindowState(record(), objective, prior, noise_known=True)
    found = Found(
        np.array([0.55, 0.7, 0.45]), 1.0, converged=True, accepted=Acceptance.METHOD,
        effort=Effort(1, 'round'),
    )  # fmt: skip
    return window, found


def test_without_given_priors_a_fit_stays_as_it_is() -> None:
    window, found = posed()
    assert under_given_priors(window, found, Deadline(), polish=True) is found


def test_a_fit_is_polished_where_squares_are_in_units_of_the_noise() -> None:
    window, found = posed(drift=(0.3, 0.01))
    kept = under_given_priors(window, found, Deadline(), polish=False)
    np.testing.assert_array_equal(kept.z, found.z)
    assert kept.cost == window.objective.costs(found.z[None])[0]
    moved = under_given_priors(window, found, Deadline(), polish=True)
    assert moved.cost == pytest.approx(window.objective.costs(moved.z[None])[0], rel=1e-12)
    gradient = window.with_given_priors.linearise(moved.z[None], np.full((1, 3), 1e-7), T.size)[1]
    assert np.abs(gradient).max() < 0.01 * np.abs(
        window.with_given_priors.linearise(found.z[None], np.full((1, 3), 1e-7), T.size)[1]
    ).max()  # fmt: skip
