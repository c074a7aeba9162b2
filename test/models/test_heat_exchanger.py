"""Tests of obs_ros.models.heat_exchanger against its steady states and Zhang et al. 2020."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

from obs_ros.models import heat_exchanger as plant
from obs_ros.models.heat_exchanger import HEAT_EXCHANGER, HEAT_EXCHANGER_REDUCED

PRESSURES = (1.0e6, 1.2e6)
NOMINAL = (6.0e5, 6.0e4, 6089.0, 6089.0)
CLOGGED = (4.0e5, *NOMINAL[1:])  # dP1 falls at 80 s
WORN = (*CLOGGED[:3], 7089.0)  # k2 rises at 150 s


def at_rest(p: tuple[float, ...]) -> np.ndarray:
    """Temperatures, openings and their rates where nothing changes any more."""
    return fsolve(
        lambda x: HEAT_EXCHANGER.dynamics(0.0, tuple(x), PRESSURES, p), [24, 20, 5, 0, 5, 0]
    )


@pytest.mark.parametrize(
    ('p', 'tp', 'tu'),
    [(NOMINAL, 24.303, 20.108), (CLOGGED, 25.258, 21.141), (WORN, 24.025, 20.403)],
)
def test_temperatures_at_rest(p: tuple[float, ...], tp: float, tu: float) -> None:
    rest = at_rest(p)
    assert rest[:2] == pytest.approx([tp, tu], abs=0.02)
    assert rest[[3, 5]] == pytest.approx([0.0, 0.0], abs=1e-9)


def test_valves_are_calibrated_to_the_papers_flows() -> None:
    x1, x2 = plant.DIAPHRAGM_AREA * 1.0e6 / 6089.0, plant.DIAPHRAGM_AREA * 1.2e6 / 6089.0
    assert plant.flow1(6.0e5, x1) == pytest.approx(4.22e-5, rel=1e-6)
    assert plant.flow2(6.0e4, x2) == pytest.approx(4.17e-6, rel=1e-6)
    assert pytest.approx(4.22e-5 / (np.sqrt(6.0e5) * x1), rel=1e-4) == plant.CV1
    assert pytest.approx(4.17e-6 / (np.sqrt(6.0e4) * x2), rel=1e-4) == plant.CV2


def test_coefficients_of_heat_transfer() -> None:
    assert pytest.approx(1.91388, rel=1e-5) == plant.AP
    assert pytest.approx(0.450373, rel=1e-5) == plant.AU


def test_heat_given_off_by_one_fluid_is_taken_up_by_the_other() -> None:
    tp, tu, *_ = at_rest(WORN)
    x1, x2 = at_rest(WORN)[[2, 4]]
    given = plant.flow2(6.0e4, x2) * (plant.TPI - tp)
    taken = plant.flow1(4.0e5, x1) * (tu - plant.TUI)
    assert given == pytest.approx(taken, rel=1e-9)


def test_the_stem_has_the_two_poles_of_the_specification() -> None:
    eigenvalues = np.sort(np.roots([plant.STEM_MASS, plant.FRICTION, 6089.0]))
    assert eigenvalues == pytest.approx([-745.9, -4.08], rel=1e-3)
    assert HEAT_EXCHANGER.max_step * 745.9 < 2.785  # RK4 is stable up to there


def test_without_inertia_the_temperatures_are_nearly_the_same() -> None:
    """A stem sluggish by 1.3 ms (m / mu) shifts openings by so much, no more."""
    pressures = (1.2e6, 0.96e6)
    full, reduced = (
        solve_ivp(
            lambda t, x, model=model: model.dynamics(t, tuple(x), pressures, NOMINAL),
            (0.0, 2.0),
            start,
            method='LSODA',
            rtol=1e-9,
            atol=1e-9,
            t_eval=np.linspace(0.0, 2.0, 41),
        ).y
        for model, start in (
            (HEAT_EXCHANGER, [24.3, 20.1, 4.76, 0.0, 5.72, 0.0]),
            (HEAT_EXCHANGER_REDUCED, [24.3, 20.1, 4.76, 5.72]),
        )
    )
    assert np.abs(full[0] - full[0, 0]).max() > 0.3
    np.testing.assert_allclose(full[:2], reduced[:2], atol=2e-3)
