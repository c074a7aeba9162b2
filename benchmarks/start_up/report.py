"""Table of the starts."""

from collections.abc import Mapping, Sequence

import numpy as np

from benchmarks.report import Requirement, filled, requirements, table
from benchmarks.start_up.run import PHASES, Start

LIMITS = {'cold': 15.0, 'warm': 3.0}  # s


def report(starts: Mapping[str, Sequence[Start]]) -> str:
    """Return the report."""
    medians = {
        cache: {name: float(np.median([start[name] for start in own])) for name in own[0]}
        for cache, own in starts.items()
    }
    seconds = table(
        {
            'kernel cache': cache,
            'starts': len(own),
            'wall (s)': f'{medians[cache]["wall"]:.2f}',
            'fastest (s)': f'{min(start["wall"] for start in own):.2f}',
            'process time (s)': f'{medians[cache]["cpu"]:.2f}',
            **{f'{phase} (s)': f'{medians[cache][phase]:.2f}' for phase in PHASES},
        }
        for cache, own in starts.items()
    )
    asked = [
        Requirement(f'{cache}: wall <= {limit:g} s', f'{wall:.2f} s', wall <= limit)
        for cache, limit in LIMITS.items()
        for wall in (medians[cache]['wall'],)
    ]
    return filled('start_up/report', seconds=seconds, requirements=requirements(asked))
