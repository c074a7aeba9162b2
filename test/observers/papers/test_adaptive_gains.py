"""Tests of obs_ros.observers.papers.adaptive_gains."""

import numpy as np
import pytest

from obs_ros.models import load_model
from obs_ros.observers.papers.adaptive_gains import GAINS
from obs_ros.observers.papers.design.plants import suspension


@pytest.mark.parametrize('name', GAINS)
def test_gains_fit_their_model(name: str) -> None:
    model, gains = load_model(name), GAINS[name]
    n, r = len(model.states), len(model.outputs)
    assert gains.parameter in [variable.name for variable in model.parameters]
    assert len(gains.B) == n and gains.L.keys() == gains.H.keys()
    for origin in gains.L:
        assert np.shape(gains.L[origin]) == (n, r) and np.shape(gains.H[origin]) == (r,)


@pytest.mark.parametrize('origin', ['designed', 'printed'])
def test_the_suspension_with_its_gains_is_stable(origin: str) -> None:
    plant, gain = suspension(), np.array(GAINS['suspension'].L[origin])
    assert np.linalg.eigvals(plant.A - gain @ plant.C).real.max() < 0.0
