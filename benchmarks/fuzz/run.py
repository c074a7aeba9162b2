"""Random malformed messages, thousands of them: the estimator counts them all and lives on.

Names, sizes, values and stamps are drawn at random, mostly absurd; in the end a sound run follows,
and its estimate must be right.
"""

import math
import random
import time
from collections.abc import Mapping
from typing import Any, NamedTuple

from benchmarks.common import Progress, machine, mark, options, publish, table
from benchmarks.live import Live
from benchmarks.soak.run import INPUT, OUTPUT, samples

NAMES = (*OUTPUT, *INPUT, 'h3', 'p1', '', 'h1 ', 'ĥ1', 'h' * 1000, '\n', '{}', '%s')
VALUES = (math.nan, math.inf, -math.inf, 1e308, -1e308, 5e-324, 0.0, -0.0, 1e20, 1.0, -7.5)
SECONDS = (0, -1, 1, -(2**31), 2**31 - 1, 1_700_000_000)
NANOSECONDS = (0, 999_999_999, 1_000_000_000, 2**32 - 1)
BATCH, PAUSE = 200, 0.2  # messages; s after them, as queues are bounded
DURATION = 300  # samples of the sound run, at its end
EPOCH = 2**31 * 10**9 - 10**15  # ns; later than the others, and still a stamp


class Fuzzed(NamedTuple):
    """What came of it; `published` are the estimates while it went on, `last` the one after."""

    sent: int
    figures: Mapping[str, str]
    published: int
    non_finite: int
    last: Mapping[str, float]
    code: int
    traceback: bool

    @property
    def uncounted(self) -> int:
        """Messages that the node has not counted as received."""
        return self.sent - sum(int(self.figures[f'{s}.received']) for s in ('output', 'input'))


def main(arguments: list[str] | None = None) -> Fuzzed:
    """Measure, print, and write the report."""
    parser = options(__doc__)
    parser.add_argument('--messages', type=int, default=20_000)
    parser.add_argument('--seed', type=int, default=0)
    parser.add_argument('--domain', type=int, default=90, help='ROS domain id')
    chosen = parser.parse_args(arguments)
    live = Live(chosen.domain, 'window.duration:=20.0')
    found = fuzzed(live, chosen.messages, random.Random(chosen.seed))
    publish(chosen.results, 'fuzz', f'{found.sent} malformed messages', report(found), machine())
    return found


def fuzzed(live: Live, count: int, rng: random.Random) -> Fuzzed:
    """Send malformed messages, then a sound run, and end the node."""
    estimates: list[Any] = []
    live.listen('/estimator/parameters', estimates.append)
    progress, sent = Progress('fuzz', count), 0

    def received() -> bool:
        return sent == sum(int(live.figures[f'{s}.received']) for s in ('output', 'input'))

    for k in range(count):
        live.publishers[rng.choice(('output', 'input'))].publish(malformed(rng))
        sent += 1
        progress.step()
        if k % BATCH == BATCH - 1:
            live.spin()
            time.sleep(PAUSE)
    live.spin_until(received, 60.0)
    during = len(estimates)
    for stamp, u, y in samples(DURATION):
        live.send('input', EPOCH + stamp, INPUT, u)
        live.send('output', EPOCH + stamp, OUTPUT, y)
        sent += 2
        time.sleep(0.005)  # in a burst, one stream would be read long before the other
    live.spin_until(received, 60.0)
    live.spin_until(lambda: estimates and estimates[-1].header.stamp.sec >= EPOCH // 10**9, 30.0)
    figures = dict(live.figures)
    code, written, _ = live.close()
    last = dict(zip(estimates[-1].name, estimates[-1].position, strict=True)) if estimates else {}
    odd = sum(not math.isfinite(v) for estimate in estimates for v in estimate.position)
    return Fuzzed(sent, figures, during, odd, last, code, 'Traceback' in written)


def malformed(rng: random.Random) -> Any:
    """Return a JointState that is wrong in one way or another; now and then it is none."""
    from sensor_msgs.msg import JointState

    message = JointState()
    message.header.frame_id = rng.choice(('', 'world', 'x' * 300))
    message.header.stamp.sec = rng.choice((*SECONDS, rng.randrange(-(2**31), 2**31)))
    message.header.stamp.nanosec = rng.choice((*NANOSECONDS, rng.randrange(2**32)))
    kind = rng.randrange(4)
    if kind == 0:
        message.name = [rng.choice(NAMES) for _ in range(rng.randrange(6))]
        message.position = [rng.choice(VALUES) for _ in range(rng.randrange(6))]
    else:
        message.name = list(OUTPUT if kind < 3 else INPUT)
        rng.shuffle(message.name)
        message.position = [rng.choice((*VALUES, rng.uniform(0, 100))) for _ in message.name]
    if rng.random() < 0.2:
        message.velocity = [rng.choice(VALUES) for _ in range(rng.randrange(4))]
        message.effort = [rng.choice(VALUES) for _ in range(rng.randrange(4))]
    return message


def report(found: Fuzzed) -> list[str]:
    """Return the parts of the report."""
    failed = found.figures['failed']
    alive = found.code == 0 and not found.traceback
    rows = [
        ('messages, malformed and sound', found.sent, '>= 10000', mark(found.sent >= 10_000)),
        ('not counted', found.uncounted, '0', mark(found.uncounted == 0)),
        ('errors of the observer', failed, '0', mark(failed == '0')),
        ('published numbers not finite', found.non_finite, '0', mark(found.non_finite == 0)),
        ('estimate afterwards', bool(found.last), 'True', mark(bool(found.last))),
        ('exit code', found.code, '0', mark(alive)),
    ]
    prefixes = ('samples.', 'output.', 'input.')
    counts = {
        k: v for k, v in found.figures.items()
        if k.startswith(prefixes) and v.isdecimal() and v != '0'
    }  # fmt: skip
    return [
        table(('figure', 'measured', 'wanted', 'holds'), rows),
        table(('counted by the node', 'value'), sorted(counts.items())),
        'Estimate after the sound run: '
        + ', '.join(f'{name} {value:.3f}' for name, value in found.last.items()),
    ]
