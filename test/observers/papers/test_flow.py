"""Tests of obs_ros.observers.papers.flow, of all observers of flows; seeds are stated."""

import numpy as np
import pytest
from exchanger import AT_REST, FLOWS, played, watched

from obs_ros import Sample
from obs_ros.models.heat_exchanger import HEAT_EXCHANGER, HEAT_EXCHANGER_REDUCED
from obs_ros.observers.papers.high_gain import HighGainObserver
from obs_ros.observers.papers.interconnected import InterconnectedObserver
from obs_ros.observers.papers.unknown_input import UnknownInputObserver

KINDS = (InterconnectedObserver, HighGainObserver, UnknownInputObserver)


@pytest.mark.parametrize(
    ('fault', 'residual', 'size', 'other'),
    [
        ((1.0, 'dP1', 4.0e5), 'residual_Fu', 0.2247, 'residual_Fp'),
        ((1.0, 'k2', 7089.0), 'residual_Fp', 0.1642, 'residual_Fu'),
    ],
)
def test_a_fault_moves_the_residual_of_its_valve_only(
    fault: tuple[float, str, float], residual: str, size: float, other: str
) -> None:
    instants = played('heat_exchanger_case1', 10.0, AT_REST, fault)
    for kind in KINDS:
        observer = kind('heat_exchanger')
        watched(observer, instants[:1000], 'flows')
        assert abs(observer.figures[residual]) < 1e-3
        watched(observer, instants[1000:], 'flows')
        assert observer.figures[residual] == pytest.approx(size, abs=0.005)
        assert abs(observer.figures[other]) < 0.005


@pytest.mark.parametrize('kind', KINDS)
@pytest.mark.parametrize(
    ('model', 'starts', 'backend'),
    [(HEAT_EXCHANGER, 30, None), (HEAT_EXCHANGER_REDUCED, 1, 'numpy')],
)
def test_from_any_start_it_stays_finite_and_within_bounds(
    kind: type, model: object, starts: int, backend: str | None
) -> None:
    """From random starts of the observer (seed 3), with random measurements and gaps."""
    rng = np.random.default_rng(3)
    for _ in range(starts):
        setting = {'tau': (0.02,)} if kind is UnknownInputObserver else {'theta': 80.0}
        initial = {v.name: rng.uniform(v.lower, v.upper) for v in model.states}
        observer = kind(model, initial=initial, start_flow=rng.uniform(0.0, 5.0),
                        backend=backend, **setting)  # fmt: skip
        period = model.max_step
        for k in range(60):
            y = rng.uniform(0.0, 100.0, 2) if k < 30 else np.array([76.0, 15.0])
            y[rng.random(2) < 0.2] = np.nan
            u = rng.uniform(0.0, 2.0e6, 2)
            observer.absorb(Sample(round(k * period * 1e9), y=y, u=u))
            assert np.isfinite(observer.x).all()
            assert np.isfinite(list(observer.figures.values())).all()
            assert (observer.flows >= 0.0).all()
            assert (observer.flows <= 5.0 * FLOWS * (1.0 + 1e-12)).all()
        assert observer.counts['reset_non_finite'] == 0


def test_the_initial_temperature_is_the_first_output_unless_given() -> None:
    instants = played('heat_exchanger_case1', 8.0)[:1]
    for settings, expected in (
        ({}, (80.0, 20.0)),
        ({'initial': {'Tp': 31.0}}, (31.0, 20.0)),
        ({'fixed': {'Tu': 32.0}}, (80.0, 32.0)),
    ):
        observer = InterconnectedObserver('heat_exchanger', **settings)
        watched(observer, instants, 'flows')
        assert tuple(observer.x[:2]) == expected


@pytest.mark.parametrize('kind', KINDS)
def test_other_plants_and_parameters_are_refused(kind: type) -> None:
    with pytest.raises(ValueError, match="three_tank' does not"):
        kind('three_tank')
    with pytest.raises(ValueError, match='estimates states only'):
        kind('heat_exchanger', parameters=['k1'])
