"""Tests of obs_ros.core.chi_square beside SciPy."""

import numpy as np
import pytest
from scipy.special import chdtri

from obs_ros.core.chi_square import exceeds

FREEDOM = np.unique(np.geomspace(1.0, 1e7, 200).round(1))


@pytest.mark.parametrize('tail', [1e-6, 1e-4, 1e-3, 0.05, 0.5, 0.99, 0.999])
@pytest.mark.parametrize('distance', [1e-9, 1e-6, 1e-3, 0.1, 0.9, 1.1, 3.0])  # in deviations
def test_limits_are_those_of_scipy(tail: float, distance: float) -> None:
    for freedom in FREEDOM:
        limit = float(chdtri(freedom, tail))
        off = max(distance * np.sqrt(2.0 * freedom), 4.0 * np.spacing(limit))
        assert exceeds(limit + off, freedom, tail)
        assert not exceeds(limit - off, freedom, tail)


def test_nan_exceeds_nothing_and_infinity_everything() -> None:
    for tail in (1e-9, 1e-3):
        assert not exceeds(np.nan, 3.0, tail)
        assert exceeds(np.inf, 3.0, tail)
