"""Simulator and estimator as two real processes on three tanks whose valves close step by step.

Shows progress, prints estimates beside the truth and every jump found, and writes demo.png.
"""

import argparse
import os
import sys
import time
from collections.abc import Callable

import rclpy
from rclpy.executors import SingleThreadedExecutor

from demo.picture import draw
from demo.processes import executable
from demo.recorder import Recorder, Vector

DURATION, WINDOW, PERIOD = 3000.0, 300.0, 50.0  # s
SHOWN = 5  # one window of so many is printed
LIMITS = {'p': 0.01, 'h': 0.5}  # errors that the demo promises at 40 dB, by first letter
JUMPS = {1000.0: {'p1', 'p2'}, 2000.0: {'p1', 'p3'}}  # s: what the scenario moves
JUMP_LIMIT = 1.0  # s
PATIENCE = 60.0  # s of wall time for each stage


def main() -> int:
    """Run the demo; 0 when every estimate came and was as near the truth as promised."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument('--speed', type=float, default=150.0, help='times real time')
    options.add_argument('--seed', type=int, default=1, help='of the measurement noise')
    options.add_argument('--picture', default='demo.png', help='file to write')
    chosen = options.parse_args()
    # A domain of its own, on this machine only: other ROS systems neither see nor disturb it.
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    os.environ['ROS_DOMAIN_ID'] = str(1 + os.getpid() % 100)
    simulator = {'scenario': 'three_tank', 'speed': chosen.speed, 'seed': chosen.seed}
    windows = {'window.duration': WINDOW, 'window.period': PERIOD}
    try:
        with (
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
        good = True
        seen: list[int] = []
        while not seen or seen[-1] < DURATION * 1e9:
            spin_until(
                'the next estimate',
                lambda: recorder.estimates() != seen,
                lambda: bar(recorder.plant_time, DURATION),
            )
            for stamp in recorder.estimates()[len(seen) :]:
                good &= report(recorder, stamp, shown=len(seen) % SHOWN == 0)
                seen.append(stamp)
        good &= report_jumps(recorder)
        draw(recorder, picture)
        print(f'picture: {picture}')
        if not good:
            print(f'demo: an estimate is off; last word: {recorder.verdict}', file=sys.stderr)
        return good
    finally:
        executor.shutdown()
        recorder.destroy_node()
        rclpy.try_shutdown()


def report(recorder: Recorder, stamp: int, *, shown: bool) -> bool:
    """Print the estimates at a window's end (ns) beside the truth, if `shown` or one is off.

    Return whether all are as near as promised.
    """
    rows, good = [], True
    for topic, truth in (
        ('parameters', parameters_before(recorder, stamp)),
        ('state', recorder.received['truth'][stamp]),
    ):
        deviations = recorder.received[f'{topic}_stddev'][stamp]
        for name, value in recorder.received[topic][stamp].items():
            error = value - truth[name]
            near = abs(error) <= LIMITS[name[0]]
            good &= near
            remark = '' if near else f'   more than {LIMITS[name[0]]:g} off'
            rows.append(
                f'{name:>25} {value:10.5f} {truth[name]:10.5f} {error:+10.5f} '
                f'{2.0 * deviations[name]:10.5f}{remark}'
            )
    if shown or not good:
        head = 'estimate      truth      error       2 sd'
        print(f'\n\nwindow up to {stamp / 1e9:4.0f} s         {head}', *rows, sep='\n')
    return good


def report_jumps(recorder: Recorder) -> bool:
    """Print what was found to have jumped; return whether that is just what did."""
    print('\n\nfound to have jumped')
    found = []
    for stamp, sizes in sorted(recorder.received['jump'].items()):
        words = ', '.join(f'{name} by {size:+.4f}' for name, size in sizes.items())
        print(f'{stamp / 1e9:15.2f} s: {words}')
        found.append((stamp / 1e9, set(sizes)))
    return len(found) == len(JUMPS) and all(
        abs(time - true) <= JUMP_LIMIT and names == jumped
        for (time, names), (true, jumped) in zip(found, JUMPS.items(), strict=True)
    )


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
