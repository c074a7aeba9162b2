"""The plants that searches are tried on."""

import numpy as np
import pytest

from benchmarks.zoo.tank_chain import tank_chain
from obs_ros.models.three_tank import FLOW, TANK_AREA


@pytest.mark.parametrize('n', [2, 5, 8])
def test_a_row_of_tanks_keeps_what_flows(n):
    model = tank_chain(n)
    rng = np.random.default_rng(n)
    x, p = rng.uniform(5.0, 95.0, n), rng.uniform(0.2, 1.0, n)
    heads = x - np.append(x[1:], 0.0)
    flows = p * FLOW * np.sign(heads) * np.sqrt(2.0 * 981.0 * np.abs(heads))
    fed = np.append(30.0 / TANK_AREA, flows[:-1])
    np.testing.assert_allclose(model.dynamics(0.0, x, [30.0], p), fed - flows)
    assert model.output(0.0, x, [30.0], p) == tuple(x[::2])
    assert len(model.variables) == 2 * n
