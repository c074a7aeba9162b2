"""Tables of a fleet."""

import numpy as np

from benchmarks.fleet.run import Measured
from benchmarks.report import Requirement, filled, requirements, table

MEMORY = 700.0  # MB that all fleets may take together
SOON, SHARE = 1.0, 0.99  # s from a window's last sample, within which this share has its estimate


def report(found: Measured) -> str:
    """Return the report."""
    load = found.load
    latencies = np.array(found.latencies or [np.inf])
    fleets = [each for name, each in found.processes.items() if name != 'senders']
    rss, pss = sum(each.rss for each in fleets), sum(each.pss for each in fleets)
    soon = float(np.mean(latencies <= SOON))
    done = found.published + found.withheld
    asked = [
        Requirement(f'resident memory of all fleets <= {MEMORY:.0f} MB', f'{rss:.0f} MB',
                    rss <= MEMORY),
        Requirement(f'messages lost of {found.sent}: none', str(found.sent - found.received),
                    found.sent == found.received),
        Requirement(f'windows skipped of {load.windows}: none',
                    f'{found.skipped} skipped, {done} solved',
                    found.skipped == 0 and done == load.windows),
        Requirement(f'estimates within {SOON:.0f} s: >= {SHARE:.0%}', f'{soon:.2%}', soon >= SHARE),
        Requirement('exit codes 0', ', '.join(map(str, found.codes)), not any(found.codes)),
    ]  # fmt: skip
    median, high, most = np.quantile(latencies, (0.5, SHARE, 1.0))
    return filled(
        'fleet/report',
        requirements=requirements(asked),
        begun='in one moment' if load.at_once else 'spread over one period',
        median=median,
        share=SHARE,
        high=high,
        most=most,
        pss=pss,
        late=1e3 * found.late,
        processes=table(
            {
                'process': name, 'resident, MB': f'{each.rss:.0f}',
                'share of it, MB': f'{each.pss:.0f}', 'cores': f'{each.share:.2f}',
            }
            for name, each in found.processes.items()
        ),
    )  # fmt: skip
