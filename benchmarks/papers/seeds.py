"""Seeds of the papers' runs: no two runs, scenarios or papers share a stream.

Observers that are compared on a scenario see the same inputs and noise.
"""

import zlib

import numpy as np

ROOT_SEED = 20  # of all papers
FEWER = 20  # times: the seeds of a rate, beside those of a median alone


def few(seeds: int) -> int:
    """Return how many seeds a median has of which no rate is told, from those of a rate."""
    return max(1, seeds // FEWER)


def seeds_of(paper: str, scenario: str, runs: int) -> list[int]:
    """Return the seeds of the runs of a scenario, below 2^63; of more runs the first are the same.

    Each is drawn from a child of its own of one SeedSequence, by paper, scenario and run.
    """
    names = tuple(zlib.crc32(name.encode()) for name in (paper, scenario))
    children = (np.random.SeedSequence(ROOT_SEED, spawn_key=(*names, run)) for run in range(runs))
    return [int(child.generate_state(1, np.uint64)[0]) >> 1 for child in children]
