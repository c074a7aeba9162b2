"""A trace of any length is kept in little memory."""

import numpy as np
import pytest

from obs_ros.replay import trace


@pytest.mark.parametrize('count', [5, 2 * trace.MOST - 1, 2 * trace.MOST, 50_000])
def test_a_trace_keeps_evenly_spaced_rows_and_never_many(count):
    kept = trace.Trace(2)
    for k in range(count):
        kept.add(k, (k, -k))
    assert min(count, trace.MOST) <= len(kept) < 2 * trace.MOST
    np.testing.assert_array_equal(kept.rows, np.column_stack([kept.stamps, -kept.stamps]))
    steps = np.diff(kept.stamps)
    assert kept.stamps[0] == 0 and (steps == steps[0]).all()
    assert count - 1 - kept.stamps[-1] < steps[0]
