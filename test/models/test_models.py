"""Tests of every model of the registry, and of how models are found."""

import math

import numpy as np
import pytest

from obs_ros import Model, Record, load_model
from obs_ros.core.model import inside
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid
from obs_ros.models import MODELS


@pytest.mark.parametrize('name', MODELS)
class TestEveryModel:
    def test_it_is_found_by_its_own_name(self, name: str) -> None:
        model = load_model(name)
        assert model.name == name
        assert load_model(MODELS[name]) is model

    def test_it_is_documented_and_every_unknown_can_be_estimated(self, name: str) -> None:
        model = load_model(name)
        assert model.reference
        assert math.isfinite(model.max_step)
        for variable in model.variables:
            assert math.isfinite(variable.lower), variable.name
            assert math.isfinite(variable.upper), variable.name
        for variable in (*model.variables, *model.inputs, *model.outputs):
            assert variable.unit, variable.name

    def test_floats_and_arrays_of_candidates_give_the_same(self, name: str) -> None:
        model = load_model(name)
        rng = np.random.default_rng(1)
        x = [rng.uniform(v.lower, v.upper, 5) for v in model.states]
        p = [rng.uniform(v.lower, v.upper, 5) for v in model.parameters]
        u = tuple(inside(v) for v in model.inputs)
        for function in (model.dynamics, model.output):
            batch = np.array(
                [np.broadcast_to(each, 5) for each in function(2.0, tuple(x), u, tuple(p))]
            )
            for i in range(5):
                single = function(2.0, tuple(a[i] for a in x), u, tuple(a[i] for a in p))
                np.testing.assert_allclose(batch[:, i], single, rtol=1e-14)

    @pytest.mark.slow
    def test_both_kernels_agree_over_its_whole_box(self, name: str) -> None:
        pytest.importorskip('numba')
        model = load_model(name)
        rng = np.random.default_rng(2)
        t = min(model.max_step, 1.0) * np.arange(40.0)
        u = np.tile([inside(v) for v in model.inputs], (t.size, 1))
        record = Record(t, u, np.zeros((t.size, len(model.outputs))))
        grid = Grid.of(model, record, np.ones(len(model.outputs)))
        x0 = np.array([rng.uniform(v.lower, v.upper, 20) for v in model.states])
        p = np.array([rng.uniform(v.lower, v.upper, 20) for v in model.parameters]).reshape(-1, 20)
        compiled, plain = (
            kernels_for(model, backend).trajectories(grid, x0, p) for backend in ('numba', 'numpy')
        )
        for a, b in zip(compiled, plain, strict=True):
            np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-9)


def test_a_model_is_returned_as_it_is() -> None:
    model = load_model('three_tank')
    assert load_model(model) is model
    assert isinstance(model, Model)


def test_an_unknown_name_gets_its_close_match() -> None:
    with pytest.raises(ValueError, match=r"unknown model 'three_tnak': did you mean 'three_tank'"):
        load_model('three_tnak')


def test_something_that_is_no_model_is_refused() -> None:
    with pytest.raises(ValueError, match=r"model 'math:pi' is a float, not an obs_ros.Model"):
        load_model('math:pi')
