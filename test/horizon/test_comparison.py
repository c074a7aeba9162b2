"""Tests of obs_ros.horizon.comparison."""

from dataclasses import replace

import numpy as np
import pytest
from jump_windows import record, still

from obs_ros.horizon.comparison import compared, figures_of
from obs_ros.horizon.forecasts import Forecasts
from obs_ros.horizon.scatter import SCATTER, Scatter
from obs_ros.inference.assessment.informed_subspace import marginal_information
from obs_ros.inference.assessment.uncertainty import Uncertainty
from obs_ros.inference.jumps.hypothesis import Hypothesis


def uncertainty(best: Hypothesis, skill: float | None = None) -> Uncertainty:
    return Uncertainty(best, best.covariance, marginal_information(best, 1), skill=skill)


def test_scatter_beyond_the_deviations_raises_them() -> None:
    """The drift of every other window lies six deviations off."""
    scatter, found = Scatter(), None
    for k in range(SCATTER.most):
        window = record(seed=k)
        moved = replace(
            window, t=window.t + 20.0 * k, y=window.y + 0.03 * (k % 2) * window.t[:, None]
        )
        best = still(moved)
        found = compared(uncertainty(best, 0.5), Forecasts(), scatter, 'said so')
    assert found is not None and found.scatter is not None
    assert found.skill == 0.5 and found.said == 'said so'
    assert found.scatter[1] > 1.5
    before, after = (np.diagonal(c)[1:] for c in (best.covariance, found.covariance))
    np.testing.assert_allclose(after, before * np.fmax(found.scatter, 1.0) ** 2)
    figures = figures_of(found)
    assert figures['forecast_skill'] == 0.5
    assert figures['scatter_over_sd.drift'] == pytest.approx(found.scatter[1])


def test_without_a_comparison_there_are_no_figures() -> None:
    assert figures_of(uncertainty(still(record()))) == {}
