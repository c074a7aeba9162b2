"""Windows of recorded plants, with process noise off and found: outcomes, scatter, forecasts.

The recordings lie beside the repository, in ../shared/data, or where --data says.
"""

import sys
from functools import partial
from pathlib import Path

from benchmarks.real_plants.acceptance import acceptance
from benchmarks.real_plants.pictures import PLANT, draw_ball
from benchmarks.real_plants.report import (
    forecasts_table,
    nearness_table,
    outcomes_table,
    scatter_table,
)
from benchmarks.real_plants.run import in_sequence, solved
from benchmarks.recordings import FOLDER, PLANTS, recorded, starts
from benchmarks.report import filled, pictures, publish, requirements
from benchmarks.runner import monte_carlo, options

MODES = ('off', 'auto')


def main(arguments: list[str] | None = None) -> str:
    """Solve all windows of the recordings that are there, print, and write the report."""
    parser = options(__doc__, shared=True)
    parser.add_argument('--data', type=Path, default=FOLDER)
    chosen = parser.parse_args(arguments)
    names = []
    for name, plant in PLANTS.items():
        if (chosen.data / plant.file).is_file():
            names.append(name)
        else:
            print(f'{name}: left out, there is no {chosen.data / plant.file}', file=sys.stderr)
    if not names:
        print('no recording is there: name their folder with --data', file=sys.stderr)
        return ''
    pairs, folder = [(name, mode) for name in names for mode in MODES], str(chosen.data)
    alone = {
        (name, mode): [
            (name, folder, mode, start)
            for start in starts(PLANTS[name], recorded(name, chosen.data))
        ]
        for name, mode in pairs
    }
    runs = {(name, mode): [(name, folder, mode)] for name, mode in pairs}
    found, followed = (
        monte_carlo(solved, alone, 'windows'),
        monte_carlo(in_sequence, runs, 'sequences'),
    )
    cells = {}
    for pair in pairs:
        cells[*pair, 'alone'], cells[*pair, 'in sequence'] = found[pair], followed[pair][0]
    drawn = {}
    if PLANT in names:
        title = f'{PLANT}: a and forecasts of a second, process noise off and auto'
        drawn['real_plants_ball.png'] = title, partial(draw_ball, chosen.data)
    text = filled(
        'real_plants/report',
        outcomes=outcomes_table(cells),
        scatter=scatter_table(cells),
        nearness=nearness_table(cells),
        forecasts=forecasts_table(cells),
        acceptance=requirements(acceptance(cells)),
        pictures=pictures(chosen.results, drawn),
    )
    return publish(chosen.results, 'real_plants', 'Recorded plants', text)


if __name__ == '__main__':
    main()
