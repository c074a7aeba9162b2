"""Tests of obs_ros.integration.compiled_own_steps."""

import numpy as np
import pytest

pytest.importorskip('numba')
from obs_ros.integration.compiled_own_steps import laid
from obs_ros.integration.path import LANES


def test_candidates_fill_whole_chunks_beside_their_leaders() -> None:
    x0, p = np.arange(42.0).reshape(2, 21), np.arange(21.0)[None]
    layout, x, q = laid(x0, p, 7)
    assert x.shape == (2, 2 * LANES) and q.shape == (1, 2 * LANES)
    np.testing.assert_array_equal(x[:, layout.place], x0)
    assert (q[0, layout.lead[1] + LANES] == 14.0).all()
    assert x.flags.c_contiguous and q.flags.c_contiguous
