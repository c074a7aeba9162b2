"""Values of saturated sensors are counted by output."""

import numpy as np

from obs_ros import Variable
from obs_ros.samples.saturation_count import SaturationCount


def test_only_outputs_with_a_range_are_counted() -> None:
    counted = SaturationCount([Variable('a', range=(0.0, 1.0)), Variable('b')])
    for y in ([0.0, 0.0], [0.5, 0.0], [1.0, 1.0], [1.2, np.nan], [np.nan, 1.0]):
        counted.note(np.array(y))
    assert counted.counts == {'saturated.a': 3}


def test_without_ranges_there_are_no_counts() -> None:
    counted = SaturationCount([Variable('a'), Variable('b')])
    counted.note(np.zeros(2))
    assert counted.counts == {}
