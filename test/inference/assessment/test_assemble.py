"""Tests of obs_ros.inference.assessment.assemble."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from plants import NAN, OSCILLATOR
from scipy.stats import chi2

from obs_ros import Estimate, Outcome, Record
from obs_ros.core.estimate import Jump
from obs_ros.core.typing import Array
from obs_ros.inference.assessment.assemble import empty, report
from obs_ros.inference.assessment.interval import Interval
from obs_ros.inference.assessment.uncertainty import AtEnd, Uncertainty
from obs_ros.inference.jumps.hypothesis import hypothesis_at
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.objective import Objective
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.inference.prior import Prior
from obs_ros.inference.process_noise import ProcessNoise
from obs_ros.inference.window_state import WindowState
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid
from obs_ros.optimization.acceptance import Acceptance
from obs_ros.optimization.result import Effort, Found

T = np.linspace(0.0, 2.0, 31)
SCALE = np.array([0.1, 10.0])
FOUND = Found(
    z=np.array([0.7, 0.4, 0.5, 0.3]),
    cost=50.0,
    converged=True,
    accepted=Acceptance.METHOD,
    effort=Effort(3, 'round'),
)
# Scaled, 1 in size and white: of two neighbours every other pair agrees in sign.
SIGNS = np.resize([1.0, 1.0, -1.0, -1.0], 31)[:, None]
NOISE = SIGNS * np.array([1.0, -1.0]) * SCALE


def problem(
    noise: Any = NOISE, z: Array = FOUND.z, *, noise_known: bool = False, **settings: Any
) -> WindowState:
    """A window whose residuals at z are `-noise`."""
    kernels, unknowns = kernels_for(OSCILLATOR, 'numpy'), Unknowns.of(OSCILLATOR, **settings)
    blank = Record(T, np.sin(T), np.zeros((31, 2)))
    z = z[: unknowns.dimension]
    values = unknowns.values(z[None])
    y = kernels.trajectories(Grid.of(OSCILLATOR, blank, SCALE), *values)[1][..., 0]
    record = Record(T, np.sin(T), y + noise, stamp=77)
    objective = Objective(kernels, Grid.of(OSCILLATOR, record, SCALE), unknowns)
    return WindowState(record, objective, Prior.box(unknowns), noise_known)


def estimate(
    noise_known: bool = False, noise: Any = NOISE, in_time: bool = True, **changes: Any
) -> Estimate:
    window = problem(noise, changes.get('z', FOUND.z), noise_known=noise_known)
    return report(window, replace(FOUND, **changes), None, in_time=in_time, solve_time=0.25)


def certain(
    noise_known: bool = True,
    noise: Any = NOISE,
    deviations: tuple[float, ...] = (0.01, 0.02, 0.03, 0.04),
    **changes: Any,
) -> Estimate:
    """With the given standard deviations of z, in boxes, whatever the window says."""
    window = problem(noise, noise_known=noise_known)
    covariance = np.diag(deviations) ** 2
    uncertainty = Uncertainty(
        hypothesis_at(PiecewiseProblem(window.objective, window.prior), FOUND.z),
        covariance,
        np.diag(1.0 / np.diag(covariance)[2:]),
    )
    uncertainty = replace(uncertainty, **changes)
    return report(window, FOUND, uncertainty, in_time=True, solve_time=0.25)


def test_values_by_name() -> None:
    found = estimate()
    assert found.initial_state == pytest.approx({'position': 1.2, 'velocity': -0.6})
    assert found.parameters == pytest.approx({'stiffness': 1.1, 'push': 0.6})
    assert list(found.state) == ['position', 'velocity']
    np.testing.assert_array_equal(list(found.state.values()), found.states[-1])
    assert (found.t0, found.t1, found.stamp, found.solve_time) == (0.0, 2.0, 77, 0.25)
    np.testing.assert_array_equal(found.times, T)


def test_without_certainty_standard_deviations_are_nan_for_every_name() -> None:
    found = estimate()
    assert list(found.stddev) == ['position', 'velocity', 'stiffness', 'push']
    assert list(found.initial_stddev) == ['position', 'velocity']
    assert np.isnan([*found.stddev.values(), *found.initial_stddev.values()]).all()
    assert found.weak == found.jumps == () and found.covariance.size == 0
    assert not found.noise and not found.walks


def test_standard_deviations_in_the_units_of_the_variables() -> None:
    found = certain()
    assert found.outcome is Outcome.CONVERGED
    assert found.initial_stddev == pytest.approx({'position': 0.06, 'velocity': 0.12})
    assert found.stddev['stiffness'] == pytest.approx(0.03 * 1.8)
    assert found.stddev['push'] == pytest.approx(0.04 * 2.0)
    assert list(found.stddev) == ['position', 'velocity', 'stiffness', 'push']
    deviations = np.sqrt(np.diagonal(found.covariance))
    np.testing.assert_allclose(deviations, list(found.stddev.values()))


def test_noise_and_walks_by_name() -> None:
    # Scales are those of white noise that disturbs as much as the correlated one, 0.6 at lag 1.
    found = certain(correlation=0.6)
    assert found.noise == pytest.approx(dict(zip(('y1', 'y2'), SCALE / 2.0, strict=True)))
    assert found.walks == {}
    pushed = ProcessNoise(np.array([0.0, 0.3, 0.0, 0.0]), np.array([0.2, 5.0]))
    found = certain(process_noise=pushed, end=AtEnd(np.diag([0.01, 0.04, 0.0, 0.0])))
    assert found.noise == {'y1': 0.2, 'y2': 5.0}
    assert found.walks == {'position': 0.0, 'velocity': 0.3, 'stiffness': 0.0, 'push': 0.0}
    without = np.diagonal(certain().covariance)
    np.testing.assert_allclose(np.diagonal(found.covariance) - without, [0.01, 0.04, 0.0, 0.0])


def test_what_is_not_determined_is_withheld_named_and_advised_upon() -> None:
    found = certain(deviations=(0.01, 0.02, 0.03, 0.2))
    assert found.outcome is Outcome.NOT_IDENTIFIABLE
    assert np.isnan(found.stddev['push'])
    assert found.stddev['stiffness'] == pytest.approx(0.03 * 1.8)
    assert found.weak == ('push is not determined',)
    assert found.message == f'{found.advice}; push is not determined'
    assert 'would determine push' in found.advice


JUMP = Jump(1.25, 0.01, {'push': -0.5}, {'push': 0.05}, new=True)


def test_jumps_are_told_whatever_the_outcome() -> None:
    text = '; jump at 1.25 s +- 0.02 s: push -0.5 +- 0.1'
    for changes, outcome in (
        ({}, Outcome.CONVERGED),
        ({'noise': 2.0 * NOISE}, Outcome.MODEL_MISMATCH),
        ({'deviations': (0.01, 0.02, 0.03, 0.2)}, Outcome.NOT_IDENTIFIABLE),
    ):
        found = certain(jumps=(JUMP,), **changes)
        assert found.outcome is outcome
        assert found.jumps == (JUMP,)
        assert found.message.endswith(text)


def test_without_time_to_look_for_jumps_nothing_is_certain() -> None:
    found = certain(finished=False)
    assert found.outcome is Outcome.DEADLINE
    assert found.message.startswith('allow more time, or shorten the window: none was left to look')
    assert np.isnan([*found.stddev.values(), *found.initial_stddev.values()]).all()
    assert found.usable


def test_what_the_noise_does_not_explain_has_no_standard_deviations() -> None:
    found = certain(noise=2.0 * NOISE)  # squares of 248 for 58
    assert found.outcome is Outcome.MODEL_MISMATCH
    assert np.isnan(list(found.stddev.values())).all()
    # Not known, it is what the residual says.
    assert np.isfinite(list(certain(False, noise=2.0 * NOISE).stddev.values())).all()


def test_the_cost_is_that_of_the_residuals_alone() -> None:
    assert certain().cost == pytest.approx(0.5 * 62.0)


def test_correlated_residuals_raise_standard_deviations() -> None:
    signs = np.resize([1.0, 1.0, 1.0, -1.0, -1.0, -1.0], 31)[:, None]
    found = certain(noise=signs * SCALE)
    # Noise may well be correlated so: 20 of 30 pairs agree in sign, 10 / 31 * sqrt(62) = 2.54.
    assert found.outcome is Outcome.CONVERGED
    assert found.stddev['push'] == pytest.approx(0.04 * 2.0)
    slow = np.resize(np.repeat([1.0, -1.0], 6), 31)[:, None]
    found = certain(noise=slow * SCALE)
    r = (30.0 - 2.0 * 5.0) / 31.0
    assert found.outcome is Outcome.MODEL_MISMATCH
    assert f'its lag-1 correlation is {r:.2g}' in found.message
    raised = np.sqrt((1.0 + r) / (1.0 - r))
    assert found.stddev['push'] == pytest.approx(raised * 0.04 * 2.0)


def test_rms_in_the_units_of_the_outputs() -> None:
    found = estimate()
    assert found.output_rms == pytest.approx({'y1': 0.1, 'y2': 10.0})


def test_the_cost_of_least_squares_is_half_the_sum_of_squares() -> None:
    assert estimate().cost == 25.0


def test_the_state_belongs_to_the_last_node_with_an_output() -> None:
    noise = NOISE.copy()
    noise[28:] = NAN
    found = estimate(noise=noise)
    assert found.t1 == T[27]
    np.testing.assert_array_equal(list(found.state.values()), found.states[27])
    assert found.states.shape == (31, 2)


def test_converged_names_its_rule() -> None:
    found = estimate()
    assert (found.outcome, found.message) == (Outcome.CONVERGED, Acceptance.METHOD.value)


def test_not_confirmed() -> None:
    found = estimate(accepted=None)
    assert found.outcome is Outcome.DEADLINE
    assert found.message.startswith('allow more rounds, or shorten the window: best of ')
    assert found.message.endswith(' in 3 rounds, not confirmed')
    found = estimate(accepted=None, in_time=False)
    assert found.message.startswith('allow more time, or shorten the window: best of ')


def test_a_residual_above_the_given_noise() -> None:
    limit = chi2.isf(0.001, 62 - 4)
    assert estimate(True, cost=0.999 * limit).outcome is Outcome.CONVERGED
    assert estimate(True, cost=1.001 * limit).outcome is Outcome.MODEL_MISMATCH
    found = estimate(True, cost=4.0 * 58.0)
    assert found.outcome is Outcome.MODEL_MISMATCH
    assert found.message == (
        'check the noise, the model and its fixed values, or shorten the window: '
        'the residual is 2 times the noise, given or learned'
    )
    assert estimate(False, cost=4.0 * 58.0).outcome is Outcome.CONVERGED


def test_a_residual_far_below_the_given_noise() -> None:
    limit = chi2.ppf(0.001, 62 - 4)
    assert estimate(True, cost=1.001 * limit).outcome is Outcome.CONVERGED
    assert estimate(True, cost=0.999 * limit).outcome is Outcome.MODEL_MISMATCH
    found = estimate(True, cost=0.25 * 58.0)
    assert found.message.startswith(
        'check the noise if it is given: the residual is only 0.5 times'
    )
    assert estimate(False, cost=0.25 * 58.0).outcome is Outcome.CONVERGED


def test_a_residual_that_is_not_white() -> None:
    for noise in (np.abs(NOISE), np.abs(NOISE) * np.resize([1.0, -1.0], 31)[:, None]):
        found = estimate(noise=noise)
        assert found.outcome is Outcome.MODEL_MISMATCH
        sign = '-' if noise[1, 0] < 0.0 else ''
        assert f'not white, its lag-1 correlation is {sign}0.97' in found.message
        assert found.message.startswith('look for what the model leaves out, a parameter that')
    assert estimate().outcome is Outcome.CONVERGED
    # Rounding is no noise.
    assert estimate(noise=1e-9 * np.abs(NOISE), cost=50e-18).outcome is Outcome.CONVERGED


@pytest.mark.parametrize(
    ('z', 'text'),
    [
        ([0.7, 0.0, 0.5, 0.3], ': velocity is at its lower bound -3 m/s; ' + Acceptance.METHOD),
        ([0.7, 1.0, 0.5, 0.3], ': velocity is at its upper bound 3 m/s; ' + Acceptance.METHOD),
        (
            [0.0, 0.4, 1.0, 0.3],
            ': position is at its lower bound -3, stiffness is at its upper bound 2; '
            + Acceptance.METHOD,
        ),
    ],
)
def test_at_bound_names_the_unknowns_and_the_bounds(z: list[float], text: str) -> None:
    found = estimate(z=np.array(z))
    assert found.outcome is Outcome.AT_BOUND
    assert text in found.message
    assert 'check the bounds, or the model' in found.message


def test_a_state_at_its_bound_is_said_before_every_other_reason() -> None:
    found = estimate(True, cost=4.0 * 58.0, z=np.array([0.0, 0.4, 1.0, 0.3]))
    assert found.outcome is Outcome.MODEL_MISMATCH
    assert found.message.startswith('position lies at its lower bound -3')
    assert 'the residual is 2 times the noise' in found.message


def test_what_is_fixed_is_never_at_a_bound() -> None:
    window = problem(fixed={'push': 2.0})
    found = report(window, replace(FOUND, z=FOUND.z[:3]), None, in_time=True, solve_time=0.0)
    assert found.parameters['push'] == 2.0
    assert found.outcome is Outcome.CONVERGED


def test_an_empty_estimate_has_every_name_and_no_value() -> None:
    found = empty(OSCILLATOR, problem().record, Outcome.DIVERGED, 'why')
    assert not found.usable
    assert (found.outcome, found.message, found.stamp) == (Outcome.DIVERGED, 'why', 77)
    assert (found.t0, found.t1) == (0.0, 2.0)
    for mapping, names in (
        (found.parameters, ['stiffness', 'push']),
        (found.initial_state, ['position', 'velocity']),
        (found.state, ['position', 'velocity']),
        (found.stddev, ['position', 'velocity', 'stiffness', 'push']),
        (found.output_rms, ['y1', 'y2']),
    ):
        assert list(mapping) == names
        assert np.isnan(list(mapping.values())).all()
    assert np.isnan([found.interval[name] for name in found.stddev]).all()


@pytest.mark.parametrize(('push', 'outcome'), [
    (1.0, Outcome.AT_BOUND), (0.0, Outcome.AT_BOUND), (0.999, Outcome.NOT_IDENTIFIABLE),
])  # fmt: skip
def test_of_what_lies_at_a_bound_that_is_said(push: float, outcome: Outcome) -> None:
    """Its profile has no end there: it is not determined, but the bound is the reason."""
    z = np.array([0.7, 0.4, 0.5, push])
    window = problem(z=z, noise_known=True)
    best = hypothesis_at(PiecewiseProblem(window.objective, window.prior), z)
    ends = (np.nan, 0.1) if push < 0.5 else (0.9, np.nan)
    lower, upper = np.array([(0.45, 0.55), ends]).T
    interval = Interval(lower, z[2:], upper, best.linearisation.state[None].repeat(2, 0))
    information = np.diag([1e3, 1e3])
    uncertainty = Uncertainty(best, best.covariance, information, interval=interval)
    found = report(window, replace(FOUND, z=z), uncertainty, in_time=True, solve_time=0.1)
    assert found.outcome is outcome
    assert np.isnan(found.stddev['push']) and np.isnan(found.interval['push']).all()
    assert found.interval['stiffness'] == pytest.approx((0.2 + 0.45 * 1.8, 0.2 + 0.55 * 1.8))
    assert ('push is at its' in found.message) == (outcome is Outcome.AT_BOUND)


def test_what_is_not_determined_elsewhere_is_said_before_a_bound() -> None:
    z = np.array([0.7, 0.4, 0.5, 1.0])
    window = problem(z=z, noise_known=True)
    best = hypothesis_at(PiecewiseProblem(window.objective, window.prior), z)
    ends = np.array([np.nan, 0.9]), z[2:], np.array([np.nan, np.nan])
    interval = Interval(*ends, best.linearisation.state[None].repeat(2, 0))
    uncertainty = Uncertainty(best, best.covariance, np.diag([1.0, 1e3]), interval=interval)
    found = report(window, replace(FOUND, z=z), uncertainty, in_time=True, solve_time=0.1)
    assert found.outcome is Outcome.NOT_IDENTIFIABLE
    assert 'stiffness' in found.message
