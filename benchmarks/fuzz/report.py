"""Tables of malformed messages."""

from benchmarks.fuzz.run import Fuzzed
from benchmarks.report import Requirement, filled, requirements, table

MESSAGES = 10_000  # asked for


def report(found: Fuzzed) -> str:
    """Return the report."""
    failed, last = found.figures['failed'], found.last
    counts = {
        name: value
        for name, value in found.figures.items()
        if name.startswith(('samples.', 'output.', 'input.')) and value.isdecimal() and value != '0'
    }
    asked = [
        Requirement(f'messages, malformed and sound, >= {MESSAGES}', str(found.sent),
                    found.sent >= MESSAGES),
        Requirement('all counted', f'{found.uncounted} not', found.uncounted == 0),
        Requirement('no error of the observer', failed, failed == '0'),
        Requirement('published numbers are finite', f'{found.non_finite} not',
                    found.non_finite == 0),
        Requirement('an estimate afterwards', str(bool(last)), bool(last)),
        Requirement('exit code 0, no traceback', str(found.code),
                    found.code == 0 and not found.traceback),
    ]  # fmt: skip
    return filled(
        'fuzz/report',
        requirements=requirements(asked),
        figures=table({'counted by the node': k, 'value': v} for k, v in sorted(counts.items())),
        estimate=', '.join(f'{name} {value:.3f}' for name, value in last.items()),
    )
