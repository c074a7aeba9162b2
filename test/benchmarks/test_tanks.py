"""The windows of the three tanks that benchmarks share."""

import numpy as np
import pytest

from benchmarks.tanks import paper_end, paper_levels


@pytest.mark.parametrize(
    ('window', 'levels'),
    [
        ('T1', [21.25897, 14.17197, 17.71669]),
        ('T2', [59.53719, 49.96477, 52.93330]),
        ('T3', [86.27335, 52.72873, 65.42825]),
    ],
)
def test_the_papers_windows_end_at_the_levels_that_radau_gives(window, levels):
    np.testing.assert_allclose(paper_end(window), levels, atol=1e-4)


def test_the_papers_h3_cannot_come_from_its_constants():
    assert paper_levels('T1')[:, 2].min() > 17.69
