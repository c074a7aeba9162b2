"""Tables of a soak."""

from benchmarks.report import Requirement, filled, requirements, table
from benchmarks.soak.run import WARM_UP, Soak

GROWTH = 0.05  # that is allowed
MESSAGES = 1_000_000  # asked for
TOLD = ('published', 'withheld', 'failed', 'skipped', 'predicted', 'prediction_latency_s')


def report(found: Soak) -> str:
    """Return the report."""
    sent, after = 2 * found.sent, found.after_warm_up
    kept = {k: v for k, v in found.figures.items() if k.startswith('samples.') and v != '0'}
    told = [*((name, found.figures.get(name, '-')) for name in TOLD), *sorted(kept.items())]
    asked = [
        Requirement(f'messages >= {MESSAGES}', str(sent), sent >= MESSAGES),
        Requirement('none lost or dropped', str(found.lost), found.lost == 0),
        Requirement(f'memory grows by < {GROWTH:.0%} after {WARM_UP:.0%} of the run',
                    f'{found.growth:.1%}', found.growth < GROWTH),
        Requirement('exit code 0, no traceback', str(found.code),
                    found.code == 0 and not found.traceback),
    ]  # fmt: skip
    return filled(
        'soak/report',
        requirements=requirements(asked),
        first=after[0],
        most=max(after),
        last=after[-1],
        figures=table({'of the node': name, 'value': value} for name, value in told),
    )
