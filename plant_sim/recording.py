"""A scenario as a table: `python -m plant_sim.recording SCENARIO FILE`, as `replay` reads it."""

import argparse
import csv
import math
import sys
from collections.abc import Sequence
from pathlib import Path

from obs_ros.core.model import names
from obs_ros.core.texts import one_line
from plant_sim.scenarios import load_scenario
from plant_sim.simulation import Simulation

MOST_ROWS = 10**7


def write(scenario: str, path: Path, seed: int = 0, duration: float | None = None) -> int:
    """Write the inputs and measured outputs of a scenario as CSV; return the number of rows.

    `duration` (s) is the scenario's own unless it is given.

    Raises ValueError for a wrong scenario, a duration that is none, or a name that is an input's
    and an output's; OSError where the file is there already, or cannot be written.
    """
    plant = Simulation(load_scenario(scenario), seed=seed)
    seconds = plant.scenario.duration if duration is None else duration
    rows = math.floor(seconds / plant.period + 1e-9) if math.isfinite(seconds) else 0
    if not 1 <= rows <= MOST_ROWS:
        raise ValueError(
            f'give a duration of {plant.period:g} to {MOST_ROWS * plant.period:g} s, '
            f'not {seconds:g}'
        )
    header = ('t', *names(plant.model.inputs), *names(plant.model.outputs))
    if len(set(header)) < len(header):
        raise ValueError(f'give inputs and outputs different names: {", ".join(header[1:])}')
    with path.open('x', newline='', encoding='utf-8') as file:
        try:
            table = csv.writer(file)
            table.writerow(header)
            for _ in range(rows):
                instant = plant.sample()
                table.writerow(map(_text, (instant.t, *instant.u, *instant.y)))
        except BaseException:
            path.unlink()  # half of a recording passes for a whole one
            raise
    return rows


def main(arguments: Sequence[str] | None = None) -> int:
    """Write what the command line names; 1, with one line on stderr, if that is impossible."""
    parser = argparse.ArgumentParser(prog='python -m plant_sim.recording', description=__doc__)
    parser.add_argument('scenario', help='a built-in name or package.module:ATTRIBUTE')
    parser.add_argument('file', type=Path, help='the table to write, which must not be there yet')
    parser.add_argument('--seed', type=int, default=0, help='of noise and random inputs')
    parser.add_argument('--duration', type=float, metavar='S', help="default: the scenario's own")
    options = parser.parse_args(arguments)
    try:
        rows = write(options.scenario, options.file, options.seed, options.duration)
    except (ValueError, OSError) as error:
        print(f'recording: {one_line(error)}', file=sys.stderr)
        return 1
    print(f'{rows} rows in {one_line(options.file)}')
    return 0


def _text(value: float) -> str:
    """Return nine digits, so that rounding stays far below the noise."""
    return f'{value:.9g}'


if __name__ == '__main__':
    sys.exit(main())
