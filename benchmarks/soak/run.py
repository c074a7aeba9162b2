"""A long run of the estimator node, accelerated: memory that stays flat, and no sample lost.

A three-tank run is published far faster than it was sampled, windows close one after the other,
and between them the state is predicted at every output.
"""

import time
from collections.abc import Iterator, Mapping
from typing import NamedTuple

from benchmarks.common import Progress, machine, mark, options, publish, table
from benchmarks.live import Live

OUTPUT, INPUT = ('h1', 'h2'), ('Q1', 'Q2')
PERIOD = 0.1  # s of plant time
WARM_UP = 0.2  # of the run
LOOKS = 100  # at the memory
GROWTH = 0.05  # that is allowed


class Soak(NamedTuple):
    """What came of it: figures of the node, memory (MB) by share of the run, the end."""

    sent: int  # messages of each stream
    wall: float  # s
    figures: Mapping[str, str]
    memory: list[tuple[float, float]]
    code: int
    traceback: bool

    @property
    def growth(self) -> float:
        """Share by which the most memory after the warm-up exceeds that at its end."""
        after = [size for share, size in self.memory if share >= WARM_UP]
        return max(after) / after[0] - 1.0

    @property
    def lost(self) -> int:
        """Messages that never arrived, or that the node has dropped."""
        arrived = sum(int(self.figures[f'{stream}.received']) for stream in ('output', 'input'))
        dropped = sum(
            int(value) for name, value in self.figures.items() if name.startswith('samples.')
        )
        return 2 * self.sent - arrived + dropped


def main(arguments: list[str] | None = None) -> Soak:
    """Measure, print, and write the report."""
    parser = options(__doc__)
    parser.add_argument('--messages', type=int, default=1_020_000, help='in both streams together')
    parser.add_argument('--rate', type=int, default=1700, help='messages per s of wall time')
    parser.add_argument('--window', type=float, default=100.0, help='s of plant time')
    parser.add_argument('--domain', type=int, default=89, help='ROS domain id')
    chosen = parser.parse_args(arguments)
    live = Live(chosen.domain, f'window.duration:={chosen.window}')
    found = soaked(live, chosen.messages // 2, chosen.rate / 2)
    title = f'{2 * found.sent} messages through the estimator in {found.wall:.0f} s'
    publish(chosen.results, 'soak', title, report(found), machine())
    return found


def soaked(live: Live, count: int, rate: float) -> Soak:
    """Publish `count` inputs and outputs, so many a second of wall time, and end the node."""
    memory: list[tuple[float, float]] = []
    progress = Progress('soak', LOOKS)
    begin = time.monotonic()
    for k, (stamp, u, y) in enumerate(samples(count)):
        while (ahead := begin + k / rate - time.monotonic()) > 0.0:
            if ahead > 2e-4:
                time.sleep(min(ahead, 0.005))
        live.send('input', stamp, INPUT, u)
        live.send('output', stamp, OUTPUT, y)
        if k % 100 == 0:
            live.spin()
        if (k + 1) * LOOKS // count > k * LOOKS // count:
            memory.append(((k + 1) / count, live.memory()))
            progress.step()
    wall = time.monotonic() - begin
    live.spin_until(lambda: live.figures.get('input.received') == str(count), 20.0)
    told = live.told
    live.spin_until(lambda: live.told > told + 1, 10.0)
    figures = dict(live.figures)
    code, written, _ = live.close()
    return Soak(count, wall, figures, memory, code, 'Traceback' in written)


def samples(count: int) -> Iterator[tuple[int, tuple[float, ...], tuple[float, ...]]]:
    """Yield stamps (ns), inputs and outputs of the three-tank scenario."""
    from plant_sim.scenarios import load_scenario
    from plant_sim.simulation import Simulation

    simulation = Simulation(load_scenario('three_tank'), period=PERIOD)
    for _ in range(count):
        instant = simulation.sample()
        yield round(instant.t * 1e9), instant.u, instant.y


def report(found: Soak) -> list[str]:
    """Return the parts of the report."""
    end = found.memory[-1][1]
    after = [size for share, size in found.memory if share >= WARM_UP]
    kept = {k: v for k, v in found.figures.items() if k.startswith('samples.') and v != '0'}
    rows = [
        ('messages', 2 * found.sent, '>= 1000000', mark(2 * found.sent >= 1_000_000)),
        ('lost or dropped', found.lost, '0', mark(found.lost == 0)),
        (
            f'memory growth after {WARM_UP:.0%} of the run', f'{found.growth:.1%}',
            f'< {GROWTH:.0%}', mark(found.growth < GROWTH),
        ),
        ('exit code', found.code, '0', mark(found.code == 0 and not found.traceback)),
    ]  # fmt: skip
    told = ('published', 'withheld', 'failed', 'skipped', 'predicted', 'prediction_latency_s')
    return [
        table(('figure', 'measured', 'wanted', 'holds'), rows),
        f'Resident memory {after[0]:.1f} MB after the warm-up, {max(after):.1f} MB at most since, '
        f'{end:.1f} MB in the end.',
        table(
            ('of the node', 'value'),
            [(name, found.figures.get(name, '-')) for name in told] + sorted(kept.items()),
        ),
    ]
