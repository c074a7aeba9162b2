"""A trial is integrated as a window would be, and its error is told."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from obs_ros import Model, Record, Variable
from obs_ros.cli.model_steps import integrated
from obs_ros.integration.grid import Grid

STIFF = Model(
    name='stiff',
    states=(Variable('fast', lower=-2.0, upper=2.0), Variable('slow', lower=-2.0, upper=2.0)),
    outputs=(Variable('slow'),),
    parameters=(Variable('rate', lower=5e3, upper=2e4, nominal=1e4),),
    dynamics=lambda t, x, u, p: (-p[0] * (x[0] - x[1]), -np.sin(x[0])),
    output=lambda t, x, u, p: (x[1],),
)


@pytest.mark.parametrize('noise', [1e-2, 1e-4])
def test_a_stiff_plant_gets_implicit_steps_whose_error_is_below_the_noise(noise):
    t = np.linspace(0.0, 2.0, 41)
    record = Record(t, np.zeros((41, 0)), np.zeros((41, 1)))
    scale, x0, p = np.array([noise]), np.array([-1.0, 1.0]), np.array([1e4])
    kernels, grid, error = integrated(STIFF, record, scale, x0, p, 'numpy')
    assert kernels.model.method == 'rosenbrock' and grid.steps.sum() < 4000
    truth = solve_ivp(
        lambda s, x: STIFF.dynamics(s, tuple(x), (), (1e4,)), (0.0, 2.0), x0,
        method='Radau', t_eval=t, rtol=1e-10, atol=1e-13,
    ).y[1]  # fmt: skip
    grid = Grid.of(kernels.model, record, scale).like(grid)
    found = kernels.trajectories(grid, x0[:, None], p[:, None])[1][:, 0, 0]
    assert np.abs(found - truth).max() / noise <= 0.3
    assert error <= 0.3
