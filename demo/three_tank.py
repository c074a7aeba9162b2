"""Simulator and estimator as two real processes on three tanks whose valves close step by step.

Shows progress, prints every window's estimates beside the truth and writes demo.png.
"""

import argparse
import os
import sys
import time
from collections.abc import Callable
from functools import partial

import rclpy
from rclpy.executors import SingleThreadedExecutor

from demo.picture import draw
from demo.processes import executable
from demo.recorder import Recorder, Vector

WINDOW = 1000.0  # s
WINDOWS = 3
LIMITS = {'p': 0.01, 'h': 0.5}  # errors that the demo promises at 40 dB, by first letter
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
    try:
        with (
            executable('estimator', {'model': 'three_tank', 'window.duration': WINDOW}),
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
        for window in range(1, WINDOWS + 1):
            spin_until(
                f'estimate of window {window}',
                partial(recorder.has_estimates, window),
                lambda: bar(recorder.plant_time, WINDOWS * WINDOW),
            )
            good &= report(recorder, window)
        draw(recorder, picture)
        print(f'picture: {picture}')
        if not good:
            print(f'demo: an estimate is off; last word: {recorder.verdict}', file=sys.stderr)
        return good
    finally:
        executor.shutdown()
        recorder.destroy_node()
        rclpy.try_shutdown()


def report(recorder: Recorder, window: int) -> bool:
    """Print one window's estimates beside the truth; return whether all are as near as promised."""
    stamp = sorted(recorder.received['parameters'])[window - 1]
    print(f'\n\nwindow {window}, up to {stamp / 1e9:g} s   estimate      truth      error')
    good = True
    for estimate, truth in (
        (recorder.received['parameters'][stamp], parameters_before(recorder, stamp)),
        (recorder.received['state'][stamp], recorder.received['truth'][stamp]),
    ):
        for name, value in estimate.items():
            error = value - truth[name]
            near = abs(error) <= LIMITS[name[0]]
            good &= near
            remark = '' if near else f'   more than {LIMITS[name[0]]:g} off'
            print(f'{name:>25} {value:10.5f} {truth[name]:10.5f} {error:+10.5f}{remark}')
    return good


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
