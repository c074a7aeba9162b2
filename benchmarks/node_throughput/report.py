"""Tables of the messages into the node."""

from benchmarks.node_throughput.run import Case, Measured
from benchmarks.report import Requirement, filled, requirements, table

TOLD = ('published', 'withheld', 'failed', 'skipped', 'solve_time_s', 'latency_s')


def report(case: Case, found: Measured) -> str:
    """Return the report on one case."""
    counts = {f'{s}s lost': f'{s}.received' for s in ('input', 'output')}
    if case.observer != 'sliding_window':
        counts['estimates missing'] = 'published'
    lost = {name: found.sent - int(found.figures[figure]) for name, figure in counts.items()}
    kept = {k: v for k, v in found.figures.items() if k.startswith('samples.') and v != '0'}
    received = max(1, int(found.figures['output.received']))
    busy = 1e3 * found.shares['estimator'] * found.wall / received
    asked = (
        Requirement(f'{name} of {found.sent}: none', str(value), value == 0)
        for name, value in lost.items()
    )
    told = [*((name, found.figures.get(name, '-')) for name in TOLD), *sorted(kept.items())]
    shares = found.shares.items()
    return filled(
        'node_throughput/report',
        case=case,
        seconds=found.sent // case.rate,
        requirements=requirements(asked),
        figures=table({'of the node': name, 'value': value} for name, value in told),
        shares=table({'process': name, 'CPU share': f'{share:.2f}'} for name, share in shares),
        wall=found.wall,
        busy=busy,
    )
