"""Tables of the messages into the node."""

from benchmarks.node_throughput.run import Case, Measured
from benchmarks.report import Requirement, requirements, table

TOLD = ('published', 'withheld', 'failed', 'skipped', 'solve_time_s', 'latency_s')


def report(case: Case, found: Measured) -> list[str]:
    """Return the parts of the report on one case."""
    counts = {f'{s}s lost': f'{s}.received' for s in ('input', 'output')}
    if case.observer != 'sliding_window':
        counts['estimates missing'] = 'published'
    lost = {name: found.sent - int(found.figures[figure]) for name, figure in counts.items()}
    kept = {k: v for k, v in found.figures.items() if k.startswith('samples.') and v != '0'}
    received = max(1, int(found.figures['output.received']))
    busy = 1e3 * found.shares['estimator'] * found.wall / received
    return [
        f'## {case.observer}: {case.rate} outputs and {case.rate} inputs a second, '
        f'{found.sent // case.rate} s of {case.scenario}',
        requirements(
            Requirement(f'{name} of {found.sent}: none', str(value), value == 0)
            for name, value in lost.items()
        ),
        table(
            {'of the node': name, 'value': value}
            for name, value in [
                *((name, found.figures.get(name, '-')) for name in TOLD),
                *sorted(kept.items()),
            ]
        ),
        table(
            {'process': name, 'CPU share': f'{share:.2f}'} for name, share in found.shares.items()
        ),
        f'Published within {found.wall:.2f} s. The estimator took {busy:.2f} ms of CPU for each '
        'output received, with its input and what it published.',
    ]
