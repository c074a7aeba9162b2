"""Sensors, actuators and functions as they are: every figure that is asked of them.

Outliers, wrapped angles, offsets in time, coarse and saturated sensors, ways of writing functions,
advice. Recordings lie beside the repository, in ../shared/data, or where --data says.
"""

import argparse
import sys
from collections.abc import Callable, Mapping
from pathlib import Path

from benchmarks.recordings import FOLDER, PLANTS
from benchmarks.report import Requirement, filled, publish, requirements
from benchmarks.runner import options
from benchmarks.sensors import angles, coarse, delays, functions, outliers, spiked

Part = Callable[[argparse.Namespace], tuple[list[Requirement], str]]

# What --quick measures in place of the defaults: it shows that all works, and no figure.
QUICK = {'runs': 2, 'windows': 8}
PARTS: Mapping[str, tuple[str, Part]] = {
    'outliers': (
        'Outliers on a spring: 50 Hz, windows of 3 s, noise of 4 mm',
        lambda chosen: outliers.measured(chosen.runs, chosen.seed, chosen.against),
    ),
    'recordings': (
        'Recordings with spikes: 1 % of the values, off by 5 to 30 deviations of the noise',
        lambda chosen: spiked.measured(chosen.data, chosen.windows),
    ),
    'angles': (
        'Angles that wrap',
        lambda chosen: angles.measured(4 * chosen.runs, chosen.seed, chosen.data),
    ),
    'delays': (
        'Offsets in time: 40 dB, windows of 500 samples',
        lambda chosen: delays.measured(2 * chosen.runs, chosen.seed),
    ),
    'coarse': (
        'Coarse and saturated sensors and actuators',
        lambda chosen: coarse.measured(chosen.runs, chosen.seed, chosen.data),
    ),
    'functions': (
        'Ways of writing functions',
        lambda chosen: functions.measured(chosen.runs, chosen.seed),
    ),
}
RECORDINGS = {
    'recordings': [PLANTS[name].file for name in spiked.SPIKED],
    'angles': [angles.RECORDING],
    'coarse': [PLANTS[coarse.BOARD].file],
}


def main(arguments: list[str] | None = None) -> str:
    """Measure the parts that are chosen, print, and write the report."""
    parser = options(__doc__, shared=True)
    parser.add_argument('--runs', type=int, default=20, help='of ten windows, in each cell')
    parser.add_argument('--windows', type=int, help='of each recording with spikes, not all')
    parser.add_argument('--seed', type=int, default=160_000, help='of the first run')
    parser.add_argument('--only', choices=PARTS, nargs='+', default=list(PARTS), help='some parts')
    parser.add_argument('--data', type=Path, default=FOLDER, help='folder of the recordings')
    parser.add_argument('--against', type=Path, help='another source tree, to compare times with')
    parser.add_argument('--quick', action='store_true', help=f'{QUICK}, to see that it works')
    chosen = parser.parse_args(arguments)
    if chosen.quick:
        vars(chosen).update(QUICK)
    missing = left_out(chosen.only, chosen.data)
    for line in missing:
        print(line, file=sys.stderr)
    rows, sections = [], []
    for name in PARTS:
        if name in chosen.only:
            title, measure = PARTS[name]
            own, text = measure(chosen)
            rows += own
            sections.append(f'## {title}\n\n{text}')
    text = filled(
        'sensors/report',
        seed=chosen.seed,
        left_out='\n'.join(f'- {line}' for line in missing),
        acceptance=requirements(rows),
        parts='\n\n'.join(sections),
    )
    return publish(chosen.results, 'sensors', 'Sensors, actuators and functions as they are', text)


def left_out(parts: list[str], folder: Path) -> list[str]:
    """Return what the parts leave out, as a recording is not there."""
    files = [(part, file) for part in parts for file in RECORDINGS.get(part, [])]
    return [
        f'{part}: left out, there is no {folder / file}'
        for part, file in files
        if not (folder / file).is_file()
    ]


if __name__ == '__main__':
    main()
