"""Tests of obs_ros.horizon.warm_start."""

from typing import Any

import numpy as np
import pytest
from plants import OSCILLATOR, exact

from obs_ros import Estimate, Outcome, Record
from obs_ros.horizon.warm_start import propagated
from obs_ros.integration.backends import kernels_for

X0, P = (1.0, -0.5), (0.8, 0.7)
T = np.linspace(0.0, 3.0, 61)
FORCE = 0.4


def previous() -> tuple[Estimate, Any]:
    """The exact estimate of a window from 0 to 2 s, and the exact states from 0 to 3 s."""
    states, _ = exact(OSCILLATOR, T, lambda k, s: (FORCE,), X0, P)
    names = ('position', 'velocity')
    estimate = Estimate(
        parameters={'stiffness': P[0], 'push': P[1]},
        initial_state=dict(zip(names, states[0], strict=True)),
        state=dict(zip(names, states[40], strict=True)),
        stddev={},
        outcome=Outcome.CONVERGED,
        message='',
        t0=0.0,
        t1=2.0,
        times=T[:41],
        states=states[:41],
    )
    return estimate, states


def record(start: float, length: float = 2.0) -> Record:
    t = np.linspace(start, start + length, 21)
    return Record(t, np.full(21, FORCE), np.zeros((21, 2)))


@pytest.mark.parametrize('start', [0.5, 1.0, 1.95, 2.0, 2.05, 2.5, 3.0])
def test_overlapping_abutting_and_after_a_gap_it_meets_the_true_state(
    backend: str, start: float
) -> None:
    estimate, states = previous()
    found = propagated(kernels_for(OSCILLATOR, backend), estimate, record(start))
    expected = [np.interp(start, T, column) for column in states.T]
    np.testing.assert_allclose([found['position'], found['velocity']], expected, atol=1e-5)


def test_between_two_samples_it_interpolates() -> None:
    estimate, states = previous()
    found = propagated(kernels_for(OSCILLATOR, 'numpy'), estimate, record(0.525))
    assert found['position'] == pytest.approx(states[10:12, 0].mean(), abs=1e-12)


@pytest.mark.parametrize(('start', 'node'), [(-5.0, 0), (4.5, 40), (1e6, 40)])
def test_backwards_or_far_ahead_the_nearest_state_must_do(start: float, node: int) -> None:
    estimate, states = previous()
    found = propagated(kernels_for(OSCILLATOR, 'numpy'), estimate, record(start))
    np.testing.assert_array_equal([found['position'], found['velocity']], states[node])
