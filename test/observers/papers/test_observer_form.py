"""Tests of obs_ros.observers.papers.observer_form, of all observers that build on it."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from observer_form import MINIMUM_PHASE, experiment
from plants import OSCILLATOR, observer_form

from obs_ros import Sample
from obs_ros.models.three_tank import THREE_TANK
from obs_ros.observers.papers.adaptive_luenberger import AdaptiveLuenbergerObserver
from obs_ros.observers.papers.rls_luenberger import RecursiveLeastSquaresObserver


@pytest.mark.parametrize('kind', [AdaptiveLuenbergerObserver, RecursiveLeastSquaresObserver])
def test_what_is_given_is_not_adapted_and_starts_are_taken(kind: Any) -> None:
    observer = kind(observer_form(), fixed={'a1': 2.1}, initial={'b1': 0.75})
    assert observer.initial.tolist() == [0.0, 0.0, 0.0, 3.0, 2.1, 1.0, 1.0, 0.75, 0.0]
    experiment(observer, MINIMUM_PHASE, 5.0)
    assert observer.p[1] == 2.1 and observer.p[0] != 3.0


@pytest.mark.parametrize('kind', [AdaptiveLuenbergerObserver, RecursiveLeastSquaresObserver])
def test_other_plants_and_unstable_choices_are_refused(kind: Any) -> None:
    model = observer_form()
    upside_down = replace(model, dynamics=lambda t, x, u, p: model.dynamics(t, x, u, p)[::-1])
    for other, reason in (
        (THREE_TANK, 'has 2 inputs, 2 outputs and 3 parameters'),
        (OSCILLATOR, 'observer form'),
        (upside_down, 'is not in observer form'),
        (replace(model, output=lambda t, x, u, p: (x[1],)), 'is not in observer form'),
    ):
        with pytest.raises(ValueError, match=reason):
            kind(other)
    with pytest.raises(ValueError, match=r'observer .* is not stable'):
        kind(model, observer=(12.0, 47.0, -60.0))
    with pytest.raises(ValueError, match=r'filter \(2.0, 1.0\) has 2 entries, but .* of order 3'):
        kind(model, filter=(2.0, 1.0))


@pytest.mark.parametrize('kind', [AdaptiveLuenbergerObserver, RecursiveLeastSquaresObserver])
def test_coarse_samples_are_integrated_in_steps_of_the_observer_s_own(kind: Any) -> None:
    """Outputs every 2 s, over which one RK4 step diverges from the observer's poles at -3 to -5."""
    found = []
    for longest in (math.inf, 0.01):
        observer = kind(replace(observer_form(), max_step=longest))
        for k in range(30):
            u, y = np.array([math.sin(0.5 * k)]), np.array([math.cos(0.3 * k)])
            observer.absorb(Sample(2_000_000_000 * k, u=u, y=y))
        found.append([*observer.x, *observer.p])
    assert found[0] == pytest.approx(found[1], rel=1e-3, abs=1e-3)
