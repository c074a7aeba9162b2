"""Windows of recorded plants, with process noise off and found: outcomes, scatter, forecasts.

The recordings lie beside the repository, in ../shared/data, or where --data says.
"""

import sys
from pathlib import Path

from benchmarks.real_plants.plants import PLANTS
from benchmarks.real_plants.report import forecasts_table, outcomes_table, scatter_table
from benchmarks.real_plants.run import recorded, solved, starts
from benchmarks.report import filled, publish
from benchmarks.runner import ROOT, monte_carlo, options


def main(arguments: list[str] | None = None) -> str:
    """Solve all windows of the recordings that are there, print, and write the report."""
    parser = options(__doc__)
    parser.add_argument('--data', type=Path, default=ROOT.parent / 'shared' / 'data')
    chosen = parser.parse_args(arguments)
    cells = {}
    for name, plant in PLANTS.items():
        if not (chosen.data / plant.file).is_file():
            print(f'{name}: left out, there is no {chosen.data / plant.file}', file=sys.stderr)
            continue
        times = starts(plant, recorded(name, chosen.data))
        for mode in ('off', 'auto'):
            cells[name, mode] = [(name, str(chosen.data), mode, time) for time in times]
    if not cells:
        print('no recording is there: name their folder with --data', file=sys.stderr)
        return ''
    found = monte_carlo(solved, cells, 'windows')
    text = filled(
        'real_plants/report',
        outcomes=outcomes_table(found),
        scatter=scatter_table(found),
        forecasts=forecasts_table(found),
    )
    return publish(chosen.results, 'real_plants', 'Recorded plants', text)


if __name__ == '__main__':
    main()
