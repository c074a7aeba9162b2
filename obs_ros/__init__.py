"""Live estimation of hidden states and drifting parameters. Imports and runs without ROS."""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from obs_ros.core.estimate import Estimate, Outcome
    from obs_ros.core.model import Model, Variable
    from obs_ros.core.record import Record, Sample
    from obs_ros.horizon.solve import solve_window
    from obs_ros.models import load_model
    from obs_ros.observers.base import load_observer
    from obs_ros.samples.window import SlidingWindow

__all__ = [
    'Estimate',
    'Model',
    'Outcome',
    'Record',
    'Sample',
    'SlidingWindow',
    'Variable',
    'load_model',
    'load_observer',
    'solve_window',
]

_HOMES = {
    'core.estimate': ('Estimate', 'Outcome'),
    'core.model': ('Model', 'Variable'),
    'models': ('load_model',),
    'observers.base': ('load_observer',),
    'core.record': ('Record', 'Sample'),
    'horizon.solve': ('solve_window',),
    'samples.window': ('SlidingWindow',),
}


def __getattr__(name: str) -> Any:
    # Imported when asked for: SciPy and Numba take a second, in which Ctrl-C must work already.
    for module, names in _HOMES.items():
        if name in names:
            return getattr(importlib.import_module(f'obs_ros.{module}'), name)
    raise AttributeError(f'module {__name__!r} has no attribute {name!r}')
