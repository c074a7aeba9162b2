"""Seeds make generators."""

from typing import Any

import numpy as np
import pytest

from obs_ros.core.rng import random_generator


def test_same_seeds_draw_the_same_and_others_do_not() -> None:
    one, same, other = (random_generator(*seeds).random(9) for seeds in ((3, 1), (3, 1), (3, 2)))
    np.testing.assert_array_equal(one, same)
    assert not np.isclose(one, other).any()
    np.testing.assert_array_equal(random_generator(7).random(9), np.random.default_rng(7).random(9))


@pytest.mark.parametrize('seed', [-1, 1.0, None])
def test_what_is_no_seed_is_refused(seed: Any) -> None:
    with pytest.raises(ValueError, match='seed must be an integer >= 0, not '):
        random_generator(0, seed)
