"""Plants whose functions choose: the price of a plain step."""

from typing import Any

import numpy as np
import pytest

from benchmarks.runner import cpu_seconds
from benchmarks.selects.models import BRIM, spring, tanks
from benchmarks.selects.run import window
from obs_ros import Model
from obs_ros.integration.vectorised import NumpyKernels

MARGIN = 10.0  # times the plain step; measured 1.0 to 2


def frictions(v: Any) -> Any:
    return np.sign(v) + np.where(v > 0, 1.0, np.where(v < 0, -1.0, 0)) + np.clip(50 * v, -1, 1)


def overflows(h: Any) -> Any:
    return (
        np.where(h > BRIM, h - BRIM, 0.0)
        + np.clip(h - BRIM, 0, None)
        + np.maximum(h - BRIM, 0)
        + (h - np.minimum(h, BRIM))
        + (h - BRIM) * np.heaviside(h - BRIM, 0.0)
        + np.fmax(h, BRIM) - np.fmin(h, BRIM)
        + ((h > BRIM) & np.logical_and(h > 0, h < 1e3)) * (h - BRIM)
    )  # fmt: skip


@pytest.mark.parametrize(
    ('plain', 'choosing'),
    [(spring(lambda v: v), spring(frictions)), (tanks(lambda h: h), tanks(overflows))],
    ids=['spring', 'tanks'],
)
def test_a_plant_that_chooses_costs_about_what_a_plain_one_costs(
    plain: Model, choosing: Model
) -> None:
    """np.where made the step 200 times slower, in silence, and np.clip kept it from compiling."""
    pytest.importorskip('numba')
    from obs_ros.integration.compiled import CompiledKernels

    prefixes = np.array([200])

    def fastest(model: Model) -> float:
        grid, x0, p = window(model, 200, 64)
        kernels = CompiledKernels(model)
        found = kernels.squares(grid, prefixes, x0, p)
        np.testing.assert_allclose(found, NumpyKernels(model).squares(grid, prefixes, x0, p), 1e-9)
        return min(
            cpu_seconds(lambda: kernels.squares(grid, prefixes, x0, p), 3) for _ in range(20)
        )

    assert fastest(choosing) < MARGIN * fastest(plain)
