"""The report on jumps on plants that nobody has tuned to."""

from benchmarks.report import filled, requirements, table
from benchmarks.sequence.jumps_elsewhere import acceptance, scenes, tables
from benchmarks.sequence.jumps_elsewhere.cost import ratio
from benchmarks.sequence.jumps_elsewhere.run import Measured
from benchmarks.sequence.jumps_elsewhere.scenes import PLANTS
from benchmarks.zoo.experiments import EXPERIMENTS


def report(measured: Measured, runs: int, windows: int, seed: int) -> str:
    """Return the report."""
    cells = measured.cells
    return filled(
        'sequence/jumps_elsewhere/report',
        runs=runs,
        windows=windows,
        seed=seed,
        twice=scenes.TWICE,
        plants=plants_table(),
        acceptance=requirements(acceptance.asked(measured)),
        jumps=tables.jumps_table(cells),
        by_plant=tables.plants_table(cells),
        calibration=tables.calibration_table(cells),
        coverage=tables.coverage_table(cells),
        false=tables.false_table(cells),
        compared=compared(measured),
    )


def plants_table() -> str:
    """Tell how the plants are watched."""
    return table(
        {
            'plant': name,
            'parameters': ', '.join(v.name for v in own.model.parameters),
            'outputs': ', '.join(v.name for v in own.model.outputs),
            'window': f'{own.samples * own.interval:g} s of {own.samples} samples',
            'noise': ', '.join(f'{sd:g}' for sd in own.noise),
        }
        for name, own in ((name, EXPERIMENTS[name]) for name in PLANTS)
    )


def compared(measured: Measured) -> str:
    """Tell what the other tree says of the same runs, and the ratios of process times."""
    if not measured.theirs:
        return 'No other tree was given: `--against PATH`.'
    parts = [tables.jumps_table(measured.theirs)]
    if measured.times:
        parts.append(tables.cost_table({
            label: (sum(int((each.jumped == jumped).sum()) for each in measured.times),
                    ratio(measured.times, jumped))
            for label, jumped in (('with a jump', True), ('without', False))
        }))  # fmt: skip
    return '\n\n'.join(parts)
