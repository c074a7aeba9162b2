"""The executables' first lines, light enough that Ctrl-C works from the start."""

import importlib
import os
import signal
import sys
import warnings


def estimator() -> int:
    """Run the estimator node."""
    return _node('obs_ros.ros.estimator', 'obs_ros.interface.usage')


def fleet() -> int:
    """Run a fleet of estimator nodes."""
    return _node('obs_ros.ros.fleet', 'obs_ros.interface.fleet')


def simulator() -> int:
    """Run the simulator node."""
    return _node('plant_sim.node', 'plant_sim.settings')


def view() -> int:
    """Run the live page's node."""
    return _node('obs_ros.ros.view', 'obs_ros.pages.settings')


def check_model() -> int:
    """Look at a model, without ROS."""
    return _run('obs_ros.cli.check_model')


def init() -> int:
    """Write a package for a plant, without ROS."""
    return _run('obs_ros.cli.init')


def replay() -> int:
    """Run the observer over recordings, without ROS."""
    return _run('obs_ros.cli.replay')


def _node(module: str, settings: str) -> int:
    """Run a node, or print its usage, for which no ROS is needed."""
    own = sys.argv[1:]
    if '--ros-args' in own:
        own = own[: own.index('--ros-args')]
    if {'-h', '--help'} & set(own):
        print(importlib.import_module(settings).usage(), end='')
        return 0
    return _run(module)


def _run(module: str) -> int:
    # Importing ROS takes seconds; until it handles signals there is nothing to clean up.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: os._exit(0))
    # The bits of long sums depend on the number of threads of linear algebra: one, on any machine,
    # in nodes, replays and their workers alike. It is read when NumPy is loaded.
    for library in ('OPENBLAS', 'OMP', 'MKL'):
        os.environ.setdefault(f'{library}_NUM_THREADS', '1')
    # NumPy's and SciPy's of numbers that are not finite: an estimate says so itself.
    warnings.simplefilter('ignore', RuntimeWarning)
    return int(importlib.import_module(module).main())
