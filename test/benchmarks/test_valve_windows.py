"""Sliding windows on the heat exchanger: the words about its valves."""

import numpy as np
import pytest

from benchmarks.interconnected.window_report import PRODUCT
from benchmarks.interconnected.windows import SIZES, isolated, watched

pytestmark = pytest.mark.slow


@pytest.mark.parametrize('parameters', [('dP1', 'k1'), ('dP1', 'dP2', 'k1', 'k2')])
def test_at_constant_pressures_only_products_are_claimed(parameters: tuple[str, ...]) -> None:
    found = watched(moving=False, seed=3, parameters=parameters)
    assert all(any(text.startswith(PRODUCT) for text in weak) for weak in found.weak)
    assert np.isnan(found.p_sd).all()
    # The flows, and with them the temperatures, are known all the same.
    assert np.isfinite(found.x_sd[:, :2]).all()
    assert (np.abs(found.x_error[:, :2]) < 3.5 * found.x_sd[:, :2]).all()
    assert found.alarms == 0


@pytest.mark.parametrize('parameter', SIZES)
def test_a_fault_names_its_valve_within_two_seconds(parameter: str) -> None:
    found = isolated(parameter, sigma=0.05, correlation=0.1, seed=3)
    assert found.named
    assert found.partner
    assert abs(found.error) < 0.5
    assert found.false == 0
