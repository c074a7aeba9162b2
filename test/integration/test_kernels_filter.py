"""Tests of obs_ros.integration.kernels_filter, the compiled pass: the NumPy one is its oracle."""

from typing import Any

import numpy as np
import pytest
from plants import NAN, OSCILLATOR
from scipy.linalg import expm

from obs_ros import Model, Record, Variable
from obs_ros.core.model import inside
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.filter_pass import FilterPass, central
from obs_ros.integration.grid import Grid
from obs_ros.models import MODELS, load_model


def oscillator_grid(seed: int = 3) -> Grid:
    rng = np.random.default_rng(seed)
    t = np.concatenate([[0.0], np.cumsum(rng.uniform(0.02, 0.3, 80))])
    y = rng.standard_normal((81, 2))
    y[rng.random((81, 2)) < 0.4] = NAN
    return Grid.of(OSCILLATOR, Record(t, rng.standard_normal((81, 1)), y), np.array([0.5, 3.0]))


OSCILLATOR_X0, OSCILLATOR_P = np.array([1.0, -0.5]), np.array([0.8, 0.7])
OSCILLATOR_NOISE = np.array([0.1, 0.3])


def oscillator_pass(backend: str, walks: Any = (0.1, 0.2, 0.05, 0.0), **changes: Any) -> FilterPass:
    return kernels_for(OSCILLATOR, backend).filter(
        oscillator_grid(), OSCILLATOR_X0, OSCILLATOR_P, np.array(walks), OSCILLATOR_NOISE, **changes
    )


@pytest.mark.parametrize('moving', [None, [], [0], [1, 0]])
def test_both_backends_agree_on_a_nonlinear_plant(moving: Any) -> None:
    pytest.importorskip('numba')
    rows = moving if moving is None else np.array(moving, np.int64)
    numpy, numba = (oscillator_pass(name, moving=rows) for name in ('numpy', 'numba'))
    assert numba.neg2_log_likelihood == pytest.approx(numpy.neg2_log_likelihood, rel=1e-9)
    for field in ('transition', 'sensitivity', 'gain', 'cross', 'S', 'means', 'covariances'):
        a, b = getattr(numba, field), getattr(numpy, field)
        np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-9 * np.nanmax(np.abs(b)), err_msg=field)


@pytest.mark.parametrize('name', MODELS)
def test_every_built_in_model_has_a_pass_that_both_backends_agree_on(name: str) -> None:
    pytest.importorskip('numba')
    model = load_model(name)
    n, q, r = len(model.states), len(model.parameters), len(model.outputs)
    rng = np.random.default_rng(2)
    t = min(model.max_step, 0.5) * np.cumsum(rng.uniform(0.5, 1.5, 40))
    u = np.array([[inside(v) for v in model.inputs]] * 40).reshape(40, -1)
    x0 = np.array([inside(v) for v in model.states])
    p = np.array([inside(v) for v in model.parameters])
    kernels = [kernels_for(model, 'numba'), kernels_for(model, 'numpy')]
    blank = Grid.of(model, Record(t, u, np.zeros((40, r))), np.ones(r))
    clean = kernels[1].trajectories(blank, x0[:, None], p[:, None])[1][:, :, 0]
    noise = 1e-2 * np.maximum(np.abs(clean).max(axis=0), 1e-3)
    grid = Grid.of(model, Record(t, u, clean + noise * rng.standard_normal(clean.shape)), noise)
    walks = np.concatenate([1e-2 * np.maximum(np.abs(x0), 0.1), np.zeros(q)])
    numba, numpy = (k.filter(grid, x0, p, walks, noise) for k in kernels)
    assert numba.neg2_log_likelihood == pytest.approx(numpy.neg2_log_likelihood, rel=1e-7)
    np.testing.assert_allclose(numba.P, numpy.P, rtol=1e-6, atol=1e-9 * numpy.P.max())
    assert (np.diag(numba.P)[:n] > 0.0).all()
    # r K chi-squared values, of a mean below 1 since nothing has pushed the states about.
    assert 0.0 < np.nanmean(numba.innovations**2 / numba.S) < 1.0 + 4.0 * np.sqrt(2.0 / (40 * r))


def test_many_states_take_forward_differences(backend: str) -> None:
    """A chain of nine integrators, and two parameters, one of them moving."""

    def chain(t: Any, x: Any, u: Any, p: Any) -> Any:
        a, b, c, d, e, f, g, h, i = x
        return p[0] - a, a - b, b - c, c - d, d - e, e - f, f - g, g - h, h - i

    model = Model(
        name='chain',
        states=tuple(Variable(f'x{i}', lower=-1.0, upper=1.0) for i in range(9)),
        outputs=(Variable('y'),),
        parameters=(Variable('in', lower=-1.0, upper=1.0), Variable('gain', lower=0.5, upper=2.0)),
        dynamics=chain,
        output=lambda t, x, u, p: (p[1] * x[8],),
        max_step=0.1,
    )
    assert not central(10)
    t = 0.1 * np.arange(50)
    grid = Grid.of(model, Record(t, None, np.sin(t)[:, None]), np.ones(1))
    walks = np.concatenate([np.full(9, 0.1), [0.2, 0.0]])
    found = kernels_for(model, backend).filter(grid, np.zeros(9), np.array([0.5, 1.5]), walks,
                                               np.full(1, 0.1))  # fmt: skip
    rate = np.diag(np.full(10, -1.0)) + np.diag(np.ones(9), -1)
    order = [9, *range(9)]  # the parameter first, as a state without dynamics
    rate[0] = 0.0
    F = expm(0.1 * rate)
    np.testing.assert_allclose(found.transition[7], F[np.ix_(range(1, 10), np.argsort(order))],
                               atol=1e-6)  # fmt: skip
    np.testing.assert_allclose(found.sensitivity[7, 0], [*[0.0] * 8, 1.5, 0.0], atol=1e-10)
