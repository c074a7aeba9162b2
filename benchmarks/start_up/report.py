"""Table of the starts."""

from collections.abc import Mapping, Sequence

import numpy as np

from benchmarks.report import Requirement, requirements, table
from benchmarks.start_up.run import PHASES, Start

LIMITS = {'cold': 15.0, 'warm': 3.0}  # s


def report(starts: Mapping[str, Sequence[Start]]) -> list[str]:
    """Return the parts of the report."""
    medians = {
        cache: {name: float(np.median([start[name] for start in own])) for name in own[0]}
        for cache, own in starts.items()
    }
    return [
        'Medians. Wall: from the start of the process to the first estimate of a three-tank window '
        'of 1000 samples and 6 unknowns, on a machine that others use too; process time: of the '
        'whole process, to its end. The phases are wall times.',
        table(
            {
                'kernel cache': cache,
                'starts': len(own),
                'wall (s)': f'{medians[cache]["wall"]:.2f}',
                'fastest (s)': f'{min(start["wall"] for start in own):.2f}',
                'process time (s)': f'{medians[cache]["cpu"]:.2f}',
                **{f'{phase} (s)': f'{medians[cache][phase]:.2f}' for phase in PHASES},
            }
            for cache, own in starts.items()
        ),
        requirements(
            Requirement(f'{cache}: wall <= {limit:g} s', f'{wall:.2f} s', wall <= limit)
            for cache, limit in LIMITS.items()
            for wall in (medians[cache]['wall'],)
        ),
    ]
