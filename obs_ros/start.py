"""The executables' first lines, light enough that Ctrl-C works from the start."""

import importlib
import os
import signal


def estimator() -> int:
    """Run the estimator node."""
    return _run('obs_ros.node.estimator')


def simulator() -> int:
    """Run the simulator node."""
    return _run('plant_sim.node')


def check_model() -> int:
    """Look at a model, without ROS."""
    return _run('obs_ros.check_model')


def replay() -> int:
    """Run the observer over a recording, without ROS."""
    return _run('obs_ros.replay.command')


def _run(module: str) -> int:
    # Importing ROS takes seconds; until it handles signals there is nothing to clean up.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: os._exit(0))
    return int(importlib.import_module(module).main())
