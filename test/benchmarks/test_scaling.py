"""The growth of the cost."""

import pytest

from benchmarks.scaling.curve import Curve


def test_growth_is_fitted_over_all_and_over_the_upper_half():
    x = [1.0, 10.0, 100.0, 1000.0]
    assert Curve('', '', x, [1.0, 1.0, 1.0, 100.0], (), (), '').exponents == pytest.approx((0.6, 2))
