"""The report on everything measured."""

from benchmarks.report import filled, requirements, table
from benchmarks.sequence import acceptance, cost, information, jumps, rest, tables
from benchmarks.sequence.contestants import TIKHONOV
from benchmarks.sequence.plants import PLANTS
from benchmarks.sequence.run import Measured
from benchmarks.sequence.scenes import LAG_NOISE


def report(measured: Measured, seed: int, drawn: str) -> str:
    """Return the report, with the pictures at its end."""
    alone = measured.information
    crossings = (f'{part.crossing.mean():.1%} at {snr:g} dB' for snr, part in alone.items())
    return filled(
        'sequence/report',
        seed=seed,
        second=seed + 1,
        plants=plants_table(),
        tikhonov=TIKHONOV,
        acceptance=requirements(acceptance.asked(measured)),
        clean=tables.clean_table(measured.clean),
        suspects=tables.suspects(measured.clean),
        rest=rest.table(measured.rest),
        jumps=jumps.table(measured.jumps),
        missed=jumps.missed(measured.jumps),
        hard=tables.hard_table(measured.hard),
        noise=tables.noise_table(measured.noise),
        count=len(next(iter(alone.values())).error),
        crossings=', '.join(crossings),
        coverage=information.coverage_table(alone),
        efficiency=information.efficiency_table(alone),
        cost=cost.table(measured.cost),
        pictures=drawn,
    )


def plants_table() -> str:
    """Tell how the plants are watched."""
    rows = [
        {
            'plant': name,
            'sample': f'{plant.step:g} s',
            'window': f'{plant.duration:g} s',
            'every': f'{plant.period:g} s, or abutting',
            'inputs': f'stepped at random every {plant.hold:g} s',
            'noise': f'{LAG_NOISE:g}' if name == 'lag' else '1 cm at 0 dB, a tenth every 20 dB',
        }
        for name, plant in PLANTS.items()
    ]
    return table(rows)
