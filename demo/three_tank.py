"""Simulator and estimator as two real processes on three tanks whose valves close step by step.

Shows progress, prints estimates beside the truth and every jump found, and writes demo.png.
"""

import argparse
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from enum import Enum

import rclpy
from rclpy.executors import SingleThreadedExecutor

from demo.domain import Domain
from demo.jumps import found_as_true, merged
from demo.picture import draw
from demo.processes import executable
from demo.recorder import Recorder, Vector, intervals_of

DURATION, WINDOW, PERIOD = 3000.0, 300.0, 50.0  # s
SHOWN = 5  # one window of so many is printed
JUMPS = {1000.0: {'p1', 'p2'}, 2000.0: {'p1', 'p3'}}  # s: parameters that the scenario moves
DEADLINE = 60.0  # s of wall time for one window, which takes 0.03 s of a quiet machine
PATIENCE = 600.0  # s of wall time for each stage, as much as a busy machine may need


@dataclass(frozen=True)
class Promise:
    """Limits within which the demo is well, for measurements of 40 dB."""

    opening: float = 0.01  # error of a valve's opening (1)
    level: float = 0.5  # error of a level (cm)
    deviations: float = 3.0  # error otherwise: a window just after a jump says that it knows little
    most_unsure: float = 0.1  # of all estimates: further off than that, and say so
    least_vouched: float = 0.5  # of all estimates: else the machine is too slow, or a part broken

    def limit(self, name: str) -> float:
        """Return the error allowed to a level (`h...`) or an opening."""
        return self.level if name.startswith('h') else self.opening


PROMISE = Promise()


def main() -> int:
    """Run the demo; 0 when every estimate came, as near the truth as promised or as it says."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument('--speed', type=float, default=150.0, help='times real time')
    options.add_argument('--seed', type=int, default=1, help='of the measurement noise')
    options.add_argument('--picture', default='demo.png', help='file to write')
    chosen = options.parse_args()
    os.environ.setdefault('AMENT_PREFIX_PATH', sys.prefix)  # as `make demo` has it
    simulator = {'scenario': 'three_tank', 'speed': chosen.speed, 'seed': chosen.seed}
    # The plant waits for the estimates: let a busy machine finish each.
    windows = {'window.duration': WINDOW, 'window.period': PERIOD, 'deadline': DEADLINE}
    try:
        with (
            own_domain(),
            executable('estimator', {'model': 'three_tank', **windows}),
            executable('simulator', {**simulator, 'enabled': 'false'}),
        ):
            good = watch(chosen.picture)
    except KeyboardInterrupt:
        print('\nstopped')
        return 130
    except (RuntimeError, TimeoutError) as error:
        print(f'demo: {error}', file=sys.stderr)
        return 1
    return 0 if good else 1


@contextmanager
def own_domain() -> Iterator[None]:
    """Claim a domain, on this machine only: other ROS systems neither see nor disturb it."""
    with Domain() as number:
        os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
        os.environ['ROS_DOMAIN_ID'] = str(number)
        yield


def watch(picture: str) -> bool:
    """Follow the two nodes through all windows; return whether every estimate is near the truth."""
    rclpy.init()
    recorder = Recorder()
    executor = SingleThreadedExecutor()
    executor.add_node(recorder)

    def spin_until(what: str, predicate: Callable[[], bool], show: Callable[[], str]) -> None:
        end = time.monotonic() + PATIENCE
        while not predicate():
            if time.monotonic() > end:
                raise TimeoutError(f'{what} did not happen within {PATIENCE:g} s')
            executor.spin_once(timeout_sec=0.05)
            tell(show())

    try:
        began = time.monotonic()
        spin_until(
            'start of both nodes',
            lambda: recorder.connected,
            lambda: 'starting the nodes and compiling the model (seconds; the first time longer)',
        )
        print(f'\nboth nodes are up after {time.monotonic() - began:.1f} s')
        recorder.start_plant()
        seen: list[int] = []
        judged: list[Judgement] = []

        def news() -> bool:
            recorder.pace(WINDOW, PERIOD)
            return recorder.estimates() != seen

        while not seen or seen[-1] < DURATION * 1e9:
            spin_until(
                'the next estimate',
                news,
                lambda: bar(recorder.plant_time, DURATION),
            )
            for stamp in recorder.estimates()[len(seen) :]:
                judged.append(report(recorder, stamp, shown=len(seen) % SHOWN == 0))
                seen.append(stamp)
        jumps_are_right = report_jumps(recorder)
        draw(recorder, picture)
        print(f'picture: {picture}')
        return conclude(recorder, seen, judged) and jumps_are_right
    finally:
        executor.shutdown()
        recorder.destroy_node()
        rclpy.try_shutdown()


class Judgement(Enum):
    """Verdict on one window's estimates, beside the truth."""

    NEAR = 'as near as promised, or withheld by the node itself'
    UNSURE = 'further off, but within what its own deviations say'
    OFF = 'further off than it says'


def report(recorder: Recorder, stamp: int, *, shown: bool) -> Judgement:
    """Print the estimates at a window's end (ns) beside the truth, if `shown` or one is off.

    Return how near they are.
    """
    verdict = recorder.verdicts[stamp]
    rows, judgement = [], Judgement.NEAR
    for topic, truth in (
        ('parameters', parameters_before(recorder, stamp)),
        ('state', recorder.received['truth'][stamp]),
    ):
        deviations = recorder.received[f'{topic}_stddev'][stamp]
        intervals = intervals_of(recorder, topic, stamp)
        for name, value in recorder.received[topic][stamp].items():
            error = value - truth[name]
            limit, deviation, remark = PROMISE.limit(name), deviations[name], ''
            if not abs(error) <= limit:
                remark = f'   more than {limit:g} off'
                if not abs(error) <= PROMISE.deviations * deviation:
                    judgement = Judgement.OFF
                elif judgement is Judgement.NEAR:
                    judgement = Judgement.UNSURE
            lower, upper = intervals[name]
            rows.append(
                f'{name:>25} {value:10.5f} {truth[name]:10.5f} {error:+10.5f} '
                f'{lower:10.5f} {upper:10.5f}{remark}'
            )
    if not verdict.vouched:
        judgement = Judgement.NEAR
    if shown or judgement is not Judgement.NEAR:
        head = 'estimate      truth      error        95 % interval'
        print(f'\n\nwindow up to {stamp / 1e9:4.0f} s         {head}', *rows, sep='\n')
        if not verdict.vouched:
            print(f'{"withheld by the node":>25}: {verdict.outcome}: {verdict.message}')
    return judgement


def report_jumps(recorder: Recorder) -> bool:
    """Print what was found to have jumped; return whether that is just what did."""
    print('\n\nfound to have jumped, ± 2 sd')
    found = merged(recorder.jumps)
    for time_found, jump in found:
        print(f'{time_found:15.2f} s: {jump}')
    good = found_as_true(found, JUMPS)
    if not good:
        true = '; '.join(f'{" and ".join(sorted(names))} at {t:g} s' for t, names in JUMPS.items())
        print(f'demo: these are not the jumps that there were: {true}', file=sys.stderr)
    return good


def conclude(recorder: Recorder, seen: list[int], judged: list[Judgement]) -> bool:
    """Say which windows were off, with the node's word on each; return whether all is well."""
    vouched = sum(recorder.verdicts[stamp].vouched for stamp in seen)
    unsure = judged.count(Judgement.UNSURE)
    print(f'{len(seen)} estimates, {vouched} of which the node stands by')
    if unsure:
        within = f'within {PROMISE.deviations:g} of their own deviations'
        print(f'{unsure} further off than promised, and {within}')
    off = [s for s, judgement in zip(seen, judged, strict=True) if judgement is Judgement.OFF]
    for stamp in off:
        verdict = recorder.verdicts[stamp]
        print(
            f'demo: the window up to {stamp / 1e9:g} s is off, and says '
            f'{verdict.outcome}: {verdict.message}',
            file=sys.stderr,
        )
    if unsure > PROMISE.most_unsure * len(seen):
        print(f'demo: {unsure} of {len(seen)} estimates are too unsure', file=sys.stderr)
        return False
    if vouched >= PROMISE.least_vouched * len(seen):
        return not off
    last = next(recorder.verdicts[s] for s in reversed(seen) if not recorder.verdicts[s].vouched)
    print(
        f'demo: the node stands by too few; its last doubt: {last.outcome}: {last.message}',
        file=sys.stderr,
    )
    return False


def parameters_before(recorder: Recorder, stamp: int) -> Vector:
    """Return the true parameters inside the window that ends at `stamp`, where they may change."""
    history = recorder.received['true_parameters']
    return history[max(s for s in history if s < stamp)]


def bar(now: float, end: float, width: int = 40) -> str:
    """Return a progress bar over plant time."""
    done = min(width, int(width * now / end))
    return f'[{"#" * done}{"." * (width - done)}] {min(now, end):5.0f} of {end:g} s of plant time'


def tell(text: str) -> None:
    """Show a line that the next one replaces; nothing where the output is a file."""
    if sys.stdout.isatty():
        print(f'\r{text:<78}', end='', flush=True)


if __name__ == '__main__':
    sys.exit(main())
