"""Tests of obs_ros.observers.papers.rls_luenberger, against Gremling & Passino 2000."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from observer_form import MINIMUM_PHASE, NON_MINIMUM_PHASE, T, experiment
from plants import observer_form, rich_input, trajectory

from obs_ros import Sample, Variable
from obs_ros.observers.papers.rls_luenberger import RecursiveLeastSquaresObserver


@pytest.mark.parametrize(
    ('p', 'most'), [(MINIMUM_PHASE, (129.0, 148.0)), (NON_MINIMUM_PHASE, (40.0, 56.0))]
)
def test_least_squares_find_the_parameters(p: Any, most: tuple[float, float]) -> None:
    observer = RecursiveLeastSquaresObserver(observer_form())
    sums = experiment(observer, p)
    assert sums[1] < most[0] and sums[2] < most[1]
    assert observer.p == pytest.approx(p, abs=2e-3)


def test_least_squares_deviations_cover_the_errors() -> None:
    """Noise of sd 0.01: filtered, it is not white, so only the size is right."""
    observer = RecursiveLeastSquaresObserver(observer_form())
    experiment(observer, MINIMUM_PHASE, 30.0, sigma=0.01)
    deviations = observer.stddev[3:]
    errors = np.abs(observer.p - MINIMUM_PHASE)
    assert (deviations > 0.0).all() and (deviations < 0.2).all()
    assert (errors < 20.0 * deviations).all()
    assert np.isnan(observer.stddev[:3]).all()


def test_with_a_memory_it_follows_parameters_that_change() -> None:
    lasting = RecursiveLeastSquaresObserver(observer_form())
    forgetful = RecursiveLeastSquaresObserver(observer_form(), memory=5.0)
    changed = (1.8, 2.3, 1.2, 1.0, 0.9, 0.8)
    t = T * np.arange(6001)
    u = lambda s: (rich_input(s),)  # noqa: E731
    before = trajectory(lasting.model, t[:2001], u, (0.0, 0.0, 0.0), MINIMUM_PHASE)
    after = trajectory(lasting.model, t[2000:], u, before[-1], changed)
    y = np.concatenate([before[:, 0], after[1:, 0]])
    for k, value in enumerate(y):
        sample = Sample(round(k * T * 1e9), u=np.array([rich_input(k * T)]), y=np.array([value]))
        for observer in (lasting, forgetful):
            observer.absorb(sample)
    errors = [np.abs(observer.p - changed).max() for observer in (lasting, forgetful)]
    assert errors[1] < 0.1 < errors[0]


def test_plants_of_other_orders_are_fine_with_their_own_choices() -> None:
    model = replace(
        observer_form(),
        name='second_order',
        states=(Variable('x1', lower=-9.0, upper=9.0), Variable('x2', lower=-9.0, upper=9.0)),
        parameters=tuple(Variable(n, lower=-5.0, upper=5.0) for n in ('a1', 'a0', 'b1', 'b0')),
        dynamics=lambda t, x, u, p: (x[1] - p[0] * x[0] + p[2] * u[0], p[3] * u[0] - p[1] * x[0]),
    )
    p = (1.5, 2.0, 0.5, 1.0)
    observer = RecursiveLeastSquaresObserver(
        model, observer=(8.0, 16.0), filter=(2.0, 1.0), a=(1.0, 1.0), b=(0.0, 0.0)
    )
    t = T * np.arange(1001)
    x = trajectory(model, t, lambda s: (rich_input(s),), (0.0, 0.0), p)
    for k, now in enumerate(t):
        observer.absorb(Sample(round(now * 1e9), u=np.array([rich_input(now)]), y=x[k, :1]))
    assert observer.p == pytest.approx(p, abs=1e-3)
    assert observer.x == pytest.approx(x[-1], abs=1e-2)
