"""Tests of obs_ros.integration.series_parallel."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from plants import BLOW_UP

from obs_ros.core.prior_knowledge import with_knowledge
from obs_ros.integration.path import Stretch
from obs_ros.integration.series_parallel import measured_states, series_parallel_for
from obs_ros.models import load_model
from obs_ros.models.three_tank import THREE_TANK

BACKENDS = ['numpy', 'numba']
JET = load_model('jet_engine')
FREE = np.full(3, -np.inf), np.full(3, np.inf)


def stretch(nodes: int = 12, seed: int = 0) -> Stretch:
    rng = np.random.default_rng(seed)
    known = rng.random((nodes, 1)) < 0.7
    return Stretch(
        t=0.01 * np.arange(nodes - 1),
        dt=rng.uniform(0.005, 0.015, nodes - 1),
        u=rng.uniform(0.5, 1.5, (nodes - 1, 1)),
        y=rng.uniform(1.0, 2.0, (nodes, 1)),
        known=known,
        weight=np.array([10.0]),
    )


def candidates(count: int = 32) -> Any:
    low, high = ([getattr(v, end) for v in JET.parameters] for end in ('lower', 'upper'))
    return np.ascontiguousarray(np.random.default_rng(1).uniform(low, high, (count, 6)).T)


def by_hand(window: Stretch, x0: Any, p: Any) -> Any:
    """Squares and last states of one candidate, from equation 23 as it should read."""
    psi, r, phi = x0
    squares = 0.0
    for k, h in enumerate(window.dt):
        if k and window.known[k, 0]:
            psi = window.y[k, 0]
        psi, r, phi = (
            psi + h * p[4] * (phi - window.u[k, 0]),
            r + h * p[5] * r * (1 - phi**2 - r),
            phi + h * (-psi + p[0] + p[1] * phi - p[2] * phi**3 - p[3] * phi * r),
        )
        if window.known[k + 1, 0]:
            squares += (10.0 * (window.y[k + 1, 0] - psi)) ** 2
    return squares, (psi, r, phi)


@pytest.mark.parametrize('backend', BACKENDS)
def test_measured_states_are_replaced_before_every_step_but_the_first(backend: Any) -> None:
    window, x0, p = stretch(), np.array([1.2, 0.1, 1.1]), candidates()
    squares, ends = series_parallel_for(JET, backend).pursue(window, *FREE, x0, p)
    for lane in (0, 7, 31):
        expected, end = by_hand(window, x0, p[:, lane])
        assert squares[lane] == pytest.approx(expected, rel=1e-11)
        np.testing.assert_allclose(ends[:, lane], end, rtol=1e-11)


def test_both_backends_agree() -> None:
    window, x0, p = stretch(60), np.array([1.2, 0.1, 1.1]), candidates(48)
    box = np.array([0.0, 0.0, -0.5]), np.array([3.0, 0.2, 0.5])
    a, b = (series_parallel_for(JET, name).pursue(window, *box, x0, p) for name in BACKENDS)
    np.testing.assert_allclose(a[0], b[0], rtol=1e-9)
    np.testing.assert_allclose(a[1], b[1], rtol=1e-9)


@pytest.mark.parametrize('backend', BACKENDS)
def test_states_stay_within_their_bounds(backend: Any) -> None:
    window, x0 = stretch(), np.array([1.2, 0.1, 1.1])
    box = np.array([-1.0, 0.05, -2.0]), np.array([5.0, 0.06, 2.0])
    ends = series_parallel_for(JET, backend).pursue(window, *box, x0, candidates())[1]
    assert ends[1].min() == 0.05 and ends[1].max() <= 0.06


@pytest.mark.parametrize('backend', BACKENDS)
def test_who_diverges_leaves_the_others_alone(backend: Any) -> None:
    window, x0, p = stretch(), np.array([1.2, 0.1, 1.1]), candidates()
    calm = series_parallel_for(JET, backend).pursue(window, *FREE, x0, p)
    p[:, 3] = np.nan
    box = np.full(3, -50.0), np.full(3, 50.0)
    wild = series_parallel_for(JET, backend).pursue(window, *box, x0, p)
    assert np.isnan(wild[0][3]) and np.isnan(wild[1][:, 3]).all()
    others = np.arange(32) != 3
    assert (wild[0][others] == calm[0][others]).all()


@pytest.mark.parametrize('backend', BACKENDS)
def test_a_model_without_inputs_or_parameters(backend: Any) -> None:
    window = Stretch(np.zeros(1), np.full(1, 0.1), np.zeros((1, 0)), np.full((2, 1), 0.6),
                     np.ones((2, 1), dtype=bool), np.ones(1))  # fmt: skip
    found = series_parallel_for(BLOW_UP, backend).pursue(
        window, np.array([-9.0]), np.array([9.0]), np.array([0.5]), np.empty((0, 16))
    )
    np.testing.assert_allclose(found[0], (0.6 - 0.525) ** 2, rtol=1e-12)
    np.testing.assert_allclose(found[1], 0.525)


def test_outputs_are_found_among_the_states() -> None:
    assert measured_states(JET).tolist() == [0]
    assert measured_states(THREE_TANK).tolist() == [0, 1]
    swapped = replace(THREE_TANK, output=lambda t, x, u, p: (x[2], x[0]))
    assert measured_states(swapped).tolist() == [2, 0]
    with pytest.raises(ValueError, match='output h2 is none of the states'):
        series_parallel_for(replace(THREE_TANK, output=lambda t, x, u, p: (x[0], 2.0 * x[1])))


def test_models_that_differ_in_walks_and_priors_share_their_steps() -> None:
    known = with_knowledge(JET, {'Psi': 0.1}, {JET.parameters[0].name: (1.0, 0.1)})
    found, plain = series_parallel_for(known, 'numba'), series_parallel_for(JET, 'numba')
    assert found.model == known and {**vars(found), 'model': JET} == vars(plain)
