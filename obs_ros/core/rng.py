"""The source of everything random."""

import numpy as np


def random_generator(*seeds: int) -> np.random.Generator:
    """Return the generator of these seeds; raises ValueError for a negative one."""
    for seed in seeds:
        if not isinstance(seed, int) or seed < 0:
            raise ValueError(f'seed must be an integer >= 0, not {seed!r}')
    return np.random.default_rng(seeds)
